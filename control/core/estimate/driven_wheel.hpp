// Tells a wheel that is turned by its motor from one that is pushed, dragged or rolls downhill.
//
// A hand, a patient or a slope turns the motor as a generator: while its bridge is off no current flows at all, and while its servo holds or
// brakes the current opposes the motion. Only a motor that is fed draws current along its motion. So the sign of the current decides,
// not the speed: a hoist that is pushed at walking pace is as fast as a runaway motor (0.64 m/s at full duty).
#pragma once
#include <cmath>

#include "control/core/base/mutation.hpp"
#include "control/core/estimate/drive_sensor.hpp"

namespace hoist::core {

/// A slower wheel counts as standing for the runaway rules: what a motor reaches against the closed brake at a fifth of
/// full duty.
inline constexpr double kDriven_m_s = 0.05;
/// The least current of a motor that turns a wheel against its closed brake is 2.6 A (8.9 N m through gear 30 at 0.115 N m/A); the drive's
/// current sensor may be off by 0.6 A before its self-test fails (firmware/nodes/drive).
inline constexpr double kDriven_a = 1.0;

/// The same as a mean over kFed_s, of a wheel that turns: a body that pushes nearly as hard as the brake holds leaves the motor little to do, and
/// 0.3 A are 10 N at the wheel. Half of what a sensor may be off at its self-test, which then takes it off; a mean leaves little of its noise.
inline constexpr double kFed_a = 0.3, kFed_s = 0.1;

/// A motor whose current opposes the motion by more than this brakes harder than the holding brake would: 8.0 N m through gear 30 at
/// 0.115 N m/A are 2.3 A.
inline constexpr double kBrakes_a = 3.0;

/// A wheel generates 0.115 V s/rad through gear 30 on 0.10 m. Less 7 % for wheel, motor and readings; full duty turns it at 0.86 of the supply.
inline constexpr double kGenerates_v_s_m = 34.5, kFeedsFrom_norm = 0.93;

/// The wheel is faster than its command, and its motor pushes it that way. A silent drive is no evidence: its silence is a fault of its own.
[[nodiscard]] inline bool motor_drives(const DriveSensor& drive, double wheel_m_s, double command_m_s) noexcept {
  constexpr contract::Fault kFault = contract::Fault::overspeed;
  if (drive.fresh().lost()) return false;
  const double along_a = wheel_m_s > 0 ? drive.current_a() : -drive.current_a();
  return std::fabs(wheel_m_s) > std::fabs(command_m_s) + threshold<kFault, "driven_speed">(kDriven_m_s) &&
         along_a > threshold<kFault, "driven_current">(kDriven_a);
}

/// A wheel that something pushes faster generates more than the supply and feeds it through the diodes of a bridge that is off.
[[nodiscard]] inline double feeds_from_m_s(const DriveSensor& drive) noexcept {
  return std::fmax(kDriven_m_s, drive.supply_known() ? kFeedsFrom_norm * drive.supply_v() / kGenerates_v_s_m : 0.0);
}

/// A current through a bridge that is off: shorted transistors. One that feeds the supply is none: the wheel is pushed, and the current opposes its
/// motion. A slower wheel does not excuse a current of either sign, since its encoder may have failed or count backwards.
[[nodiscard]] inline bool stray_current(const DriveSensor& drive, double wheel_m_s) noexcept {
  constexpr contract::Fault kFault = contract::Fault::overspeed;
  if (drive.fresh().lost() || drive.works()) return false;
  const bool feeds_back = std::fabs(wheel_m_s) > feeds_from_m_s(drive) && (drive.current_a() > 0) != (wheel_m_s > 0);
  return !feeds_back && std::fabs(drive.current_a()) > threshold<kFault, "stray_current">(kDriven_a);
}

/// The same for a small current that lasts, through the bridge of a wheel that turns no faster than a motor is fed to.
class FedWheel {
 public:
  /// Once in every step.
  [[nodiscard]] bool step(const DriveSensor& drive, double wheel_m_s, double dt_s) noexcept {
    constexpr contract::Fault kFault = contract::Fault::overspeed;
    if (drive.fresh().lost() || drive.works()) {
      mean_a_ = 0;
      return false;
    }
    // More is stray_current's. A serial line has no checksum: one damaged current must not last.
    mean_a_ += (std::fmax(-kDriven_a, std::fmin(drive.current_a(), kDriven_a)) - mean_a_) * (dt_s / kFed_s);
    return std::fabs(mean_a_) > threshold<kFault, "fed_current">(kFed_a) && std::fabs(wheel_m_s) > kDriven_m_s &&
           std::fabs(wheel_m_s) <= feeds_from_m_s(drive);
  }

 private:
  double mean_a_ = 0;
};

/// The motor of a drive that reports brakes this turning wheel harder than the holding brake would. Then a body or a hand is what turns it, and
/// would turn it faster without the motor.
[[nodiscard]] inline bool motor_brakes(const DriveSensor& drive, double wheel_m_s) noexcept {
  const double against_a = wheel_m_s > 0 ? -drive.current_a() : drive.current_a();
  return drive.works() && against_a > kBrakes_a;
}

}  // namespace hoist::core
