#include "control/core/tick.hpp"

#include <cstddef>

#include "control/contract/can_dictionary.hpp"

namespace hoist::core {

namespace {
// The host's heartbeat: 100 ms, a tenth of a second in steps.
constexpr std::uint64_t kHeartbeatTicks = 10;
}  // namespace

void tick(CoreState& state, const TickInputs& inputs, double dt_s, TickOutputs& out) noexcept {
  namespace canopen = contract::canopen;
  out.frames.clear();
  out.events.clear();
  out.record = {};
  out.params_changed = false;
  static_cast<void>(dt_s);
  state.started = true;
  out.record.tick = inputs.tick;
  out.record.time_ns = inputs.time_ns;
  out.record.parameter_version = static_cast<std::uint32_t>(state.parameter_version);
  if (inputs.tick % kHeartbeatTicks == 0)
    static_cast<void>(out.frames.push_back(canopen::heartbeat(contract::node_id(contract::Node::core), canopen::NmtState::operational)));
  static_cast<void>(out.frames.push_back(canopen::sync()));
}

bool load_params(CoreState& state, const contract::Params& params) noexcept {
  if (state.started || contract::check_param_set(params) != nullptr) return false;
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::check_param(i, contract::get_param(params, i)) != contract::ParamCheck::ok) return false;
  state.params = params;
  return true;
}

}  // namespace hoist::core
