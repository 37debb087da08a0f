// A walk with everything that more than one figure needs, computed once.
#pragma once
#include <vector>

#include "db/metrics/bouts.hpp"
#include "db/metrics/comparison.hpp"
#include "db/metrics/lead.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/rhythm.hpp"
#include "db/metrics/task_result.hpp"
#include "db/metrics/turns.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

struct Analysis {
  Walk walk;
  Comparison comparison;
  std::vector<Stretch> bouts;
  Rhythm rhythm;
  std::vector<Turn> turns;
  TaskResult task;
  Lead lead;

  /// The longest bout; empty for none.
  [[nodiscard]] std::span<const double> longest_bout_m_s() const;
};
[[nodiscard]] Analysis analyse(Walk walk);

}  // namespace hoist::db
