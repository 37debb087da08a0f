#include "db/metrics/normalised_ise.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace hoist::db {

double wrap_angle_rad(double angle_rad) {
  // remainder gives [-pi, pi]; the half-open end is pi.
  const double wrapped = std::remainder(angle_rad, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

double polyline_length_m(std::span<const double> x_m, std::span<const double> y_m) {
  double length_m = 0.0;
  for (std::size_t i = 1; i < x_m.size() && i < y_m.size(); ++i) {
    length_m += std::hypot(x_m[i] - x_m[i - 1], y_m[i] - y_m[i - 1]);
  }
  return length_m;
}

void NormalisedIseSum::add(const TrackPoint& run, const TrackPoint& reference) {
  const double dx_m = run.x_m - reference.x_m;
  const double dy_m = run.y_m - reference.y_m;
  const double dpsi_rad = wrap_angle_rad(run.psi_rad - reference.psi_rad);
  sum_ += dx_m * dx_m + dy_m * dy_m + dpsi_rad * dpsi_rad;
  if (count_++ > 0) length_m_ += std::hypot(reference.x_m - last_.x_m, reference.y_m - last_.y_m);
  last_ = reference;
}

std::optional<NormalisedIse> NormalisedIseSum::value(std::optional<double> length_m) const {
  if (count_ == 0) return std::nullopt;
  const double over_m = length_m.value_or(length_m_);
  const double j = sum_ / over_m;
  if (!(over_m > 0.0) || !std::isfinite(j) || !std::isfinite(over_m)) return std::nullopt;
  return NormalisedIse{j, over_m};
}

std::optional<NormalisedIse> normalised_ise(const TrackAndReference& run, std::optional<double> length_m) {
  const std::size_t count = run.x_m.size();
  for (const auto& column : {run.y_m, run.psi_rad, run.x_ref_m, run.y_ref_m, run.psi_ref_rad}) {
    if (column.size() != count) return std::nullopt;
  }
  NormalisedIseSum sum;
  for (std::size_t i = 0; i < count; ++i)
    sum.add({run.x_m[i], run.y_m[i], run.psi_rad[i]}, {run.x_ref_m[i], run.y_ref_m[i], run.psi_ref_rad[i]});
  return sum.value(length_m);
}

}  // namespace hoist::db
