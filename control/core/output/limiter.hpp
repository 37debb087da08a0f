// Bounds on speed, acceleration, jerk, turn rate, turn acceleration and the outer wheel, and the ramps of the stops.
// They hold for every mode.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/contract/params.hpp"
#include "control/core/output/braking.hpp"
#include "control/core/output/speed_limits.hpp"
#include "control/core/output/wheel_room.hpp"

namespace hoist::core {

/// Speed that changes for a turn and not for a wish changes more gently than what explains a quick lean of the patient (fall.hpp,
/// kOwn_m_s2): a fall in a turn is found as quickly as one in a straight walk (H15).
inline constexpr double kGivesWay_m_s2 = 0.3;

class Limiter {
 public:
  /// One step towards the wish; while a stop is in force the wish is not looked at. A wish that is not a number counts as zero.
  /// `blind`: neither speed nor turn grows, not even by what the jerk limit has left of an acceleration (H4).
  void step(const contract::Params& params, Braking braking, LimitedSpeed speed, double yaw_wish_rad_s, bool blind, double dt_s) noexcept {
    cause_ = contract::SpeedCause::none;
    if (braking != Braking::none) {
      brake(params, braking, dt_s);
      return;
    }
    if (stopping_) {
      // Ending a stop early drops its deceleration at once. Rolled off with limited jerk it would carry the speed
      // through zero into reverse.
      stopping_ = false;
      gives_way_ = false;
      acceleration_m_s2_ = 0;
    }
    const double before_m_s = speed_m_s_, before_rad_s = yaw_rate_rad_s_;
    // A turn has priority and the hoist slows down for it. Until it has, each uses what the other leaves.
    const WheelRoom room{params};
    if (!std::isfinite(speed.m_s())) speed = {};
    speed.within(params.speed_m_s_max * params.speed_cap_norm, contract::SpeedCause::cap);
    const double wish_m_s = speed.m_s();
    const double yaw_wish_in_rad_s = clamp(finite(yaw_wish_rad_s), params.yaw_rate_rad_s_max);
    const double speed_room_m_s = std::fmin(room.speed_share_m_s(wish_m_s, yaw_wish_in_rad_s), room.speed_left_m_s(yaw_rate_rad_s_));
    const double yaw_room_rad_s = room.yaw_share_rad_s(wish_m_s, yaw_wish_in_rad_s);
    speed.within(speed_room_m_s, contract::SpeedCause::turn);
    const double target_m_s = speed.m_s();
    cause_ = speed.cause();
    follow_speed(params, target_m_s, acceleration_max(params, wish_m_s, target_m_s, dt_s), dt_s);
    if (speed_m_s_ == wish_m_s) gives_way_ = false;
    const double yaw_target_rad_s = clamp(yaw_wish_in_rad_s, std::fmin(yaw_room_rad_s, room.yaw_left_rad_s(speed_m_s_)));
    yaw_rate_rad_s_ = toward(yaw_rate_rad_s_, yaw_target_rad_s, params.yaw_acceleration_rad_s2_max * dt_s);
    if (!blind) return;
    const double risen_m_s = speed_m_s_;
    speed_m_s_ = no_farther(speed_m_s_, before_m_s);
    if (speed_m_s_ != risen_m_s) acceleration_m_s2_ = 0;
    yaw_rate_rad_s_ = no_farther(yaw_rate_rad_s_, before_rad_s);
  }

  /// Standing: nothing is commanded.
  void reset() noexcept { *this = Limiter{}; }
  /// Takes over a hoist that already rolls (pushed by hand, drives off), so that the stop ramps from there and does not jerk.
  void start_from(const contract::Params& params, double speed_m_s, double yaw_rate_rad_s) noexcept {
    reset();
    speed_m_s_ = clamp(finite(speed_m_s), params.speed_m_s_max);
    yaw_rate_rad_s_ = clamp(finite(yaw_rate_rad_s), params.yaw_rate_rad_s_max);
  }

  [[nodiscard]] double speed_m_s() const noexcept { return speed_m_s_; }
  [[nodiscard]] double acceleration_m_s2() const noexcept { return acceleration_m_s2_; }
  [[nodiscard]] double yaw_rate_rad_s() const noexcept { return yaw_rate_rad_s_; }
  /// Why it goes more slowly than it was asked to in the latest step.
  [[nodiscard]] contract::SpeedCause cause() const noexcept { return cause_; }
  [[nodiscard]] bool at_rest() const noexcept { return speed_m_s_ == 0 && yaw_rate_rad_s_ == 0; }

 private:
  [[nodiscard]] static double finite(double x) noexcept { return std::isfinite(x) ? x : 0.0; }
  [[nodiscard]] static double clamp(double x, double limit) noexcept { return x > limit ? limit : (x < -limit ? -limit : x); }
  [[nodiscard]] static double no_farther(double next, double before) noexcept {
    if (!(next * before > 0)) return 0.0;
    return std::fabs(next) > std::fabs(before) ? before : next;
  }
  [[nodiscard]] static double toward(double from, double to, double step) noexcept {
    const double gap = to - from;
    return gap > step ? from + step : (gap < -step ? from - step : to);
  }

  void brake(const contract::Params& params, Braking braking, double dt_s) noexcept {
    const double rate_m_s2 = deceleration_m_s2(braking, params);
    const double speed = std::fabs(speed_m_s_);
    const double yaw_rate = std::fabs(yaw_rate_rad_s_);
    // Turn rate falls in step with speed, so that the hoist stops on the curve it was on, as far as the bound on turning allows.
    double yaw_step = params.yaw_acceleration_rad_s2_max * dt_s;
    if (speed > 0 && yaw_rate * rate_m_s2 * dt_s < yaw_step * speed) yaw_step = yaw_rate * rate_m_s2 * dt_s / speed;
    const double before_m_s = speed_m_s_;
    speed_m_s_ = toward(speed_m_s_, 0, rate_m_s2 * dt_s);
    acceleration_m_s2_ = (speed_m_s_ - before_m_s) / dt_s;
    yaw_rate_rad_s_ = toward(yaw_rate_rad_s_, 0, yaw_step);
    stopping_ = true;
  }

  /// The largest acceleration now, in whole and part steps of J dt, from which the speed still meets the gap when the acceleration
  /// then falls by J dt in every step. Exact for this discrete ramp (a continuous square root overshoots by up to J dt^2 / 8), so the
  /// top speed is never passed, not even by rounding of the shape.
  [[nodiscard]] static double reachable_m_s2(double gap_m_s, double jerk_step_m_s2, double dt_s) noexcept {
    const double unit_m_s = jerk_step_m_s2 * dt_s;
    const double ratio = gap_m_s / unit_m_s;
    // With m = floor(n): sum of n, n-1, ..., n-m = (m+1)(n - m/2) units. m is the largest whole number with m (m+1) / 2 <= ratio.
    const double m = std::floor((std::sqrt(1.0 + 8.0 * ratio) - 1.0) / 2.0);
    return (ratio / (m + 1.0) + m / 2.0) * jerk_step_m_s2;
  }

  /// A requested change uses the full bound. Making room for a turn, and recovering afterwards, uses the gentle one.
  [[nodiscard]] double acceleration_max(const contract::Params& params, double wish_m_s, double target_m_s, double dt_s) noexcept {
    const bool slower = wish_m_s * speed_m_s_ < speed_m_s_ * speed_m_s_, room_ends = target_m_s != wish_m_s;
    if (room_ends && std::fabs(speed_m_s_) >= std::fabs(target_m_s) - kSame_m_s) gives_way_ = true;
    if (slower && !room_ends) gives_way_ = false;
    if (!gives_way_) return params.acceleration_m_s2_max;
    const double wished_m_s2 = slower ? reachable_m_s2(std::fabs(wish_m_s - speed_m_s_), params.jerk_m_s3_max * dt_s, dt_s) : 0.0;
    return std::fmin(std::fmax(wished_m_s2, kGivesWay_m_s2), params.acceleration_m_s2_max);
  }

  void follow_speed(const contract::Params& params, double target_m_s, double acceleration_m_s2_max, double dt_s) noexcept {
    const double gap_m_s = target_m_s - speed_m_s_;
    const double jerk_step_m_s2 = params.jerk_m_s3_max * dt_s;
    double wanted_m_s2 = reachable_m_s2(std::fabs(gap_m_s), jerk_step_m_s2, dt_s);
    if (wanted_m_s2 > acceleration_m_s2_max) wanted_m_s2 = acceleration_m_s2_max;
    if (gap_m_s < 0) wanted_m_s2 = -wanted_m_s2;
    acceleration_m_s2_ = toward(acceleration_m_s2_, wanted_m_s2, jerk_step_m_s2);
    const double next_m_s = speed_m_s_ + acceleration_m_s2_ * dt_s;
    speed_m_s_ = std::fabs(target_m_s - next_m_s) < kSame_m_s ? target_m_s : next_m_s;
  }

  // Ends exactly at the target, without a remainder of rounding.
  static constexpr double kSame_m_s = 1e-9;

  double speed_m_s_ = 0, acceleration_m_s2_ = 0, yaw_rate_rad_s_ = 0;
  contract::SpeedCause cause_ = contract::SpeedCause::none;
  bool stopping_ = false;
  bool gives_way_ = false;  // speed makes room for a turn, or comes back after one
};

}  // namespace hoist::core
