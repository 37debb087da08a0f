// A door sill, a cable cover, or a step down: what a rolling wheel makes of an edge of the floor.
#pragma once

#include <cmath>

namespace hoist::sim {

/// Lies across the heading `psi_rad`, from this point on. Thresholds may be 20 mm high (DIN 18040-1, 4.3.3.1), dropped kerbs 30 mm (DIN 18040-3).
struct FloorEdge {
  double x_m{}, y_m{}, psi_rad{};
  double height_m{};             ///< above zero a sill, below zero a step down
  double length_m{};             ///< of a sill, along the heading
  bool left{true}, right{true};  ///< of the line along the heading through the point
};

/// Where the middle of a wheel is above or below its height on the floor, and the first two derivatives of that along the heading.
struct WheelPath {
  double height_m{};
  double slope_norm{};
  double curve_per_m{};
};

/// Path of a wheel of this radius, `along_m` past the edge: an arc about the edge of the higher floor. Where it meets the lower floor the slope
/// would jump; the tyre spreads that over 5 mm (assumed).
inline WheelPath off_an_edge(double along_m, double height_m, double radius_m) {
  constexpr double kTyre_m = 0.005;
  const double reach_m = std::sqrt(2.0 * radius_m * height_m - height_m * height_m);
  if (along_m <= 0.0) return {height_m, 0.0, 0.0};
  if (along_m >= reach_m) return {};
  const double root_m = std::sqrt(radius_m * radius_m - along_m * along_m);
  return {height_m - radius_m + root_m, -along_m / root_m * std::fmin(1.0, (reach_m - along_m) / kTyre_m),
          -radius_m * radius_m / (root_m * root_m * root_m)};
}

inline WheelPath over(const FloorEdge& edge, double x_m, double y_m, double radius_m) {
  const double cosine = std::cos(edge.psi_rad), sine = std::sin(edge.psi_rad);
  const double along_m = cosine * (x_m - edge.x_m) + sine * (y_m - edge.y_m);
  const double left_m = -sine * (x_m - edge.x_m) + cosine * (y_m - edge.y_m);
  if (!(left_m > 0.0 ? edge.left : edge.right)) return {};
  if (edge.height_m < 0.0) {
    WheelPath path = off_an_edge(along_m, -edge.height_m, radius_m);
    path.height_m += edge.height_m;
    return path;
  }
  if (along_m > edge.length_m / 2.0) return off_an_edge(along_m - edge.length_m, edge.height_m, radius_m);
  WheelPath path = off_an_edge(-along_m, edge.height_m, radius_m);
  path.slope_norm = -path.slope_norm;
  return path;
}

}  // namespace hoist::sim
