#include "db/metrics/task_result.hpp"

#include <cmath>

namespace hoist::db {

namespace {
constexpr double kDegree = 3.14159265358979323846 / 180.0;
}  // namespace

TaskJudge::TaskJudge(const std::optional<WalkTask>& task, const std::optional<contract::ReferencePath>& path) : task_(task) {
  if (path) lap_m_ = path->length_m();
}

bool TaskJudge::at_end(const WalkSample& sample, const std::optional<double>& s_m) {
  switch (task_->ends) {
    case TaskEnd::distance:
      return s_m && *s_m >= task_->goal * lap_m_ - kTaskArrived_m;
    case TaskEnd::time:
      return seconds_between(*begun_, sample.tick) >= task_->goal;
    case TaskEnd::turn:
      return std::fabs(sample.psi_rad - first_.psi_rad) >= task_->goal;
    case TaskEnd::back: {
      const double away_m = std::hypot(sample.x_m - first_.x_m, sample.y_m - first_.y_m);
      far_ = far_ || away_m >= task_->goal;
      return far_ && away_m <= kTaskBack_m;
    }
    case TaskEnd::hand:
      break;
  }
  return false;
}

void TaskJudge::add(const WalkSample& sample, const std::optional<double>& s_m) {
  if (!task_) return;
  if (!begun_) {
    if (sample.standing_still) return;
    begun_ = sample.tick;
    first_ = sample;
  }
  const auto pass = [&](Moment& moment, double place_m) {
    if (!moment && s_m && *s_m >= place_m) moment = sample.tick;
  };
  pass(edge_, task_->edge_m);
  pass(far_edge_, lap_m_ - task_->edge_m);
  const double turned_rad = std::fabs(sample.psi_rad - first_.psi_rad);
  if (!back_ && turned_rad >= kTaskBackHeading_deg * kDegree) back_ = sample.tick;
  if (!back_ && turned_rad <= kTaskOutHeading_deg * kDegree) out_ = sample.tick;
  if (end_) return;
  if (at_end(sample, s_m))
    end_ = sample.tick;
  else
    way_m_ += std::fabs(sample.speed_m_s) * kSample_s;
}

NoFigure TaskJudge::why_not(const Walk& walk, const Comparison& comparison) const {
  if (!task_) return NoFigure::no_task;
  if (!begun_) return NoFigure::no_motion;
  if (walk.several_walks) return NoFigure::several_walks;
  if (!walk.from_mark) return NoFigure::not_from_start;
  if (missing_s(walk) > kMissingMost_s) return NoFigure::part_missing;
  if (task_->ends == TaskEnd::distance && comparison.why != NoFigure::none) return comparison.why;
  return end_ || task_->ends == TaskEnd::hand ? NoFigure::none : NoFigure::task_unfinished;
}

TaskResult TaskJudge::result(const Walk& walk, const Comparison& comparison) const {
  TaskResult out;
  out.why = why_not(walk, comparison);
  if (out.why != NoFigure::none || !end_) return out;
  const TaskEnd ends = task_->ends;
  if (ends == TaskEnd::distance || ends == TaskEnd::turn || ends == TaskEnd::back) out.time_s = seconds_between(*begun_, *end_);
  if (ends == TaskEnd::time) out.distance_m = way_m_;
  // The straight without its edges, where it was walked once.
  const double timed_m = lap_m_ - 2 * task_->edge_m;
  if (ends == TaskEnd::distance && task_->edge_m > 0 && timed_m > 0 && edge_ && far_edge_ && *far_edge_ > *edge_)
    out.timed_speed_m_s = timed_m / seconds_between(*edge_, *far_edge_);
  // There and back: the turn lies between the headings of the way out and of the way back.
  if (ends == TaskEnd::back && back_ && *back_ < *end_) {
    out.out_s = seconds_between(*begun_, *out_);
    out.turning_s = seconds_between(*out_, *back_);
    out.back_s = seconds_between(*back_, *end_);
  }
  return out;
}

}  // namespace hoist::db
