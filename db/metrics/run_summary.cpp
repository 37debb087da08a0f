#include "db/metrics/run_summary.hpp"

#include <cmath>
#include <cstddef>

namespace hoist::db {

std::optional<RunSummary> run_summary(const RunColumns& run) {
  if (run.x_m.empty() || run.x_m.size() != run.y_m.size() || !(run.dt_s > 0.0) || !std::isfinite(run.dt_s)) return std::nullopt;
  RunSummary summary;
  summary.duration_s = run.dt_s * static_cast<double>(run.x_m.size() - 1);
  summary.distance_m = polyline_length_m(run.x_m, run.y_m);
  if (!std::isfinite(summary.distance_m)) return std::nullopt;
  summary.mean_speed_m_s = summary.duration_s > 0.0 ? summary.distance_m / summary.duration_s : 0.0;
  return summary;
}

std::optional<RunDeviation> run_deviation(const contract::ReferencePath& path, const RunColumns& run, double window_m) {
  const std::size_t count = run.x_m.size();
  if (!path.valid() || count == 0 || run.y_m.size() != count || run.psi_rad.size() != count) return std::nullopt;
  const ReferenceColumns reference = reference_of(path, run.x_m, run.y_m, run.dt_s, window_m);
  double position = 0.0;
  double heading = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double dx_m = run.x_m[i] - reference.x_m[i];
    const double dy_m = run.y_m[i] - reference.y_m[i];
    const double dpsi_rad = wrap_angle_rad(run.psi_rad[i] - reference.psi_rad[i]);
    position += dx_m * dx_m + dy_m * dy_m;
    heading += dpsi_rad * dpsi_rad;
  }
  const double samples = static_cast<double>(count);
  const RunDeviation deviation{std::sqrt(position / samples), std::sqrt(heading / samples)};
  if (!std::isfinite(deviation.position_rms_m) || !std::isfinite(deviation.heading_rms_rad)) return std::nullopt;
  return deviation;
}

}  // namespace hoist::db
