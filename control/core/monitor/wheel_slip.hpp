// H10: the wheels slip, as the track of encoders and gyroscope finds (estimate/fused_odometry.hpp). A short slip is only marked and the
// track repaired; one that lasts means that the hoist no longer does what it is told, and it stops gently.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class WheelSlip {
 public:
  static constexpr contract::Fault kFault = contract::Fault::wheel_slip;

  bool check(const MonitorView& view) noexcept {
    // With the drives off the hoist may be lifted, turned and carried.
    if (!view.powered) return false;
    return view.sensed.fused.slip_ticks() * view.dt_s >= hold<kFault, "lasting">(view.params.slip_stop_s) - view.dt_s / 2;
  }
};

}  // namespace hoist::core
