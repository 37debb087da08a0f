#include "db/metrics/paired_test.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace hoist::db {

namespace {

// Twice the rank of each difference by its size, so that shared ranks are whole numbers.
std::vector<std::uint64_t> twice_ranks(const std::vector<double>& differences) {
  std::vector<std::uint64_t> ranks;
  for (const double one : differences) {
    std::uint64_t smaller = 0, equal = 0;
    for (const double other : differences) {
      // Values of two printed decimals: what differs by rounding only is equal.
      const double by = std::fabs(other) - std::fabs(one);
      const bool same = std::fabs(by) <= 1e-9 * std::fabs(one);
      equal += same ? 1 : 0;
      smaller += !same && by < 0 ? 1 : 0;
    }
    ranks.push_back(2 * smaller + equal + 1);
  }
  return ranks;
}

}  // namespace

PairedTest paired_test(std::span<const std::optional<double>> first, std::span<const std::optional<double>> second) {
  PairedTest out;
  std::vector<double> differences;
  for (std::size_t i = 0; i < std::min(first.size(), second.size()); ++i) {
    if (!first[i] || !second[i]) continue;
    ++out.pairs;
    out.mean_first += *first[i];
    out.mean_second += *second[i];
    if (*second[i] != *first[i]) differences.push_back(*second[i] - *first[i]);
    out.up += *second[i] > *first[i] ? 1 : 0;
    out.down += *second[i] < *first[i] ? 1 : 0;
  }
  if (out.pairs > 0) out.mean_first /= static_cast<double>(out.pairs), out.mean_second /= static_cast<double>(out.pairs);
  if (differences.empty() || differences.size() > kMostPairs) return out;
  const std::vector<std::uint64_t> ranks = twice_ranks(differences);
  std::uint64_t all = 0, upward = 0;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    all += ranks[i];
    upward += differences[i] > 0 ? ranks[i] : 0;
  }
  // How many choices of signs give each sum.
  std::vector<double> ways(all + 1, 0.0);
  ways[0] = 1;
  for (const std::uint64_t rank : ranks)
    for (std::size_t sum = all; sum + 1 > rank; --sum) ways[sum] += ways[sum - rank];
  const std::uint64_t edge = std::min(upward, all - upward);
  double tail = 0;
  for (std::size_t sum = 0; sum <= all; ++sum) tail += std::min<std::uint64_t>(sum, all - sum) <= edge ? ways[sum] : 0.0;
  out.p = std::min(1.0, tail / std::exp2(static_cast<double>(ranks.size())));
  return out;
}

}  // namespace hoist::db
