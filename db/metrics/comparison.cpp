#include "db/metrics/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "db/metrics/cross_correlation.hpp"

namespace hoist::db {

namespace {

/// A lap begins and ends this close to its place on the figure: the projection of a walk that ends on the mark may stay just before it.
constexpr double kAtPlace_m = 0.01;

// Where on the figure the walk began; nothing when that is not clear.
std::optional<double> start_of(const contract::ReferencePath& path, const Walk& walk) {
  constexpr double kBegin_m = 0.25, kBegin_rad = 0.5;
  const contract::PathPose first{walk.x_m.front(), walk.y_m.front(), walk.psi_rad.front(), 0.0};
  if (!walk.from_mark) return place_on(path, first);
  const contract::PathPose start = path.pose(0.0);
  const bool there = std::hypot(first.x_m - start.x_m, first.y_m - start.y_m) <= kBegin_m &&
                     std::fabs(wrap_angle_rad(first.psi_rad - start.psi_rad)) <= kBegin_rad;
  return there ? std::optional{0.0} : std::nullopt;
}

void add_deviations(const Walk& walk, Comparison& out) {
  const ReferenceColumns& reference = out.reference;
  double squares = 0;
  for (std::size_t i = 0; i < walk.count(); ++i) {
    const double x_m = walk.x_m[i] - reference.x_m[i], y_m = walk.y_m[i] - reference.y_m[i];
    squares += x_m * x_m + y_m * y_m;
    out.distance_m.push_back(std::hypot(x_m, y_m));
    out.lateral_m.push_back(y_m * std::cos(reference.psi_rad[i]) - x_m * std::sin(reference.psi_rad[i]));
    out.heading_rad.push_back(wrap_angle_rad(walk.psi_rad[i] - reference.psi_rad[i]));
  }
  out.position_rms_m = std::sqrt(squares / static_cast<double>(walk.count()));
}

// From leaving the start to coming to it again, by the clock: pauses count.
void add_laps(const Walk& walk, Comparison& out) {
  const std::vector<double>& s_m = out.reference.s_m;
  std::size_t begin = 0;
  while (begin + 1 < s_m.size() && s_m[begin + 1] <= out.start_m + kAtPlace_m) ++begin;
  for (std::size_t i = begin; i < s_m.size(); ++i) {
    const double end_m = out.start_m + static_cast<double>(out.lap_s.size() + 1) * out.lap_m - kAtPlace_m;
    if (s_m[i] < end_m) continue;
    out.lap_s.push_back(static_cast<double>(walk.tick[i] - walk.tick[begin]) * kSample_s);
    begin = i;
  }
}

}  // namespace

Comparison compare(const Walk& walk) {
  Comparison out;
  const auto none = [&out](NoFigure why) {
    out.why = why;
    return out;
  };
  if (!walk.path) return none(NoFigure::no_exercise);
  if (walk.count() == 0) return none(NoFigure::no_motion);
  if (walk.several_walks) return none(NoFigure::several_walks);
  if (missing_s(walk) > kMissingMost_s) return none(NoFigure::part_missing);
  if (!walk.path->valid()) return none(NoFigure::not_comparable);
  const std::optional<double> start_m = start_of(*walk.path, walk);
  if (!start_m) return none(NoFigure::start_unclear);
  out.start_m = *start_m;
  const RunColumns run{kSample_s, walk.x_m, walk.y_m, walk.psi_rad, walk.dpsi_rad, walk.tick, out.start_m};
  std::optional<Evaluation> evaluation = evaluate(*walk.path, run, contract::kProjectionWindow_m, &out.reference);
  if (!evaluation) return none(NoFigure::not_comparable);
  out.c = evaluation->c;
  out.best = best_lag(walk.dpsi_rad, out.reference.omega_rad_s, kLagMost);
  out.ise = evaluation->ise;
  out.lap_m = walk.path->length_m();
  add_deviations(walk, out);
  add_laps(walk, out);
  out.why = NoFigure::none;
  return out;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

std::optional<BestLag> best_lag(std::span<const double> x, std::span<const double> y, int most) {
  const std::optional<double> at_zero = cross_correlation(x, y);
  if (!at_zero) return std::nullopt;
  const auto count = static_cast<int>(x.size());
  double x2 = 0, y2 = 0;
  for (std::size_t i = 0; i < x.size(); ++i) x2 += x[i] * x[i], y2 += y[i] * y[i];
  const double energy = std::sqrt(x2) * std::sqrt(y2);
  if (!(energy > 0) || !std::isfinite(energy)) return std::nullopt;
  BestLag best{*at_zero, 0};
  for (int lag = -most; lag <= most; ++lag) {
    double both = 0;
    for (int i = std::max(0, -lag), j = i + lag; i < std::min(count, count - lag); ++i, ++j)
      both += x[static_cast<std::size_t>(i)] * y[static_cast<std::size_t>(j)];
    // Of equally good shifts the smallest.
    if (both / energy > best.c || (both / energy == best.c && std::abs(lag) < std::abs(best.lag))) best = {both / energy, lag};
  }
  return best;
}

}  // namespace hoist::db
