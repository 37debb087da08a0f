// Dead reckoning from the wheel encoders: equations (19)-(23), page 7.
#pragma once

#include <cmath>
#include <cstdint>

namespace hoist::law {

/// Movement of a free-running 32-bit counter, correct across its wrap for less than 2^31 counts.
[[nodiscard]] constexpr std::int32_t delta32(std::int32_t now, std::int32_t before) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(now) - static_cast<std::uint32_t>(before));
}

enum class OdometryMethod : unsigned char {
  kEuler,     ///< (21)-(22) as printed: the heading before the step
  kMidpoint,  ///< the heading half-way through the step
  kExactArc,  ///< the chord of the arc both wheels drove
};

template <typename Real>
struct OdometryConfig {
  Real left_m_per_count{};  ///< K_p->m; one per wheel, because calibration gives two (D25)
  Real right_m_per_count{};
  Real track_m{};  ///< d_ww
  OdometryMethod method{OdometryMethod::kEuler};
  bool operator==(const OdometryConfig&) const = default;
};

/// Pose on the floor. The heading is not wrapped: whole turns count.
template <typename Real>
struct Pose {
  Real x_m{};
  Real y_m{};
  Real psi_rad{};
};

/// How far the platform went in one step.
template <typename Real>
struct Travel {
  Real distance_m{};  ///< (19)
  Real turn_rad{};    ///< (20), positive to the left
};

template <typename Real>
[[nodiscard]] inline Travel<Real> odometry_travel(const OdometryConfig<Real>& config, std::int32_t left_counts, std::int32_t right_counts) {
  const Real left_m = static_cast<Real>(left_counts) * config.left_m_per_count;
  const Real right_m = static_cast<Real>(right_counts) * config.right_m_per_count;
  return {(left_m + right_m) / Real(2), (right_m - left_m) / config.track_m};
}

/// Moves the pose by one step's travel. False, and the pose unchanged, when the result would not be finite (a track of zero, say).
template <typename Real>
[[nodiscard]] inline bool odometry_advance(OdometryMethod method, Pose<Real>& pose, const Travel<Real>& travel) {
  Real heading_rad = pose.psi_rad;
  Real chord_m = travel.distance_m;
  if (method != OdometryMethod::kEuler) {
    const Real half_rad = travel.turn_rad / Real(2);
    heading_rad += half_rad;
    // sin(h)/h is exact to rounding for every h except zero.
    if (method == OdometryMethod::kExactArc && half_rad != Real(0)) chord_m *= std::sin(half_rad) / half_rad;
  }
  const Pose<Real> next{
      pose.x_m + chord_m * std::cos(heading_rad),  // (21)
      pose.y_m + chord_m * std::sin(heading_rad),  // (22)
      pose.psi_rad + travel.turn_rad,              // (23)
  };
  if (!std::isfinite(next.x_m) || !std::isfinite(next.y_m) || !std::isfinite(next.psi_rad)) return false;
  pose = next;
  return true;
}

/// One step of (19)-(23) from the counts each wheel moved (see delta32).
template <typename Real>
[[nodiscard]] inline bool odometry_step(const OdometryConfig<Real>& config, Pose<Real>& pose, std::int32_t left_counts,
                                        std::int32_t right_counts) {
  return odometry_advance(config.method, pose, odometry_travel(config, left_counts, right_counts));
}

}  // namespace hoist::law
