// Hazard table 2.3, any mode to EMERGENCY_STOP: the emergency stop chain has opened, which takes the power off the motors by hardware (R4).
// Reported by the input node, or by both drives whose supply is gone while the batteries are good: a relay that opened
// without a report.
#pragma once
#include "control/core/base/lasting.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

/// Both drives report that their supply is gone, and it is not the batteries.
[[nodiscard]] inline bool motors_unpowered(const Estimate& sensed) noexcept {
  constexpr contract::Fault kFault = contract::Fault::emergency_stop;
  // Half of a discharged battery: no load sags that far. The drives switch themselves off at 19 V (SOURCES 2.2, H12).
  constexpr double kGone_v = 12.0;
  constexpr double kGood_v = 20.0;
  const auto gone = [](const DriveSensor& drive) {
    return drive.supply_known() && drive.supply_v() < threshold<kFault, "supply gone", Laxer::lower>(kGone_v);
  };
  // Batteries that have not reported yet read 0 V: not good.
  return !sensed.io.fresh().lost() && sensed.io.battery_a_v() + sensed.io.battery_b_v() > threshold<kFault, "batteries good">(kGood_v) &&
         gone(sensed.left_drive) && gone(sensed.right_drive);
}

class EmergencyStopOpen {
 public:
  static constexpr contract::Fault kFault = contract::Fault::emergency_stop;

  bool check(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    // A silent input node says nothing about the chain: its last report holds, and its silence is another fault.
    if (!sensed.io.fresh().lost()) open_ = sensed.io.emergency_stop_open();
    // In INIT the relay may not have been closed yet, and what the core has opened itself has an alarm of its own. An input node that has
    // come back feeds the relay again within this time.
    const bool unpowered = view.mode != contract::Mode::init && !view.relay_cut && motors_unpowered(sensed);
    const bool lasts = unpowered_.step(unpowered, hold<kFault, "unpowered">(kUnpoweredTicks));
    return open_ || lasts;
  }

 private:
  static constexpr std::uint8_t kUnpoweredTicks = 100;

  Lasting unpowered_;
  bool open_ = false;
};

}  // namespace hoist::core
