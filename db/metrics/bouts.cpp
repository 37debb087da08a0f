#include "db/metrics/bouts.hpp"

#include <cmath>

namespace hoist::db {

namespace {
constexpr auto kBoutSamples = samples_in(kBout_s);
}  // namespace

std::vector<Stretch> whole_stretches(const Walk& walk) {
  std::vector<Stretch> out;
  for (std::size_t i = 0; i < walk.count(); ++i) {
    if (i == 0 || walk.tick[i] != walk.tick[i - 1] + 1) out.push_back({i, i});
    out.back().end = i + 1;
  }
  return out;
}

std::vector<Stretch> bouts_of(const Walk& walk) {
  std::vector<Stretch> out;
  for (const Stretch& whole : whole_stretches(walk)) {
    Stretch bout{whole.first, whole.first};
    for (std::size_t i = whole.first; i <= whole.end; ++i) {
      if (i < whole.end && std::fabs(walk.speed_m_s[i]) > kBout_m_s) continue;
      bout.end = i;
      if (bout.count() >= kBoutSamples) out.push_back(bout);
      bout.first = i + 1;
    }
  }
  return out;
}

int pauses_between(const Walk& walk, const std::vector<Stretch>& bouts) {
  int pauses = 0;
  for (std::size_t b = 1; b < bouts.size(); ++b) {
    const std::uint64_t passed = walk.tick[bouts[b].first] - walk.tick[bouts[b - 1].end - 1] - 1;
    pauses += passed >= kBoutSamples ? 1 : 0;
  }
  return pauses;
}

}  // namespace hoist::db
