#include "db/metrics/task_result.hpp"

#include <cmath>

namespace hoist::db {

namespace {
constexpr double kDegree = 3.14159265358979323846 / 180.0;
}  // namespace

TaskJudge::TaskJudge(const std::optional<WalkTask>& task, const std::optional<contract::ReferencePath>& path) : task_(task) {
  if (path) lap_m_ = path->length_m();
}

std::optional<double> TaskJudge::left_to_end(const WalkSample& sample, const std::optional<double>& s_m) {
  switch (task_->ends) {
    case TaskEnd::distance:
      if (!s_m) break;
      return task_->goal * lap_m_ - kTaskArrived_m - *s_m;
    case TaskEnd::time:
      return task_->goal - seconds_between(*begun_, static_cast<double>(sample.tick));
    case TaskEnd::turn:
      return task_->goal - std::fabs(sample.psi_rad - first_.psi_rad);
    case TaskEnd::back: {
      const double away_m = std::hypot(sample.x_m - first_.x_m, sample.y_m - first_.y_m);
      far_ = far_ || away_m >= task_->goal;
      if (!far_) break;
      return away_m - kTaskBack_m;
    }
    case TaskEnd::hand:
      break;
  }
  return std::nullopt;
}

void TaskJudge::add(const WalkSample& sample, const std::optional<double>& s_m, std::uint64_t before) {
  if (!task_) return;
  const auto tick = static_cast<double>(sample.tick);
  if (!begun_) {
    if (sample.standing_still) return;
    begun_ = tick;
    first_ = sample;
  }
  const auto add = [&](Crossing& crossing, double left) { crossing.add(left, before, sample.tick); };
  if (s_m) {
    add(edge_, task_->edge_m - *s_m);
    add(far_edge_, lap_m_ - task_->edge_m - *s_m);
  }
  const double turned_rad = std::fabs(sample.psi_rad - first_.psi_rad);
  add(back_, kTaskBackHeading_deg * kDegree - turned_rad);
  if (!back_.at() && turned_rad <= kTaskOutHeading_deg * kDegree) out_ = tick;
  if (end_.at()) return;
  if (const std::optional<double> left = left_to_end(sample, s_m)) add(end_, *left);
  if (!end_.at()) way_m_ += std::fabs(sample.speed_m_s) * kSample_s;
}

NoFigure TaskJudge::why_not(const Walk& walk, const Comparison& comparison) const {
  if (!task_) return NoFigure::no_task;
  if (!begun_) return NoFigure::no_motion;
  if (walk.several_walks) return NoFigure::several_walks;
  if (!walk.from_mark) return NoFigure::not_from_start;
  if (missing_s(walk) > kMissingMost_s) return NoFigure::part_missing;
  if (task_->ends == TaskEnd::distance && comparison.why != NoFigure::none) return comparison.why;
  return end_.at() || task_->ends == TaskEnd::hand ? NoFigure::none : NoFigure::task_unfinished;
}

TaskResult TaskJudge::result(const Walk& walk, const Comparison& comparison) const {
  TaskResult out;
  out.why = why_not(walk, comparison);
  if (out.why != NoFigure::none || !end_.at()) return out;
  const TaskEnd ends = task_->ends;
  const double end = *end_.at();
  if (ends == TaskEnd::distance || ends == TaskEnd::turn || ends == TaskEnd::back) out.time_s = seconds_between(*begun_, end);
  if (ends == TaskEnd::time) out.distance_m = way_m_;
  // The straight without its edges, where it was walked once.
  const double timed_m = lap_m_ - 2 * task_->edge_m;
  if (ends == TaskEnd::distance && task_->edge_m > 0 && timed_m > 0 && edge_.at() && far_edge_.at() && *far_edge_.at() > *edge_.at())
    out.timed_speed_m_s = timed_m / seconds_between(*edge_.at(), *far_edge_.at());
  // There and back: the turn lies between the headings of the way out and of the way back.
  if (ends == TaskEnd::back) out.why_no_phases = NoFigure::no_turn_back;
  if (ends == TaskEnd::back && back_.at() && *back_.at() < end) {
    out.out_s = seconds_between(*begun_, *out_);
    out.turning_s = seconds_between(*out_, *back_.at());
    out.back_s = seconds_between(*back_.at(), end);
  }
  return out;
}

}  // namespace hoist::db
