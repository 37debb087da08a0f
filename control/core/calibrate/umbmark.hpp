// Systematic errors of odometry from squares driven both ways: J. Borenstein and L. Feng, "Measurement and correction of systematic
// odometry errors in mobile robots", IEEE Transactions on Robotics and Automation 12(6), 1996 (UMBmark). Turning left and turning right, a
// wrong track and unequal wheels show differently, so the two cannot hide behind each other.
#pragma once
#include <cmath>
#include <cstddef>
#include <numbers>

#include "control/core/calibrate/outcome.hpp"

namespace hoist::core {

/// Where the hoist truly ended, less where its odometry said: metres forward and left of the start, as it stood there.
struct SquareError {
  double x_m = 0, y_m = 0;
};

/// Centre of gravity of the errors of all squares driven one way round.
class SquareMean {
 public:
  void add(SquareError error) noexcept {
    x_m_ += error.x_m;
    y_m_ += error.y_m;
    ++count_;
  }
  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  [[nodiscard]] SquareError mean() const noexcept {
    const double n = count_ == 0 ? 1.0 : static_cast<double>(count_);
    return {x_m_ / n, y_m_ / n};
  }

 private:
  double x_m_ = 0, y_m_ = 0;
  std::size_t count_ = 0;
};

struct SquareResult {
  double track_norm = 1;        // true track / assumed track, E_b
  double left_scale_norm = 1;   // correction of the left wheel, c_L
  double right_scale_norm = 1;  // and of the right one, c_R; their mean is 1: squares say nothing of the size
  contract::CalibrationReason reason = contract::CalibrationReason::none;
};

/// How far the best pair of errors may miss an end position, as a share of the way driven: the tape, and a wheel that slipped a little.
inline constexpr double kSquareMiss_norm = 0.006;
/// A larger error at a corner or along a side is a fault, not a tolerance.
inline constexpr double kSquareLargest_rad = 0.2;

namespace detail {
inline constexpr double kQuarter_rad = std::numbers::pi / 2.0;

/// Where a square ends whose corners turn too far by corner_rad and whose sides bend to the left by bend_rad.
[[nodiscard]] inline SquareError square_end(double side_m, bool left, double corner_rad, double bend_rad) noexcept {
  const double turn_rad = left ? kQuarter_rad + corner_rad : -kQuarter_rad - corner_rad;
  const double half_rad = bend_rad / 2.0;
  const double chord_m = std::fabs(half_rad) < 1e-6 ? side_m : side_m * std::sin(half_rad) / half_rad;
  SquareError end;
  double heading_rad = half_rad;
  for (int side = 0; side < 4; ++side) {
    end.x_m += chord_m * std::cos(heading_rad);
    end.y_m += chord_m * std::sin(heading_rad);
    heading_rad += bend_rad + turn_rad;
  }
  return end;
}
struct SquareFit {
  double corner_rad = 0, bend_rad = 0;
  contract::CalibrationReason reason = contract::CalibrationReason::none;
};

/// The hoist goes straight ahead first. Let every corner turn too far by a and every side bend to the left by b. With small angles the
/// errors sum up to  x_left = 2L(a+b), y_left = -2L(a+b), x_right = 2L(a-b), y_right = 2L(a-b): the paper's equations (with its signs for
/// clockwise first). The paper leaves a choice between x and y; here both unknowns follow from all four figures by least squares. Repeating
/// the step on the remaining errors removes the error of the small-angle approximation.
[[nodiscard]] inline SquareFit fit_squares(double side_m, SquareError left, SquareError right) noexcept {
  using contract::CalibrationReason;
  constexpr int kSteps = 6;
  const double eight_sides_m = 8.0 * side_m;
  SquareFit fit;
  double miss_m = 0;
  for (int step = 0; step <= kSteps; ++step) {
    const SquareError at_left = square_end(side_m, true, fit.corner_rad, fit.bend_rad);
    const SquareError at_right = square_end(side_m, false, fit.corner_rad, fit.bend_rad);
    const SquareError l{left.x_m - at_left.x_m, left.y_m - at_left.y_m}, r{right.x_m - at_right.x_m, right.y_m - at_right.y_m};
    const double left_miss_m = std::hypot(l.x_m, l.y_m), right_miss_m = std::hypot(r.x_m, r.y_m);
    miss_m = left_miss_m > right_miss_m ? left_miss_m : right_miss_m;
    if (step == kSteps) break;
    fit.corner_rad += (l.x_m + r.x_m - l.y_m + r.y_m) / eight_sides_m;
    fit.bend_rad += (l.x_m - r.x_m - l.y_m - r.y_m) / eight_sides_m;
    // Written so that a NaN is refused.
    if (!(std::fabs(fit.corner_rad) <= kSquareLargest_rad) || !(std::fabs(fit.bend_rad) <= kSquareLargest_rad)) {
      fit.reason = CalibrationReason::implausible;
      return fit;
    }
  }
  if (!(miss_m <= kSquareMiss_norm * 4.0 * side_m)) fit.reason = CalibrationReason::disagree;
  return fit;
}
}  // namespace detail

/// side_m: of the squares; track_m: in force when they were driven.
[[nodiscard]] inline SquareResult umbmark(double side_m, SquareError left, SquareError right, double track_m) noexcept {
  const detail::SquareFit fit = detail::fit_squares(side_m, left, right);
  SquareResult result;
  result.reason = fit.reason;
  if (fit.reason != contract::CalibrationReason::none) return result;
  // A corner of a quarter turn that went too far was driven on a shorter track: E_b = 90 degrees / (90 degrees + a).
  result.track_norm = detail::kQuarter_rad / (detail::kQuarter_rad + fit.corner_rad);
  // Bent by b on the length L: a circle of radius R = (L/2) / sin(b/2), and E_d = (R + track/2) / (R - track/2), written with 1/R so that
  // a straight side needs no exception. c_L = 2 / (E_d + 1), c_R = 2 / (1/E_d + 1).
  const double bend_per_m = std::sin(fit.bend_rad / 2.0) / (side_m / 2.0);
  const double half = result.track_norm * track_m / 2.0 * bend_per_m;
  const double unequal_norm = (1.0 + half) / (1.0 - half);
  result.left_scale_norm = 2.0 / (unequal_norm + 1.0);
  result.right_scale_norm = 2.0 * unequal_norm / (unequal_norm + 1.0);
  return result;
}

}  // namespace hoist::core
