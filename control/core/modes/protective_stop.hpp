// PROTECTIVE_STOP: ramp to zero, then hold with the drives enabled, until it is acknowledged. A falling patient is held, never let roll.
#pragma once
#include "control/core/modes/mode.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct ProtectiveStopMode {
  static constexpr contract::Mode kMode = contract::Mode::protective_stop;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& state, double /*dt_s*/) noexcept { return {0, 0, state.in_mode.braking, false}; }
};

}  // namespace hoist::core
