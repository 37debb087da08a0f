#include "tests/chaos/judge/settings.hpp"

#include <bit>
#include <cmath>

namespace hoist::chaos {

void Settings::sent(const contract::CanFrame& frame) {
  constexpr std::uint8_t kFourBytes = 0x23;  // a download of four bytes in one frame
  if (frame.dlc != 8 || frame.data[0] != kFourBytes) return;
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) {
    if (frame.id != contract::canopen::kSdoRequestBase + contract::node_id(static_cast<contract::Node>(n))) continue;
    for (std::size_t i = 0; i < contract::kParamObjects.size(); ++i) {
      const contract::ParamObject& object = contract::kParamObjects[i];
      if (object.kind == contract::kNodes[n].kind && contract::read_le(&frame.data[1], 2) == object.index && frame.data[3] == object.sub)
        written_[n][i] = {contract::read_le(&frame.data[4], 4), true};
    }
  }
}

std::optional<contract::ParamName> Settings::stale(const contract::Params& in_force) const {
  for (const auto& node : written_)
    for (std::size_t i = 0; i < node.size(); ++i) {
      const contract::ParamObject& object = contract::kParamObjects[i];
      const std::size_t row = contract::param_index(object.param);
      if (!node[i].known || contract::kParams[row].edit == contract::EditRule::live) continue;
      const double value = contract::get_param(in_force, row);
      // Whole numbers and single precision, as the dictionary has the objects.
      const bool same = node[i].word == std::bit_cast<std::uint32_t>(static_cast<float>(value)) ||
                        node[i].word == static_cast<std::uint32_t>(std::lround(std::fabs(value)));
      if (!same) return object.param;
    }
  return std::nullopt;
}

}  // namespace hoist::chaos
