// Figures of repeated measurements.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace hoist::bench {

// The smallest value that at least the share `p` (0 to 1) of the values does not exceed (nearest rank). NaN without values.
inline double percentile(std::vector<double> values, double p) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(p * static_cast<double>(values.size()));
  const auto at = static_cast<std::size_t>(std::clamp(rank, 1.0, static_cast<double>(values.size()))) - 1;
  return values[at];
}
inline double median(std::vector<double> values) { return percentile(std::move(values), 0.5); }

}  // namespace hoist::bench
