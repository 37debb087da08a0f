// CALIBRATE: sensors and geometry are measured by hand. The drives are off, so the hoist can be pushed once its brakes are released by
// hand; no wheel ever turns by itself here.
#pragma once
#include "control/core/modes/calibration_run.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct CalibrateMode {
  static constexpr contract::Mode kMode = contract::Mode::calibrate;

  static void enter(CoreState& /*state*/) noexcept {}

  static Wish step(CoreState& state, double dt_s) noexcept {
    // The client that began it must still hold the lease and be reachable.
    const bool led = state.lease.holder != 0 && state.lease.epoch == state.in_mode.epoch && state.server.alive();
    if (!led) state.in_mode.calibration.reason = contract::CalibrationReason::cancelled;
    if (led && advance_calibration(state, dt_s)) return {};
    return {0, 0, Braking::none, true};
  }
};

}  // namespace hoist::core
