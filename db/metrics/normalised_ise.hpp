// Equation (24), page 8: how precisely the reference was followed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace hoist::db {

struct NormalisedIse {
  double j{};         ///< J_N: a SUM over samples, so it grows with the sample rate and with slowness; compare at 100 Hz only (D29)
  double length_m{};  ///< L
};

/// A place and a heading, not wrapped.
struct TrackPoint {
  double x_m{}, y_m{}, psi_rad{};
};

/// (24) with 1 m^2 = 1 rad^2 and the heading error wrapped, of samples that come one by one. Nothing of them is kept.
class NormalisedIseSum {
 public:
  void add(const TrackPoint& run, const TrackPoint& reference);
  /// Without `length_m`, L is the polyline length of the reference samples. No value without samples, when something is not finite, or L is not
  /// positive.
  [[nodiscard]] std::optional<NormalisedIse> value(std::optional<double> length_m = std::nullopt) const;

 private:
  std::uint64_t count_ = 0;
  double sum_ = 0, length_m_ = 0;
  TrackPoint last_;
};

/// The track and, sample by sample, the reference it is compared with; all six of one length. x, y in m, psi in rad.
struct TrackAndReference {
  std::span<const double> x_m;
  std::span<const double> y_m;
  std::span<const double> psi_rad;
  std::span<const double> x_ref_m;
  std::span<const double> y_ref_m;
  std::span<const double> psi_ref_rad;
};

/// An angle brought to (-pi, pi].
[[nodiscard]] double wrap_angle_rad(double angle_rad);

/// The sum of whole columns. No value when lengths differ, either.
[[nodiscard]] std::optional<NormalisedIse> normalised_ise(const TrackAndReference& run, std::optional<double> length_m = std::nullopt);

/// Length of the line through the points, m.
[[nodiscard]] double polyline_length_m(std::span<const double> x_m, std::span<const double> y_m);

}  // namespace hoist::db
