// Hold-to-run in REMOTE and GUIDED: held, released, ageing, lost (hazards H17 to H21).
#pragma once
#include "control/core/modes/mode.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct Hand {
  bool leaving = false;   // the mode ends: brake as state.in_mode.braking says until the hoist stands
  bool held = false;      // held, and the stick has been at its middle since the mode began
  double fresh_norm = 0;  // share of the wished speed: falls with the age of the last command
};

/// Evaluates hold-to-run once per step. Commands age (RemoteDrive::age_s): from remote_slow_age_s the speed falls, at
/// remote_stop_age_s the mode ends. It also ends when the client that began it no longer holds the lease or cannot be
/// reached.
[[nodiscard]] inline Hand feel_hand(CoreState& state) noexcept {
  const contract::Params& p = state.params;
  InMode& in_mode = state.in_mode;
  const double age_s = state.remote.age_s(state.time_ns);
  bool gone = state.lease.holder == 0 || state.lease.epoch != in_mode.epoch || !state.server.alive();
  if (state.remote.held() && age_s >= p.remote_stop_age_s) {
    state.remote.lose();
    if (!in_mode.leaving) in_mode.remote_lost = true;
    gone = true;
  }
  if (gone) {
    in_mode.leaving = true;
    if (in_mode.braking < Braking::remote) in_mode.braking = Braking::remote;
  }
  // A release always brakes at its full rate, also when something else ends the mode: a second reason never makes a stop gentler.
  if (in_mode.leaving && !state.remote.held() && in_mode.braking < Braking::remote) in_mode.braking = Braking::remote;
  if (in_mode.leaving) return {true, false, 0};
  if (!state.remote.held() || state.remote.awaits_neutral()) return {};
  const double fresh_norm =
      age_s <= p.remote_slow_age_s ? 1.0 : (p.remote_stop_age_s - age_s) / (p.remote_stop_age_s - p.remote_slow_age_s);
  return {false, true, fresh_norm};
}

}  // namespace hoist::core
