#include "db/metrics/turns.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::db {

namespace {
constexpr std::size_t kHalf = 25;  // samples: a quarter of a second
constexpr auto kHesitation = samples_in(kHesitation_s);

bool alike(double a, double b) { return (a > 0) == (b > 0); }

// Parts of one stretch in which the rate stays beyond the edge, of one sign, hesitations bridged.
std::vector<Stretch> parts_of(const std::vector<double>& rate_rad_s, const Stretch& whole) {
  std::vector<Stretch> parts;
  for (std::size_t i = whole.first; i < whole.end; ++i) {
    if (std::fabs(rate_rad_s[i]) <= kTurnEdge_rad_s) continue;
    const bool goes_on = !parts.empty() && i - parts.back().end < kHesitation && alike(rate_rad_s[parts.back().end - 1], rate_rad_s[i]);
    if (!goes_on) parts.push_back({i, i});
    parts.back().end = i + 1;
  }
  return parts;
}
}  // namespace

std::vector<double> turn_rate_of(const Walk& walk) {
  std::vector<double> rate_rad_s(walk.count(), 0.0);
  for (const Stretch& whole : whole_stretches(walk))
    for (std::size_t i = whole.first + kHalf; i + kHalf < whole.end; ++i)
      rate_rad_s[i] = (walk.psi_rad[i + kHalf] - walk.psi_rad[i - kHalf]) / (2.0 * static_cast<double>(kHalf) * kSample_s);
  return rate_rad_s;
}

std::vector<Turn> turns_of(const Walk& walk) {
  const std::vector<double> rate_rad_s = turn_rate_of(walk);
  std::vector<Turn> turns;
  for (const Stretch& whole : whole_stretches(walk)) {
    for (const Stretch& part : parts_of(rate_rad_s, whole)) {
      double peak_rad_s = 0;
      for (std::size_t i = part.first; i < part.end; ++i) peak_rad_s = std::max(peak_rad_s, std::fabs(rate_rad_s[i]));
      const double angle_rad = walk.psi_rad[part.end - 1] - walk.psi_rad[part.first];
      if (peak_rad_s > kTurnPeak_rad_s && std::fabs(angle_rad) > kTurnLeast_rad) turns.push_back({part, angle_rad});
    }
  }
  return turns;
}

}  // namespace hoist::db
