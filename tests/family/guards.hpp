// The trade-off of each guard: its monitor runs many times over beside the hoist, each with another value of one threshold, while the guards
// in force are as lax as their ranges allow. What each would have stopped is counted, and how far a falling body had come.
#pragma once
#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/family/falls.hpp"

namespace hoist::family {

/// One threshold of one guard, and the values that are tried.
struct GuardRow {
  std::string_view guard;
  contract::ParamName param;
  std::string_view what;
  double unit;                 ///< what one of the printed unit is in the parameter's
  std::string_view printed;    ///< that unit
  std::vector<double> values;  ///< printed
  bool fall;                   ///< judged by falls with a direction; otherwise by faints straight down
};
[[nodiscard]] const std::vector<GuardRow>& guard_rows();

struct GuardPoint {
  double value = 0;
  double hours = 0;
  int false_stops = 0;
  int falls = 0, in_time = 0;
  double worst_lean_rad = 0;  ///< largest lean of a body at the alarm
  double worst_after_s = 0;   ///< longest from the fall's first moment
};
using GuardCurve = std::vector<GuardPoint>;

/// The parameters with every guard as lax as allowed.
[[nodiscard]] contract::Params lax_guards();
/// One walk, all rows and values at once; added to `curves` (one for each row).
void watch_walk(const WalkOptions& options, std::vector<GuardCurve>& curves);
void watch_fall(const WalkOptions& options, FallKind kind, std::vector<GuardCurve>& curves);
[[nodiscard]] std::vector<GuardCurve> empty_curves();

}  // namespace hoist::family
