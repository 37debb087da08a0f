#include "db/metrics/task_result.hpp"

#include <cmath>
#include <cstddef>

namespace hoist::db {

namespace {
/// The first sample from `from` on that passes; the walk's end for none.
template <class Passes>
std::size_t first_from(std::size_t from, const Walk& walk, const Passes& passes) {
  std::size_t i = from;
  while (i < walk.count() && !passes(i)) ++i;
  return i;
}

double seconds_between(const Walk& walk, std::size_t from, std::size_t to) {
  return static_cast<double>(walk.tick[to] - walk.tick[from]) * kSample_s;
}

std::size_t end_of(const Walk& walk, const Comparison& comparison) {
  const std::size_t begun = *walk.begun;
  switch (walk.task->ends) {
    case TaskEnd::distance: {
      const double there_m = walk.task->goal * comparison.lap_m - kTaskArrived_m;
      return first_from(begun, walk, [&](std::size_t i) { return comparison.reference.s_m[i] >= there_m; });
    }
    case TaskEnd::time:
      return first_from(begun, walk, [&](std::size_t i) { return seconds_between(walk, begun, i) >= walk.task->goal; });
    case TaskEnd::turn:
      return first_from(begun, walk, [&](std::size_t i) { return std::fabs(walk.psi_rad[i] - walk.psi_rad[begun]) >= walk.task->goal; });
    case TaskEnd::hand:
      break;
  }
  return walk.count() - 1;
}

NoFigure why_not(const Walk& walk, const Comparison& comparison) {
  if (!walk.task) return NoFigure::no_task;
  if (!walk.begun) return NoFigure::no_motion;
  if (walk.several_walks) return NoFigure::several_walks;
  if (!walk.from_mark) return NoFigure::not_from_start;
  if (missing_s(walk) > kMissingMost_s) return NoFigure::part_missing;
  return walk.task->ends == TaskEnd::distance ? comparison.why : NoFigure::none;
}

// The straight without its edges, where it was walked once.
void add_timed(const Walk& walk, const Comparison& comparison, TaskResult& out) {
  const double edge_m = walk.task->edge_m, timed_m = comparison.lap_m - 2 * edge_m;
  if (!(edge_m > 0) || !(timed_m > 0)) return;
  const auto at = [&](double s_m) {
    return first_from(*walk.begun, walk, [&](std::size_t i) { return comparison.reference.s_m[i] >= s_m; });
  };
  const std::size_t from = at(edge_m), to = at(comparison.lap_m - edge_m);
  if (to > from && to < walk.count()) out.timed_speed_m_s = timed_m / seconds_between(walk, from, to);
}

void add_phases(const Walk& walk, const Comparison& comparison, std::size_t end, TaskResult& out) {
  if (walk.path->shape() != contract::PathShape::kHairpin) return;
  const double line_m = walk.path->ahead(0.0).left_m;
  const auto at = [&](double s_m) {
    return first_from(*walk.begun, walk, [&](std::size_t i) { return comparison.reference.s_m[i] >= s_m; });
  };
  const std::size_t turn = at(line_m), back = at(comparison.lap_m - line_m);
  out.out_s = seconds_between(walk, *walk.begun, turn);
  out.turning_s = seconds_between(walk, turn, back);
  out.back_s = seconds_between(walk, back, end);
}
}  // namespace

TaskResult task_result_of(const Walk& walk, const Comparison& comparison) {
  TaskResult out;
  out.why = why_not(walk, comparison);
  if (out.why != NoFigure::none) return out;
  const std::size_t end = end_of(walk, comparison);
  if (end >= walk.count()) {
    out.why = NoFigure::task_unfinished;
    return out;
  }
  const TaskEnd ends = walk.task->ends;
  if (ends == TaskEnd::distance || ends == TaskEnd::turn) out.time_s = seconds_between(walk, *walk.begun, end);
  if (ends == TaskEnd::distance) {
    add_timed(walk, comparison, out);
    add_phases(walk, comparison, end, out);
  }
  if (ends == TaskEnd::time) {
    double way_m = 0;
    for (std::size_t i = *walk.begun; i < end; ++i) way_m += std::fabs(walk.speed_m_s[i]) * kSample_s;
    out.distance_m = way_m;
  }
  return out;
}

}  // namespace hoist::db
