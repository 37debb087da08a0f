// The stride, from the sideways sway of the harness: it repeats once a stride (Moe-Nilssen & Helbostad 2004).
#pragma once
#include <vector>

#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// Strides below which cadence and regularity, and those below which variability and asymmetry are not given.
inline constexpr std::size_t kFewestStrides = 8, kFewestForSpread = 20;
/// A sway smaller than this, root mean square, or less alike from stride to stride (autocorrelation), shows no stride.
inline constexpr double kLeastSway_m = 0.002, kLeastRegularity = 0.3;
/// Of each bout, this much at both ends is setting off and stopping.
inline constexpr double kSettle_s = 2.0;

struct Rhythm {
  NoFigure why = NoFigure::no_motion;  ///< none: the next three are there
  double stride_s = 0;                 ///< first main peak of the autocorrelation A
  double stride_regularity = 0;        ///< A(T) / A(0)
  double step_regularity = 0;          ///< |A(T/2)| / A(0): half a stride later the sway is on the other side
  std::vector<double> strides_s;       ///< of each stride, by upward crossings of the middle
  /// How much longer the mean stride takes from right to left than back, as a share of their mean.
  double asymmetry = 0;
  NoFigure why_no_spread = NoFigure::no_motion;  ///< none: strides_s and asymmetry may be used
};
[[nodiscard]] Rhythm rhythm_of(const Walk& walk, const std::vector<Stretch>& bouts);

}  // namespace hoist::db
