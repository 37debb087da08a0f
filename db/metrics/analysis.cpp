#include "db/metrics/analysis.hpp"

#include <algorithm>
#include <utility>

namespace hoist::db {

Analysis analyse(Walk walk) {
  Analysis out;
  out.walk = std::move(walk);
  out.comparison = compare(out.walk);
  out.bouts = bouts_of(out.walk);
  out.rhythm = rhythm_of(out.walk, out.bouts);
  out.turns = turns_of(out.walk);
  out.task = task_result_of(out.walk, out.comparison);
  out.lead = lead_of(out.walk, out.bouts);
  return out;
}

std::span<const double> Analysis::longest_bout_m_s() const {
  const auto longest = std::ranges::max_element(bouts, {}, &Stretch::count);
  if (longest == bouts.end()) return {};
  return std::span(walk.speed_m_s).subspan(longest->first, longest->count());
}

}  // namespace hoist::db
