// Whether each encoder counts in the right direction, and whether each drive is on its own wheel.
#pragma once
#include <cmath>

#include "control/contract/calibration.hpp"

namespace hoist::core {

/// An encoder that counts this share of the other one's distance, or less, is dead.
inline constexpr double kDeadShare_norm = 0.2;

/// What the wheels counted on a push straight ahead.
[[nodiscard]] inline contract::CalibrationReason judge_push(double left_m, double right_m) noexcept {
  using contract::CalibrationReason;
  const double left = std::fabs(left_m), right = std::fabs(right_m);
  if (left <= kDeadShare_norm * right) return CalibrationReason::left_encoder_dead;
  if (right <= kDeadShare_norm * left) return CalibrationReason::right_encoder_dead;
  if (left_m < 0 && right_m < 0) return CalibrationReason::both_backward;
  if (left_m < 0) return CalibrationReason::left_encoder_reversed;
  if (right_m < 0) return CalibrationReason::right_encoder_reversed;
  return CalibrationReason::none;
}

/// What the wheels counted on a turn to the left; turned_rad is measured by the chassis gyroscope.
[[nodiscard]] inline contract::CalibrationReason judge_turn(double left_m, double right_m, double turned_rad) noexcept {
  using contract::CalibrationReason;
  if (!(turned_rad > 0)) return CalibrationReason::turned_right;
  return right_m > left_m ? CalibrationReason::none : CalibrationReason::encoders_swapped;
}

}  // namespace hoist::core
