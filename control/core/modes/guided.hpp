// GUIDED: the hoist follows a path while the therapist holds the dead-man. Without a path it stands.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct GuidedMode {
  static constexpr contract::Mode kMode = contract::Mode::guided;

  static void enter(CoreState& state) noexcept { state.remote.begin(state.time_ns, state.params.remote_stop_age_s); }
  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    const bool led = state.lease.holder != 0 && state.lease.epoch == state.motion.epoch && state.server.alive();
    if (!led) state.motion.leaving = true;
    return {0, 0, Braking::remote, state.motion.leaving && at_rest(state)};
  }
};

}  // namespace hoist::core
