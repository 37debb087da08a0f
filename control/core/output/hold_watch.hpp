// H2: last resort of PROTECTIVE_STOP. When the hoist does not come to rest, a servo has failed: both drives are
// switched off and the holding brakes stop the hoist. Not while a motor brakes its turning wheel harder than they would, nor for a wheel whose
// drive is off or silent: then a body that hangs in the stops moves the hoist, and would move it farther. While both wheels tell of standing,
// the chassis' gyroscope alone is enough, because an encoder may have failed; not one that has an alarm of its own.
#pragma once
#include <cmath>
#include <cstdint>
#include <utility>

#include "control/core/base/lasting.hpp"
#include "control/core/estimate/driven_wheel.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/output/limiter.hpp"

namespace hoist::core {

class HoldWatch {
 public:
  /// Once in every step of PROTECTIVE_STOP. True in the step in which the drives are to be let go; from then on `cut` holds until the mode
  /// is left.
  [[nodiscard]] bool step(const Limiter& limiter, const Estimate& sensed, bool gyroscope_sound) noexcept {
    if (cut_) return false;
    const bool should_stand = commanded_rest_.step(limiter.at_rest(), kHoldTicks);
    const bool keeps_moving = moving_.step(moves(sensed, gyroscope_sound), kMovingTicks);
    cut_ = should_stand && keeps_moving;
    return cut_;
  }

  [[nodiscard]] bool cut() const noexcept { return cut_; }

 private:
  // The ramp takes v / a; a second after its end even a wheel that was fought over stands.
  static constexpr std::uint8_t kHoldTicks = 100;
  // A push at a standing hoist is usually shorter than this.
  static constexpr std::uint8_t kMovingTicks = 30;
  static constexpr double kWheel_m_s = 0.05;
  // A wheel whose encoder is dead is seen by the chassis' gyro alone: 0.05 m/s at one wheel of 0.7 m track is 4 degrees per second. The
  // gyro's own offset, less what calibration found, is below one.
  static constexpr double kTurn_rad_s = 0.07;

  [[nodiscard]] static bool moves(const Estimate& sensed, bool gyroscope_sound) noexcept {
    // With both drives already off (emergency stop) there is nothing to switch off, and pushing the hoist away is no
    // fault.
    if (!sensed.left_drive.enabled() && !sensed.right_drive.enabled()) return false;
    const auto faster = [](double x, double limit) { return !(std::fabs(x) <= limit); };
    bool pushed = false;
    for (const auto& [drive, wheel_m_s] :
         {std::pair{&sensed.left_drive, sensed.odometry.wheel_left_m_s}, std::pair{&sensed.right_drive, sensed.odometry.wheel_right_m_s}}) {
      if (!drive->fresh().lost()) {
        if (!faster(wheel_m_s, kWheel_m_s)) continue;
        if (drive->works() && !motor_brakes(*drive, wheel_m_s)) return true;
      }
      pushed = true;
    }
    return !pushed && gyroscope_sound && !sensed.base.rates_fresh().lost() && faster(sensed.base.yaw_rate_rad_s(), kTurn_rad_s);
  }

  Lasting commanded_rest_, moving_;
  bool cut_ = false;
};

}  // namespace hoist::core
