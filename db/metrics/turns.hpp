// Turns of the hoist, after El-Gohary (2014): the turn rate passes 15 degrees a second, and the turn has more than 45 degrees. It reaches from
// one to one degree a second, not from five: a slow walker's turn begins and ends so gently that it would lose up to 11 degrees.
#pragma once
#include <vector>

#include "db/metrics/walk.hpp"

namespace hoist::db {

inline constexpr double kDegree_rad = 3.14159265358979323846 / 180.0;
inline constexpr double kTurnPeak_rad_s = 15 * kDegree_rad, kTurnEdge_rad_s = 1 * kDegree_rad, kTurnLeast_rad = 45 * kDegree_rad;
/// Two parts of a turn with less than this between them are one turn with a hesitation.
inline constexpr double kHesitation_s = 0.3;

struct Turn {
  Stretch where;
  double angle_rad = 0;  ///< left positive
};
[[nodiscard]] std::vector<Turn> turns_of(const Walk& walk);

/// The heading's change over the half second around each sample, per second; 0 within a quarter of a second of a gap or an end.
[[nodiscard]] std::vector<double> turn_rate_of(const Walk& walk);

}  // namespace hoist::db
