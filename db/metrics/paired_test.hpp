// Whether two columns of a table differ: Wilcoxon's signed rank test of the pairs.
#pragma once
#include <cstddef>
#include <optional>
#include <span>

namespace hoist::db {

struct PairedTest {
  std::size_t pairs = 0;  ///< that have both values
  std::size_t up = 0, down = 0;
  double mean_first = 0, mean_second = 0;  ///< of these pairs
  /// Two-sided, exact: of all signs that the differences might have had, the share with a rank sum as far from the middle. Equal differences
  /// share their ranks, pairs without a difference are left out (Wilcoxon 1945). None without a difference, and for more than kMostPairs.
  std::optional<double> p;
};
inline constexpr std::size_t kMostPairs = 24;

/// Both of one length; what is missing in one is no pair.
[[nodiscard]] PairedTest paired_test(std::span<const std::optional<double>> first, std::span<const std::optional<double>> second);

}  // namespace hoist::db
