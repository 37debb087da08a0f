#include "db/metrics/learning.hpp"

#include <algorithm>
#include <map>
#include <vector>

namespace hoist::db {
namespace {

using Visits = std::map<std::int64_t, std::vector<Measured>>;

// By how many pairs against the order chance differs from a rising row: the probability of each number, over visits of these lengths.
std::vector<double> pairs_by_chance(const Visits& visits) {
  std::vector<double> chance{1.0};
  // A walk that comes to n others may be smaller than 0 to n of them, each as likely.
  for (const auto& [id, walks] : visits)
    for (std::size_t n = 1; n < walks.size(); ++n) {
      std::vector<double> longer(chance.size() + n, 0.0);
      for (std::size_t i = 0; i < chance.size(); ++i)
        for (std::size_t more = 0; more <= n; ++more) longer[i + more] += chance[i] / static_cast<double>(n + 1);
      chance = std::move(longer);
    }
  return chance;
}

// Of N sorted slopes the 95 % interval leaves so many out at each end; none when already the outermost are inside.
std::optional<std::size_t> left_out(const std::vector<double>& chance) {
  constexpr double kOneSide = 0.025;
  std::size_t pairs = 0;
  for (double sum = chance[0]; sum <= kOneSide; sum += chance[pairs]) ++pairs;
  return pairs == 0 ? std::nullopt : std::optional(pairs - 1);
}

}  // namespace

Learning learning_of(std::span<const Measured> values) {
  Visits visits;
  for (const Measured& one : values) visits[one.visit].push_back(one);
  std::erase_if(visits, [](const auto& visit) { return visit.second.size() < 2; });
  Learning out{.visits = visits.size()};
  std::vector<double> slopes;
  for (const auto& [id, walks] : visits) {
    out.walks += walks.size();
    for (std::size_t later = 1; later < walks.size(); ++later)
      for (std::size_t earlier = 0; earlier < later; ++earlier)
        slopes.push_back((walks[later].value - walks[earlier].value) / static_cast<double>(walks[later].place - walks[earlier].place));
  }
  const auto outside = left_out(pairs_by_chance(visits));
  if (!outside) {
    out.why = NoChange::few_walks;
    return out;
  }
  std::ranges::sort(slopes);
  const std::size_t half = slopes.size() / 2;
  out.slope = Slope{.middle = slopes.size() % 2 == 1 ? slopes[half] : (slopes[half - 1] + slopes[half]) / 2,
                    .low = slopes[*outside],
                    .high = slopes[slopes.size() - 1 - *outside]};
  if (out.slope->low <= 0 && out.slope->high >= 0) out.why = NoChange::no_slope;
  return out;
}

}  // namespace hoist::db
