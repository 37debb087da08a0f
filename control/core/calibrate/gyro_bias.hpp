// The chassis gyroscope at rest: its turn rate is its bias. The tilt filters have converged when their angles no longer drift.
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"

namespace hoist::core {

/// Consumer gyroscopes are within 1 degree a second at power-on (firmware/sim/imu.hpp); more than 2.5 is a broken one.
inline constexpr double kGyroBiasLargest_rad_s = 0.0436332313;
/// Largest difference between the mean angles of both halves; at more, the filter is still estimating its bias (equation 14 needs 15 s).
inline constexpr double kGyroDriftLargest_rad = 0.00175;

/// yaw_rad_s: mean turn rate at rest; drift_rad: the largest drift of any tilt angle within that time.
[[nodiscard]] inline Outcome gyro_bias(double yaw_rad_s, double drift_rad) noexcept {
  if (!(std::fabs(drift_rad) <= kGyroDriftLargest_rad)) return no_outcome(contract::CalibrationReason::still_settling);
  if (!(std::fabs(yaw_rad_s) <= kGyroBiasLargest_rad_s)) return no_outcome(contract::CalibrationReason::gyro_too_large);
  return {yaw_rad_s};
}

}  // namespace hoist::core
