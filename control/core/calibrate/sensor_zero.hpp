// The zero of a tilt sensor: its reading while its strut stands upright, or the chassis level (mounting error plus accelerometer offset).
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"

namespace hoist::core {

/// 3 degrees. A sensor with a larger zero is loose, or its strut does not stand upright.
inline constexpr double kZeroLargest_rad = 0.0523598776;

/// mean_rad: of an angle as sent, averaged at rest. The value is the zero to be subtracted.
[[nodiscard]] inline Outcome sensor_zero(double mean_rad) noexcept {
  if (!(std::fabs(mean_rad) <= kZeroLargest_rad)) return no_outcome(contract::CalibrationReason::zero_too_large);
  return {mean_rad};
}

}  // namespace hoist::core
