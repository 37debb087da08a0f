// Whether each strut's sensor sits on its own strut and the right way round (H7): the bar of an empty harness is moved forward, to the right and
// turned to the left, and comes back by its springs in between.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/contract/calibration.hpp"

namespace hoist::core {

class StrutCheck {
 public:
  /// Of both struts, forward and to the right.
  struct Angles {
    double left_alpha_rad = 0, left_beta_rad = 0, right_alpha_rad = 0, right_beta_rad = 0;

    Angles operator-(const Angles& o) const noexcept {
      return {left_alpha_rad - o.left_alpha_rad, left_beta_rad - o.left_beta_rad, right_alpha_rad - o.right_alpha_rad,
              right_beta_rad - o.right_beta_rad};
    }
  };
  static constexpr std::uint8_t kMotions = 3;

  /// A bar that is held still, from its place at rest. Anything but none ends the check; a bar that has hardly moved is waited for.
  contract::CalibrationReason held(const Angles& moved) noexcept {
    if (back_ || largest(moved) < kLeast_rad) return contract::CalibrationReason::none;
    const contract::CalibrationReason reason = judge(moved);
    if (reason == contract::CalibrationReason::none) {
      ++done_;
      back_ = true;
    }
    return reason;
  }
  /// In every step: the next motion begins when the bar has come back.
  void follow(const Angles& moved) noexcept {
    if (largest(moved) < kBack_rad) back_ = false;
  }

  /// Motion that is wanted now: 0 forward, 1 to the right, 2 turned to the left; 3 when all were right.
  [[nodiscard]] std::uint8_t next() const noexcept { return done_; }
  [[nodiscard]] bool done() const noexcept { return done_ >= kMotions; }
  /// The bar is on its way back from the motion before.
  [[nodiscard]] bool coming_back() const noexcept { return back_; }

 private:
  // 8 cm at the bar (0.8 m above the joint), far above mounting errors (3 degrees, SOURCES 2.3) and what springs leave.
  static constexpr double kLeast_rad = 0.10, kBack_rad = 0.05;
  // A strut follows the bar as far as the other one, less slack; a sensor turned by a quarter sees a tenth of it.
  static constexpr double kFollows_norm = 0.4;

  static double largest(const Angles& m) noexcept {
    return std::fmax(std::fmax(std::fabs(m.left_alpha_rad), std::fabs(m.right_alpha_rad)),
                     std::fmax(std::fabs(m.left_beta_rad), std::fabs(m.right_beta_rad)));
  }
  [[nodiscard]] contract::CalibrationReason judge(const Angles& m) const noexcept {
    if (done_ == 0) return same_way(m.left_alpha_rad, m.right_alpha_rad, largest(m));
    if (done_ == 1) return same_way(m.left_beta_rad, m.right_beta_rad, largest(m));
    return turned(m.left_alpha_rad, m.right_alpha_rad, largest(m));
  }
  static contract::CalibrationReason same_way(double left, double right, double most) noexcept {
    using contract::CalibrationReason;
    if (std::fabs(left) < kFollows_norm * most && std::fabs(right) < kFollows_norm * most) return CalibrationReason::bar_other_way;
    if (std::fabs(left) < kFollows_norm * most) return CalibrationReason::left_strut_askew;
    if (std::fabs(right) < kFollows_norm * most) return CalibrationReason::right_strut_askew;
    if (left < 0 && right < 0) return CalibrationReason::bar_other_way;
    if (left < 0) return CalibrationReason::left_strut_turned;
    if (right < 0) return CalibrationReason::right_strut_turned;
    return CalibrationReason::none;
  }
  // Turned to the left, the right strut goes forward and the left one back.
  static contract::CalibrationReason turned(double left, double right, double most) noexcept {
    using contract::CalibrationReason;
    if (left < -kFollows_norm * most && right > kFollows_norm * most) return CalibrationReason::none;
    return left > kFollows_norm * most && right < -kFollows_norm * most ? CalibrationReason::struts_swapped
                                                                        : CalibrationReason::bar_other_way;
  }

  std::uint8_t done_ = 0;
  bool back_ = false;
};

}  // namespace hoist::core
