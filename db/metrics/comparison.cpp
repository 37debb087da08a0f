#include "db/metrics/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace hoist::db {

namespace {

/// A lap begins and ends this close to its place on the figure: the projection of a walk that ends on the mark may stay just before it.
constexpr double kAtPlace_m = 0.01;

// Where on the figure the walk began; nothing when that is not clear.
std::optional<double> start_of(const contract::ReferencePath& path, const WalkSample& sample, bool from_mark) {
  constexpr double kBegin_m = 0.25, kBegin_rad = 0.5;
  const contract::PathPose first{sample.x_m, sample.y_m, sample.psi_rad, 0.0};
  if (!from_mark) return place_on(path, first);
  const contract::PathPose start = path.pose(0.0);
  const bool there = std::hypot(first.x_m - start.x_m, first.y_m - start.y_m) <= kBegin_m &&
                     std::fabs(wrap_angle_rad(first.psi_rad - start.psi_rad)) <= kBegin_rad;
  return there ? std::optional{0.0} : std::nullopt;
}

}  // namespace

void BestLagSearch::add(double x, double y) {
  at_zero_.add(x, y);
  x2_ += x * x;
  y2_ += y * y;
  x_[next_] = x_[next_ + kWindow] = x;
  y_[next_] = y_[next_ + kWindow] = y;
  next_ = (next_ + 1) % kWindow;
  // Before the first sample the windows hold zeros, which add nothing.
  const double* const xs = x_.data() + next_;
  const double* const ys = y_.data() + next_;
  for (std::size_t i = 0; i < kWindow; ++i) x_before_[i] += xs[i] * y;
  for (std::size_t i = 0; i < kWindow; ++i) y_before_[i] += x * ys[i];
}

std::optional<BestLag> BestLagSearch::value() const {
  const std::optional<double> at_zero = at_zero_.value();
  const double energy = std::sqrt(x2_) * std::sqrt(y2_);
  if (!at_zero || !(energy > 0) || !std::isfinite(energy)) return std::nullopt;
  BestLag best{*at_zero, 0};
  constexpr auto kMost = static_cast<int>(kLagMost);
  for (int lag = -kMost; lag <= kMost; ++lag) {
    const auto place = static_cast<std::size_t>(kMost - std::abs(lag));
    const double c = (lag < 0 ? y_before_[place] : x_before_[place]) / energy;
    // Of equally good shifts the smallest.
    if (c > best.c || (c == best.c && std::abs(lag) < std::abs(best.lag))) best = {c, lag};
  }
  return best;
}

void Laps::add(double s_m, std::uint64_t tick) {
  left_ = left_ || s_m > start_m_ + kAtPlace_m;
  if (!begun_ || !left_) begin_tick_ = tick;
  begun_ = true;
  if (s_m < start_m_ + static_cast<double>(count_ + 1) * lap_m_ - kAtPlace_m) return;
  const double lap_s = static_cast<double>(tick - begin_tick_) * kSample_s;
  best_s_ = count_ == 0 ? lap_s : std::min(best_s_, lap_s);
  sum_s_ += lap_s;
  ++count_;
  begin_tick_ = tick;
}

std::optional<double> Comparer::add(const WalkSample& sample, bool from_mark) {
  if (!path_ || !path_->valid()) return std::nullopt;
  if (!std::exchange(begun_, true))
    if (const std::optional<double> start_m = start_of(*path_, sample, from_mark))
      run_.emplace(*path_, *start_m), run_->tick = sample.tick - 1;
  if (!run_) return std::nullopt;
  Run& run = *run_;
  const ReferencePoint& reference = run.evaluation.add({sample.x_m, sample.y_m, sample.psi_rad}, sample.dpsi_rad, sample.tick - run.tick);
  run.tick = sample.tick;
  run.end_m = reference.s_m;
  run.best.add(sample.dpsi_rad, reference.omega_rad_s);
  run.laps.add(reference.s_m, sample.tick);
  const double x_m = sample.x_m - reference.at.x_m, y_m = sample.y_m - reference.at.y_m;
  const double lateral_m = y_m * std::cos(reference.at.psi_rad) - x_m * std::sin(reference.at.psi_rad);
  const double heading_rad = wrap_angle_rad(sample.psi_rad - reference.at.psi_rad), distance_m = std::hypot(x_m, y_m);
  run.position2 += x_m * x_m + y_m * y_m;
  run.lateral2 += lateral_m * lateral_m;
  run.heading2 += heading_rad * heading_rad;
  run.distance += distance_m;
  run.distance_max = std::max(run.distance_max, distance_m);
  return reference.s_m;
}

Comparison Comparer::result(const Walk& walk) const {
  Comparison out;
  const auto none = [&out](NoFigure why) {
    out.why = why;
    return out;
  };
  if (!path_) return none(NoFigure::no_exercise);
  if (walk.samples == 0) return none(NoFigure::no_motion);
  if (walk.several_walks) return none(NoFigure::several_walks);
  if (missing_s(walk) > kMissingMost_s) return none(NoFigure::part_missing);
  if (!path_->valid()) return none(NoFigure::not_comparable);
  if (!run_) return none(NoFigure::start_unclear);
  const Run& run = *run_;
  out.start_m = run.start_m;
  const std::optional<Evaluation> evaluation = run.evaluation.value();
  if (!evaluation) return none(NoFigure::not_comparable);
  const auto samples = static_cast<double>(walk.samples);
  out.end_m = run.end_m;
  out.lap_m = path_->length_m();
  out.c = evaluation->c;
  out.best = run.best.value();
  out.ise = evaluation->ise;
  out.position_rms_m = std::sqrt(run.position2 / samples);
  out.lateral_rms_m = std::sqrt(run.lateral2 / samples);
  out.heading_rms_rad = std::sqrt(run.heading2 / samples);
  out.distance_mean_m = run.distance / samples;
  out.distance_max_m = run.distance_max;
  if (run.laps.count() > 0) out.lap_mean_s = run.laps.mean_s(), out.lap_best_s = run.laps.best_s();
  out.why = NoFigure::none;
  return out;
}

}  // namespace hoist::db
