// Equation (24), page 8: how precisely the reference was followed.
#pragma once

#include <optional>
#include <span>

namespace hoist::db {

/// The track and, sample by sample, the reference it is compared with; all six of one length. x, y in m, psi in rad.
struct TrackAndReference {
  std::span<const double> x_m;
  std::span<const double> y_m;
  std::span<const double> psi_rad;
  std::span<const double> x_ref_m;
  std::span<const double> y_ref_m;
  std::span<const double> psi_ref_rad;
};

struct NormalisedIse {
  double j{};         ///< J_N: a SUM over samples, so it grows with the sample rate and with slowness; compare at 100 Hz only (D29)
  double length_m{};  ///< L
};

/// An angle brought to (-pi, pi].
[[nodiscard]] double wrap_angle_rad(double angle_rad);

/// (24) with 1 m^2 = 1 rad^2 and the heading error wrapped. Without `length_m`, L is the polyline length of the reference samples. No
/// value when lengths differ, nothing was sampled, something is not finite, or L is not positive.
[[nodiscard]] std::optional<NormalisedIse> normalised_ise(const TrackAndReference& run, std::optional<double> length_m = std::nullopt);

/// Length of the line through the points, m.
[[nodiscard]] double polyline_length_m(std::span<const double> x_m, std::span<const double> y_m);

}  // namespace hoist::db
