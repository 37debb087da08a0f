// What came of a clinical task: the walk from its first movement to the task's end. Samples come one by one, none is kept.
#pragma once
#include <cstdint>
#include <optional>

#include "control/contract/reference_path.hpp"
#include "db/metrics/comparison.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/task_end.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// The task that the session is a repetition of, as it was recorded.
struct WalkTask {
  TaskEnd ends{};
  double goal = 0, edge_m = 0;
};

/// Walk, turn, walk back: up to this much off the first heading is the way out, from this much on the way back.
inline constexpr double kTaskOutHeading_deg = 20, kTaskBackHeading_deg = 160;

struct TaskResult {
  NoFigure why = NoFigure::no_task;  ///< none: the task was done; absent below is what it does not measure
  std::optional<double> time_s;      ///< of a task that ends by its line, a turn or coming back
  std::optional<double> distance_m;  ///< of a task that ends by time
  std::optional<double> timed_speed_m_s;
  std::optional<double> out_s, turning_s, back_s;
  NoFigure why_no_phases = NoFigure::no_task;  ///< where the last three are absent
};

/// When a quantity that falls reaches zero: between two recorded steps by its size, so that steps that are missing there shift the moment by
/// little.
class Crossing {
 public:
  /// `before`: the step recorded before `tick`.
  void add(double left, std::uint64_t before, std::uint64_t tick) {
    if (!at_ && left <= 0)
      at_ = left_ ? static_cast<double>(before) + static_cast<double>(tick - before) * *left_ / (*left_ - left) : static_cast<double>(tick);
    left_ = left;
  }
  [[nodiscard]] const std::optional<double>& at() const { return at_; }

 private:
  std::optional<double> left_, at_;  // the latest size; a step
};

class TaskJudge {
 public:
  TaskJudge(const std::optional<WalkTask>& task, const std::optional<contract::ReferencePath>& path);
  /// The next sample that counts; `s_m`: its place along the exercise, absent where it has none; `before`: the step recorded before it, in any
  /// mode.
  void add(const WalkSample& sample, const std::optional<double>& s_m, std::uint64_t before);
  [[nodiscard]] TaskResult result(const Walk& walk, const Comparison& comparison) const;

 private:
  // Falls to zero at the end; nothing where that is not known.
  [[nodiscard]] std::optional<double> left_to_end(const WalkSample& sample, const std::optional<double>& s_m);
  [[nodiscard]] static double seconds_between(double from, double to) { return (to - from) * kSample_s; }
  [[nodiscard]] NoFigure why_not(const Walk& walk, const Comparison& comparison) const;

  std::optional<WalkTask> task_;
  double lap_m_ = 0;
  std::optional<double> begun_;  // a step
  Crossing end_;
  WalkSample first_;  // of the first movement
  double way_m_ = 0;
  bool far_ = false;
  Crossing edge_, far_edge_;
  std::optional<double> out_;  // last step in the heading of the way out
  Crossing back_;              // into that of the way back
};

}  // namespace hoist::db
