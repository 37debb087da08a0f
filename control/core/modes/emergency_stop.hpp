// EMERGENCY_STOP: hardware has cut the motors' power. The core commands nothing, clears its memory of motion and frees
// the lease. INIT follows once the chain is closed and the stop is acknowledged.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct EmergencyStopMode {
  static constexpr contract::Mode kMode = contract::Mode::emergency_stop;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& /*state*/, double /*dt_s*/) noexcept { return {}; }
};

}  // namespace hoist::core
