// d and d_s of equations (1) and (3): from a bar that somebody held at measured places.
#pragma once
#include <cmath>

#include "control/core/calibrate/outcome.hpp"
#include "control/core/calibrate/pairs.hpp"

namespace hoist::core {

/// Between the furthest places, of a turned bar one end ahead of the other: less, and a millimetre of the tape is a per cent of the result.
inline constexpr double kBarWayLeast_m = 0.10;
/// How far a place may lie beside the line through all of them: a tape read by the millimetre, a bar held by hand.
inline constexpr double kBarErrorLargest_m = 0.008;
inline constexpr double kBarErrorLargest_norm = 0.012;

/// pairs: sensed = mean of tan(alpha) of both struts against the chassis, measured = metres forward of the middle. Equation (1) gives
/// metres = d x sensed; the offset takes up that nobody knows the middle exactly. `design_m` is what the strut was built to.
[[nodiscard]] inline Outcome strut_length(const MeasuredPairs& pairs, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.with_offset();
  if (!line.found || !(pairs.measured_span() >= kBarWayLeast_m)) return no_outcome(CalibrationReason::too_little);
  if (!near_design(line.slope, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kBarErrorLargest_m || std::fabs(line.offset) > 0.05) return no_outcome(CalibrationReason::disagree);
  return {line.slope};
}

/// pairs: sensed = tan(alpha right) - tan(alpha left), measured = sine of the angle by which the bar was turned to the left. Struts that
/// stand d_s apart hold a bar whose one end is d_s x sine ahead of the other, and d x sensed is that way.
[[nodiscard]] inline Outcome strut_spacing(const MeasuredPairs& pairs, double strut_length_m, double design_m) noexcept {
  using contract::CalibrationReason;
  const MeasuredPairs::Line line = pairs.with_offset();
  // The way of the bar's ends as the design has it: the spacing that is looked for must not decide whether it was looked for well enough.
  if (!line.found || !(std::fabs(line.slope) > 1e-6) || !(design_m * pairs.measured_span() >= kBarWayLeast_m))
    return no_outcome(CalibrationReason::too_little);
  const double spacing_m = strut_length_m / line.slope;
  if (!near_design(spacing_m, design_m)) return no_outcome(CalibrationReason::implausible);
  if (line.largest_error > kBarErrorLargest_norm || std::fabs(line.offset) > 0.08) return no_outcome(CalibrationReason::disagree);
  return {spacing_m};
}

}  // namespace hoist::core
