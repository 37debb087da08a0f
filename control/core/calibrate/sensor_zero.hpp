// What a tilt sensor says while its strut stands upright, or its chassis level: how it is mounted, and what its accelerometer adds.
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"

namespace hoist::core {

/// A sensor that is further off is loose, or what it sits on does not stand upright: 3 degrees.
inline constexpr double kZeroLargest_rad = 0.0523598776;

/// mean_rad: of an angle as sent, over a time at rest. The value is the zero that is to be taken off from now on.
[[nodiscard]] inline Outcome sensor_zero(double mean_rad) noexcept {
  if (!(std::fabs(mean_rad) <= kZeroLargest_rad)) return no_outcome(contract::CalibrationReason::zero_too_large);
  return {mean_rad};
}

}  // namespace hoist::core
