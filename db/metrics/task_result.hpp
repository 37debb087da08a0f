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
};

class TaskJudge {
 public:
  TaskJudge(const std::optional<WalkTask>& task, const std::optional<contract::ReferencePath>& path);
  /// The next sample that counts; `s_m`: its place along the exercise, absent where it has none.
  void add(const WalkSample& sample, const std::optional<double>& s_m);
  [[nodiscard]] TaskResult result(const Walk& walk, const Comparison& comparison) const;

 private:
  using Moment = std::optional<std::uint64_t>;  // a step
  [[nodiscard]] bool at_end(const WalkSample& sample, const std::optional<double>& s_m);
  [[nodiscard]] static double seconds_between(std::uint64_t from, std::uint64_t to) { return static_cast<double>(to - from) * kSample_s; }
  [[nodiscard]] NoFigure why_not(const Walk& walk, const Comparison& comparison) const;

  std::optional<WalkTask> task_;
  double lap_m_ = 0;
  Moment begun_, end_;
  WalkSample first_;  // of the first movement
  double way_m_ = 0;
  bool far_ = false;
  Moment edge_, far_edge_;  // first sample beyond these places
  Moment out_, back_;       // last one in the heading of the way out, first one in that of the way back
};

}  // namespace hoist::db
