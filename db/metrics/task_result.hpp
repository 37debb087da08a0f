// What came of a clinical task: the walk from its first movement to the task's end.
#pragma once
#include <optional>

#include "db/metrics/comparison.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

struct TaskResult {
  NoFigure why = NoFigure::no_task;  ///< none: the task was done; absent below is what it does not measure
  std::optional<double> time_s;      ///< of a task that ends by way or turn
  std::optional<double> distance_m;  ///< of a task that ends by time
  std::optional<double> timed_speed_m_s;
  std::optional<double> out_s, turning_s, back_s;
};
[[nodiscard]] TaskResult task_result_of(const Walk& walk, const Comparison& comparison);

}  // namespace hoist::db
