// Pairs of a measured value and the sensors' value, and the straight line that fits them best.
#pragma once
#include <cmath>
#include <cstddef>

#include "control/core/types.hpp"

namespace hoist::core {

class MeasuredPairs {
 public:
  static constexpr std::size_t kMost = 8;

  struct Pair {
    double sensed = 0, measured = 0;
  };

  /// False, and nothing kept, when there is no room for another.
  [[nodiscard]] bool add(double sensed, double measured) noexcept { return pairs_.push_back({sensed, measured}); }
  void clear() noexcept { pairs_.clear(); }
  [[nodiscard]] std::size_t size() const noexcept { return pairs_.size(); }
  [[nodiscard]] bool full() const noexcept { return pairs_.full(); }
  [[nodiscard]] bool both_directions() const noexcept {
    bool forward = false, backward = false;
    for (const Pair& pair : pairs_) {
      forward = forward || pair.measured > 0;
      backward = backward || pair.measured < 0;
    }
    return forward && backward;
  }

  /// Between the two measured figures that are furthest from each other.
  [[nodiscard]] double measured_span() const noexcept {
    if (pairs_.empty()) return 0;
    double least = (*pairs_.begin()).measured, most = least;
    for (const Pair& pair : pairs_) {
      least = pair.measured < least ? pair.measured : least;
      most = pair.measured > most ? pair.measured : most;
    }
    return most - least;
  }

  struct Line {
    double slope = 0, offset = 0;
    double largest_error = 0;  // of a measured figure against the line
    bool found = false;
  };

  /// measured = slope x sensed, by least squares: distances and turns, each from the end of the previous one.
  [[nodiscard]] Line through_zero() const noexcept {
    double xy = 0, xx = 0;
    for (const Pair& pair : pairs_) {
      xy += pair.sensed * pair.measured;
      xx += pair.sensed * pair.sensed;
    }
    if (!(xx > 0)) return {};
    return judged({xy / xx, 0, 0, true});
  }

  /// measured = slope x sensed + offset, by least squares: positions relative to a middle that is not known exactly.
  [[nodiscard]] Line with_offset() const noexcept {
    if (pairs_.size() < 2) return {};
    const auto n = static_cast<double>(pairs_.size());
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const Pair& pair : pairs_) {
      x += pair.sensed / n;
      y += pair.measured / n;
    }
    for (const Pair& pair : pairs_) {
      xx += (pair.sensed - x) * (pair.sensed - x);
      xy += (pair.sensed - x) * (pair.measured - y);
    }
    if (!(xx > 0)) return {};
    const double slope = xy / xx;
    return judged({slope, y - slope * x, 0, true});
  }

 private:
  [[nodiscard]] Line judged(Line line) const noexcept {
    for (const Pair& pair : pairs_) {
      const double error = std::fabs(pair.measured - line.slope * pair.sensed - line.offset);
      line.largest_error = error > line.largest_error ? error : line.largest_error;
    }
    return line;
  }

  FixedVector<Pair, kMost> pairs_;
};

}  // namespace hoist::core
