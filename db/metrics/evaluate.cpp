#include "db/metrics/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

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
         run.dpsi_rad.size() == count && all_finite(run.x_m) && all_finite(run.y_m) && all_finite(run.psi_rad) && all_finite(run.dpsi_rad);
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

const ReferencePoint& RunEvaluation::add(const TrackPoint& run, double dpsi_rad, std::uint64_t passed) {
  finite_ = finite_ && std::isfinite(run.x_m) && std::isfinite(run.y_m) && std::isfinite(run.psi_rad) && std::isfinite(dpsi_rad);
  if (!finite_) return reference_;
  const double reach_m = begun_ && passed > 1 ? window_m_ + std::hypot(run.x_m - last_.x_m, run.y_m - last_.y_m) : window_m_;
  const double s_m = path_.project(run.x_m, run.y_m, reference_.s_m, reach_m);
  const contract::PathPose pose = path_.pose(s_m);
  const double omega_rad_s = begun_ ? (pose.psi_rad - reference_.at.psi_rad) / (dt_s_ * static_cast<double>(passed)) : 0.0;
  reference_ = {s_m, {pose.x_m, pose.y_m, pose.psi_rad}, omega_rad_s};
  correlation_.add(dpsi_rad, omega_rad_s);
  ise_.add(run, reference_.at);
  last_ = run;
  begun_ = true;
  return reference_;
}

std::optional<Evaluation> RunEvaluation::value() const {
  if (!begun_ || !finite_) return std::nullopt;
  return Evaluation{correlation_.value(), ise_.value()};
}

std::optional<Evaluation> evaluate(const contract::ReferencePath& path, const RunColumns& run, double window_m) {
  if (!usable(path, run)) return std::nullopt;
  RunEvaluation out(path, run.dt_s, 0.0, window_m);
  for (std::size_t i = 0; i < run.x_m.size(); ++i) out.add({run.x_m[i], run.y_m[i], run.psi_rad[i]}, run.dpsi_rad[i]);
  return out.value();
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
  return evaluate(path, {kMetricStep_s, x_m, y_m, psi_rad, dpsi_rad}, window_m);
}

}  // namespace hoist::db
