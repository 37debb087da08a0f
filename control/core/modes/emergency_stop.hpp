// EMERGENCY_STOP: hardware has taken the power off the motors. The core can only follow: nothing is commanded, nothing is remembered, nobody
// drives. It is left to INIT by closing the chain and an acknowledgement, both.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct EmergencyStopMode {
  static constexpr contract::Mode kMode = contract::Mode::emergency_stop;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& /*state*/, double /*dt_s*/) noexcept { return {}; }
};

}  // namespace hoist::core
