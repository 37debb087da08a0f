// REMOTE: the therapist drives with a held dead-man. Commands age: from remote_slow_age_s the speed falls, at remote_stop_age_s the hoist
// stops and REMOTE ends (H17). Letting go stops and stays in REMOTE.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct RemoteMode {
  static constexpr contract::Mode kMode = contract::Mode::remote;

  static void enter(CoreState& state) noexcept { state.remote.begin(state.time_ns, state.params.remote_stop_age_s); }

  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    const contract::Params& p = state.params;
    Motion& motion = state.motion;
    const double age_s = state.remote.age_s(state.time_ns);
    if (state.remote.held() && age_s >= p.remote_stop_age_s) {
      state.remote.lose();
      if (!motion.leaving) motion.remote_lost = true;
      leave(motion);
    }
    // Whoever began to drive must still be the driver, and be reachable.
    if (state.lease.holder == 0 || state.lease.epoch != motion.epoch || !state.server.alive()) leave(motion);
    if (motion.leaving) return {0, 0, motion.braking, at_rest(state)};
    if (!motion.powered) return {};
    if (!state.remote.held() || state.remote.awaits_neutral()) return {0, 0, Braking::remote, false};
    const double fresh_norm =
        age_s <= p.remote_slow_age_s ? 1.0 : (p.remote_stop_age_s - age_s) / (p.remote_stop_age_s - p.remote_slow_age_s);
    return {state.remote.speed_norm() * p.remote_speed_m_s_max * fresh_norm,
            state.remote.yaw_norm() * p.remote_yaw_rate_rad_s_max * fresh_norm, Braking::none, false};
  }

 private:
  static void leave(Motion& motion) noexcept {
    motion.leaving = true;
    if (motion.braking < Braking::remote) motion.braking = Braking::remote;
  }
};

}  // namespace hoist::core
