// A line that a therapist has drawn on the floor: points joined by straights, in metres, open or closed. exercises.hpp makes a path of it.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace hoist::contract {

inline constexpr std::size_t kOwnPointsMost = 24;
/// A coordinate of a point lies within this of the origin, and in whole centimetres: the recording stays small, and a hand is no finer.
inline constexpr double kOwnReach_m = 50.0;
inline constexpr double kOwnGrid_per_m = 100.0;
/// Neighbouring points are at least so far apart.
inline constexpr double kOwnEdgeLeast_m = 0.2;

struct FloorPoint {
  double x_m = 0, y_m = 0;
  friend constexpr bool operator==(const FloorPoint&, const FloorPoint&) = default;
};

struct OwnLine {
  std::array<FloorPoint, kOwnPointsMost> points{};
  std::size_t count = 0;
  bool closed = false;  ///< the last point is joined to the first
  friend constexpr bool operator==(const OwnLine&, const OwnLine&) = default;
};

[[nodiscard]] constexpr std::size_t own_points_least(bool closed) { return closed ? 3 : 2; }
[[nodiscard]] inline double on_own_grid(double value_m) { return std::round(value_m * kOwnGrid_per_m) / kOwnGrid_per_m; }
/// The straight that begins at this point.
[[nodiscard]] inline double own_edge_m(const OwnLine& line, std::size_t from) {
  const FloorPoint &a = line.points[from], &b = line.points[(from + 1) % line.count];
  return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m);
}

}  // namespace hoist::contract
