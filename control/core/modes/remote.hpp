// REMOTE: the therapist drives with hold-to-run held. Commands age: from remote_slow_age_s the speed falls, at
// remote_stop_age_s the hoist stops and REMOTE ends (H17). Releasing hold-to-run stops the hoist and stays in REMOTE.
#pragma once
#include "control/core/modes/hold_to_run.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/standstill.hpp"

namespace hoist::core {

struct RemoteMode {
  static constexpr contract::Mode kMode = contract::Mode::remote;

  static void enter(CoreState& state) noexcept { state.remote.begin(state.time_ns, state.params.remote_stop_age_s); }

  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    const contract::Params& p = state.params;
    const Hand hand = feel_hand(state);
    if (hand.leaving) return {0, 0, state.in_mode.braking, at_rest(state)};
    if (!state.in_mode.powered) return {};
    if (!hand.held) return {0, 0, Braking::remote, false};
    LimitedSpeed speed{state.remote.speed_norm() * p.remote_speed_m_s_max};
    speed.share(hand.fresh_norm, contract::SpeedCause::command_age);
    return {speed, state.remote.yaw_norm() * p.remote_yaw_rate_rad_s_max * hand.fresh_norm, Braking::none, false};
  }
};

}  // namespace hoist::core
