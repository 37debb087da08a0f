// The limits on the speed that a mode asks for, and which of them is why the hoist goes more slowly. Each is applied where it is known: the
// age of the last command and the patient's lag in the mode, bumper and slope in the tick, the speed cap and the room for a turn in the
// limiter. The safety gate is no part of this: it judges the frames for itself.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/contract/faults.hpp"

namespace hoist::core {

class LimitedSpeed {
 public:
  /// From the speed that is asked for, forward positive. Not explicit: a mode that limits nothing simply names a speed.
  constexpr LimitedSpeed(double asked_m_s = 0) noexcept : asked_m_s_(asked_m_s), speed_m_s_(asked_m_s) {}

  /// Lets this share of the speed pass, 0 to 1.
  constexpr void share(double share_norm, contract::SpeedCause cause) noexcept { take(speed_m_s_ * share_norm, cause); }
  /// Not faster than this, in either direction.
  constexpr void within(double limit_m_s, contract::SpeedCause cause) noexcept { within(limit_m_s, limit_m_s, cause); }
  constexpr void within(double backward_m_s, double forward_m_s, contract::SpeedCause cause) noexcept {
    take(speed_m_s_ > forward_m_s ? forward_m_s : (speed_m_s_ < -backward_m_s ? -backward_m_s : speed_m_s_), cause);
  }

  /// What is left.
  [[nodiscard]] constexpr double m_s() const noexcept { return speed_m_s_; }
  /// The last limit that took anything off, which is the one in force; none while all of them together take less than kTold_m_s.
  [[nodiscard]] contract::SpeedCause cause() const noexcept {
    return std::fabs(asked_m_s_ - speed_m_s_) > kTold_m_s ? cause_ : contract::SpeedCause::none;
  }

 private:
  // A patient's lean reaches a limit briefly with each step; less than this is not felt.
  static constexpr double kTold_m_s = 0.02;

  constexpr void take(double left_m_s, contract::SpeedCause cause) noexcept {
    if (left_m_s != speed_m_s_) cause_ = cause;
    speed_m_s_ = left_m_s;
  }

  double asked_m_s_, speed_m_s_;
  contract::SpeedCause cause_ = contract::SpeedCause::none;
};

}  // namespace hoist::core
