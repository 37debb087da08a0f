#include "db/metrics/run_summary.hpp"

#include <cmath>
#include <cstddef>

namespace hoist::db {

std::optional<RunDeviation> run_deviation(const contract::ReferencePath& path, const RunColumns& run, double window_m) {
  const std::size_t count = run.x_m.size();
  if (!path.valid() || count == 0 || run.y_m.size() != count || run.psi_rad.size() != count) return std::nullopt;
  const ReferenceColumns reference = reference_of(path, run, window_m);
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
