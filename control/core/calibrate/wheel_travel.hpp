// Wheel radius and track width, from measured distances and turns along which the hoist is pushed.
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"
#include "control/core/calibrate/pairs.hpp"

namespace hoist::core {

/// Largest deviation of one distance or turn from the fit; a tape and a chalk line are better than this.
inline constexpr double kTravelErrorLargest_norm = 0.015;

/// Whether both wheels travelled about equally far: the hoist was pushed straight. A difference of a few per cent is what calibration corrects.
[[nodiscard]] inline bool pushed_straight(double left_m, double right_m) noexcept {
  return std::fabs(right_m - left_m) <= 0.05 + 0.05 * std::fabs(left_m + right_m);
}

/// pairs: sensed = metres for a wheel of radius 1 m (mean of both wheels, each with its correction), measured = metres by the tape.
/// Equation (19): metres = radius x sensed. `least_m` is the shortest distance of a pair.
[[nodiscard]] inline Outcome wheel_radius(const MeasuredPairs& pairs, double least_m, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.through_zero();
  if (!line.found) return no_outcome(CalibrationReason::too_little);
  if (!near_design(line.slope, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kTravelErrorLargest_norm * least_m) return no_outcome(CalibrationReason::disagree);
  return {line.slope};
}

/// pairs: sensed = metres that the right wheel went further than the left, measured = angle of the turn to the left. Equation (20):
/// angle = sensed / track.
[[nodiscard]] inline Outcome track_width(const MeasuredPairs& pairs, double least_rad, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.through_zero();
  if (!line.found || !(std::fabs(line.slope) > 1e-6)) return no_outcome(CalibrationReason::too_little);
  const double track_m = 1.0 / line.slope;
  if (!near_design(track_m, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kTravelErrorLargest_norm * least_rad) return no_outcome(CalibrationReason::disagree);
  return {track_m};
}

}  // namespace hoist::core
