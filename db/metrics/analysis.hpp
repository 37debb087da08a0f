// A walk with everything that more than one figure needs, computed once, from samples that come one by one: the memory does not grow with the walk.
#pragma once
#include <optional>

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
  BoutTotals bouts;
  Rhythm rhythm;
  TurnTotals turns;
  TaskResult task;
  Lead lead;
};

/// do { add() of every sample of the session, in order; } while (again()); then result().
class Analyser {
 public:
  /// `path`: the exercise's line; absent for free walking. `settings`: absent where they are not recorded.
  explicit Analyser(const std::optional<contract::ReferencePath>& path, const std::optional<WalkTask>& task = {},
                    const std::optional<WalkSettings>& settings = {})
      : comparer_(path), task_(task, path), lead_(settings) {}
  /// What only the recording knows of the walk: from_mark before the first sample that counts, the rest before again().
  [[nodiscard]] Walk& walk() { return out_.walk; }
  void add(const WalkSample& sample);
  /// Whether all samples are needed once more: at most nine times in all.
  bool again();
  /// Once, at the end.
  [[nodiscard]] Analysis result();

 private:
  bool first_ = true;
  std::uint64_t tick_ = 0;  // of the sample before, in any mode
  Analysis out_;
  Comparer comparer_;
  BoutFinder bouts_;
  TurnFinder turns_;
  RhythmFinder rhythm_;
  TaskJudge task_;
  LeadJudge lead_;
};

}  // namespace hoist::db
