#include "db/metrics/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "db/metrics/cross_correlation.hpp"

namespace hoist::db {

namespace {

/// Longest run that is resampled: a day at 100 Hz. A wrong dt must not request unlimited memory.
constexpr double kLongestRun_s = 86'400.0;

bool all_finite(std::span<const double> column) {
  return std::all_of(column.begin(), column.end(), [](double x) { return std::isfinite(x); });
}

bool usable(const contract::ReferencePath& path, const RunColumns& run) {
  const std::size_t count = run.x_m.size();
  return path.valid() && run.dt_s > 0.0 && std::isfinite(run.dt_s) && count > 0 && run.y_m.size() == count && run.psi_rad.size() == count &&
         run.dpsi_rad.size() == count && (run.tick.empty() || run.tick.size() == count) && all_finite(run.x_m) && all_finite(run.y_m) &&
         all_finite(run.psi_rad) && all_finite(run.dpsi_rad);
}

std::vector<double> resample(std::span<const double> column, double from_dt_s, double to_dt_s, std::size_t count) {
  std::vector<double> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double at = static_cast<double>(i) * to_dt_s / from_dt_s;
    const auto before = std::min(static_cast<std::size_t>(at), column.size() - 1);
    const auto after = std::min(before + 1, column.size() - 1);
    const double share = std::min(at - static_cast<double>(before), 1.0);
    out[i] = column[before] + share * (column[after] - column[before]);
  }
  return out;
}

}  // namespace

std::optional<double> place_on(const contract::ReferencePath& path, const contract::PathPose& pose) {
  constexpr double kStep_m = 0.01, kApart_m = 2.0 * contract::kProjectionWindow_m, kClear = 2.0;
  if (!path.valid()) return std::nullopt;
  const auto off = [&](double s_m) {
    const contract::PathPose at = path.pose(s_m);
    return std::hypot(pose.x_m - at.x_m, pose.y_m - at.y_m, wrap_angle_rad(pose.psi_rad - at.psi_rad));
  };
  const double length_m = path.length_m();
  double best_m = 0.0;
  for (double s_m = 0.0; s_m < length_m; s_m += kStep_m)
    if (off(s_m) < off(best_m)) best_m = s_m;
  const double best = off(best_m);
  if (!(best <= kPlaceMost)) return std::nullopt;
  for (double s_m = 0.0; s_m < length_m; s_m += kStep_m) {
    const double ahead_m = std::fabs(s_m - best_m);
    const double apart_m = path.closed() ? std::min(ahead_m, length_m - ahead_m) : ahead_m;
    if (apart_m > kApart_m && off(s_m) < kClear * std::max(best, kStep_m)) return std::nullopt;
  }
  return best_m;
}

ReferenceColumns reference_of(const contract::ReferencePath& path, const RunColumns& run, double window_m) {
  const std::size_t count = std::min(run.x_m.size(), run.y_m.size());
  ReferenceColumns reference;
  for (auto* column : {&reference.s_m, &reference.x_m, &reference.y_m, &reference.psi_rad, &reference.omega_rad_s}) column->reserve(count);
  double s_m = run.start_m;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t passed = run.tick.empty() || i == 0 ? 1 : run.tick[i] - run.tick[i - 1];
    const double reach_m = passed > 1 ? window_m + std::hypot(run.x_m[i] - run.x_m[i - 1], run.y_m[i] - run.y_m[i - 1]) : window_m;
    s_m = path.project(run.x_m[i], run.y_m[i], s_m, reach_m);
    const contract::PathPose pose = path.pose(s_m);
    reference.s_m.push_back(s_m);
    reference.x_m.push_back(pose.x_m);
    reference.y_m.push_back(pose.y_m);
    reference.omega_rad_s.push_back(i == 0 ? 0.0 : (pose.psi_rad - reference.psi_rad.back()) / (run.dt_s * static_cast<double>(passed)));
    reference.psi_rad.push_back(pose.psi_rad);
  }
  return reference;
}

std::optional<Evaluation> evaluate(const contract::ReferencePath& path, const RunColumns& run, double window_m,
                                   ReferenceColumns* reference) {
  if (!usable(path, run)) return std::nullopt;
  ReferenceColumns held = reference_of(path, run, window_m);
  const Evaluation out{cross_correlation(run.dpsi_rad, held.omega_rad_s),
                       normalised_ise({run.x_m, run.y_m, run.psi_rad, held.x_m, held.y_m, held.psi_rad})};
  if (reference != nullptr) *reference = std::move(held);
  return out;
}

std::optional<Evaluation> evaluate_at_metric_rate(const contract::ReferencePath& path, const RunColumns& run, double window_m) {
  if (!usable(path, run)) return std::nullopt;
  constexpr double kMetricStep_s = 1.0 / kMetricRate_hz;
  const double duration_s = run.dt_s * static_cast<double>(run.x_m.size() - 1);
  if (duration_s > kLongestRun_s) return std::nullopt;
  const auto count = static_cast<std::size_t>(std::floor(duration_s / kMetricStep_s + 1e-6)) + 1;
  const auto x_m = resample(run.x_m, run.dt_s, kMetricStep_s, count);
  const auto y_m = resample(run.y_m, run.dt_s, kMetricStep_s, count);
  const auto psi_rad = resample(run.psi_rad, run.dt_s, kMetricStep_s, count);
  const auto dpsi_rad = resample(run.dpsi_rad, run.dt_s, kMetricStep_s, count);
  return evaluate(path, {kMetricStep_s, x_m, y_m, psi_rad, dpsi_rad, {}, run.start_m}, window_m);
}

}  // namespace hoist::db
