// Following a path on the floor: the curvature that leads the platform onto the path and keeps it there.
//
// Source: A. Micaelli, C. Samson, "Trajectory tracking for unicycle-type and two-steering-wheels mobile robots", INRIA report 2097 (1993),
// section on path following; the platform is a unicycle of speed v >= 0 and turn rate w, its nearest place on the path has curvature k.
// With d = distance to the left of the path and h = heading against its tangent, on the path's side of the curve's centre (1 - k d > 0):
//   d' = v sin h,   h' = w - k v cos h / (1 - k d).
// The law w = v [ k cos h / (1 - k d) - d sin(h)/h / L^2 - 2 z h / L ] gives h' = -v d sin(h)/h / L^2 - 2 z v h / L. For V = d^2 / L^2 +
// h^2 this is V' = -4 z v h^2 / L <= 0, and by Barbalat's lemma h -> 0, hence h' -> 0, hence d -> 0, for every speed that does not die
// away. Near the path it is a linear oscillator over distance, not over time: d'' + (2 z / L) d' + d / L^2 = 0, so slowing down or stopping
// (release of hold-to-run) does not change the driven line.
#pragma once

#include <cmath>

namespace hoist::law {

template <typename Real>
struct PathFollowerConfig {
  Real reach_m{
      Real(0.4)};  ///< L: the distance over which an error fades; short enough to follow, long enough not to be felt as a corner (assumed)
  Real damping_norm{Real(1)};     ///< z: damping; 1 does not overshoot
  Real kappa_max_per_m{Real(4)};  ///< largest curvature
};

template <typename Real>
struct PathError {
  Real cross_m{};      ///< d, left of the path positive
  Real heading_rad{};  ///< h, within half a turn
  Real kappa_per_m{};  ///< k, left positive
};

/// The curvature to drive, 1/m, left positive: turn rate divided by speed. Something not finite gives 0, straight on; the caller stops.
template <typename Real>
[[nodiscard]] inline Real path_curvature(const PathFollowerConfig<Real>& config, const PathError<Real>& error) {
  if (!std::isfinite(error.cross_m) || !std::isfinite(error.heading_rad) || !std::isfinite(error.kappa_per_m)) return Real(0);
  // Beyond the centre of a curve the nearest place is undefined; the factor is limited to its near side.
  constexpr Real kNearest = Real(0.2);
  const Real room = Real(1) - error.kappa_per_m * error.cross_m;
  const Real along = error.kappa_per_m * std::cos(error.heading_rad) / (room > kNearest ? room : kNearest);
  const Real slope = std::fabs(error.heading_rad) > Real(1e-6) ? std::sin(error.heading_rad) / error.heading_rad : Real(1);
  const Real back = (error.cross_m * slope / config.reach_m + Real(2) * config.damping_norm * error.heading_rad) / config.reach_m;
  const Real kappa = along - back;
  return kappa > config.kappa_max_per_m ? config.kappa_max_per_m : (kappa < -config.kappa_max_per_m ? -config.kappa_max_per_m : kappa);
}

/// The fastest speed from which `speed_there` is still met after `left` with this deceleration; for turning likewise. Never negative.
template <typename Real>
[[nodiscard]] inline Real approach_speed(Real left, Real speed_there, Real deceleration) {
  const Real square = speed_there * speed_there + Real(2) * deceleration * left;
  return square > Real(0) ? std::sqrt(square) : Real(0);
}

}  // namespace hoist::law
