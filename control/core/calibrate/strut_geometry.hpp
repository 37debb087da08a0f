// d and d_s of equations (1) and (3): from a bar that the operator holds at measured positions.
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"
#include "control/core/calibrate/pairs.hpp"

namespace hoist::core {

/// Shortest distance between the outermost positions (of a turned bar: of one end ahead of the other). At less, a millimetre of the tape is one
/// per cent of the result.
inline constexpr double kBarWayLeast_m = 0.10;
/// Largest distance of a position from the fitted line: the tape is read by the millimetre, the bar is held by hand.
inline constexpr double kBarErrorLargest_m = 0.008;
inline constexpr double kBarErrorLargest_norm = 0.012;

/// pairs: sensed = mean of tan(alpha) of both struts against the chassis, measured = metres forward of the middle. Equation (1) gives
/// metres = d x sensed; the offset absorbs the error of the assumed middle. `design_m` is the design value.
[[nodiscard]] inline Outcome strut_length(const MeasuredPairs& pairs, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.with_offset();
  if (!line.found || !(pairs.measured_span() >= kBarWayLeast_m)) return no_outcome(CalibrationReason::too_little);
  if (!near_design(line.slope, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kBarErrorLargest_m || std::fabs(line.offset) > 0.05) return no_outcome(CalibrationReason::disagree);
  return {line.slope};
}

/// pairs: sensed = tan(alpha right) - tan(alpha left), measured = sine of the angle by which the bar was turned to the left. With struts
/// d_s apart, one end of the bar is d_s x sine ahead of the other; d x sensed is the same distance.
[[nodiscard]] inline Outcome strut_spacing(const MeasuredPairs& pairs, double strut_length_m, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.with_offset();
  // With the design value: the unknown spacing must not decide whether the bar was turned far enough.
  if (!line.found || !(std::fabs(line.slope) > 1e-6) || !(design_m * pairs.measured_span() >= kBarWayLeast_m))
    return no_outcome(CalibrationReason::too_little);
  const double spacing_m = strut_length_m / line.slope;
  if (!near_design(spacing_m, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kBarErrorLargest_norm || std::fabs(line.offset) > 0.08) return no_outcome(CalibrationReason::disagree);
  return {spacing_m};
}

}  // namespace hoist::core
