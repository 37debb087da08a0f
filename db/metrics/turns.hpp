// Turns of the hoist, after El-Gohary (2014): the turn rate passes 15 degrees a second, and the turn has more than 45 degrees. It reaches from
// one to one degree a second, not from five: a slow walker's turn begins and ends so gently that it would lose up to 11 degrees.
#pragma once
#include <array>
#include <cstddef>
#include <optional>

#include "db/metrics/comparison.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

inline constexpr double kDegree_rad = 3.14159265358979323846 / 180.0;
inline constexpr double kTurnPeak_rad_s = 15 * kDegree_rad, kTurnEdge_rad_s = 1 * kDegree_rad, kTurnLeast_rad = 45 * kDegree_rad;
/// Two parts of a turn with less than this between them are one turn with a hesitation.
inline constexpr double kHesitation_s = 0.3;

struct TurnTotals {
  int left = 0, right = 0;
  double angle_rad = 0, time_s = 0;  ///< sums, of the angles' sizes
  /// Of the pelvis's turn before the hoist's turn rate, over the whole walk.
  std::optional<BestLag> lead;
  [[nodiscard]] int count() const { return left + right; }
};

/// The turn rate is the heading's change over the half second around each sample, per second; 0 within a quarter of a second of a gap or an end.
class TurnFinder {
 public:
  /// The next sample that counts.
  void add(const WalkSample& sample);
  /// After the last sample.
  [[nodiscard]] TurnTotals end();

 private:
  static constexpr std::size_t kHalf = samples_in(0.25), kWindow = 2 * kHalf + 1;
  struct Heading {
    double psi_rad = 0, dpsi_rad = 0;
  };
  // A part of a stretch without gaps in which the rate stays beyond the edge, of one sign, hesitations bridged.
  struct Part {
    std::size_t first = 0, last = 0;
    double first_rad = 0, last_rad = 0, rate_rad_s = 0, peak_rad_s = 0;
  };
  void judge(std::size_t place, double rate_rad_s);
  void close_part();
  void close_stretch();

  TurnTotals out_;
  BestLagSearch lead_;
  // The stretch under way: its newest samples, by place in it modulo kWindow.
  std::array<Heading, kWindow> window_{};
  std::size_t count_ = 0;
  std::uint64_t tick_ = 0;
  std::optional<Part> part_;
};

}  // namespace hoist::db
