// What the nodes were written, from the frames: each works with the value that is in force.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/params.hpp"

namespace hoist::chaos {

class Settings {
 public:
  void sent(const contract::CanFrame& frame);
  /// After a crash the core writes everything anew.
  void restart() { written_ = {}; }
  /// I10, at the start of a motion: the setting of which a node was last written another value. Not those that may change in motion: they
  /// go to their value slowly.
  [[nodiscard]] std::optional<contract::ParamName> stale(const contract::Params& in_force) const;

 private:
  struct Written {
    std::uint32_t word = 0;
    bool known = false;
  };
  std::array<std::array<Written, contract::kParamObjects.size()>, contract::kRemoteNodeCount> written_{};
};

}  // namespace hoist::chaos
