#include "control/core/estimate/fused_odometry.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/core/base/mutation.hpp"

namespace hoist::core {

namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0;

// ----- the filter. Variances per second are those of the gyroscope class in firmware/sim/imu.hpp.

/// 0.1 deg/s of white noise in samples 10 ms apart: 0.01 deg per root second of heading.
constexpr double kHeadingNoise_rad2_s = (0.01 * kDegree_rad) * (0.01 * kDegree_rad);
/// The bias wanders by 0.001 to 0.002 deg/s per root second.
constexpr double kBiasNoise_rad2_s3 = (0.001 * kDegree_rad) * (0.001 * kDegree_rad);
/// At standstill a bias can be learnt within two seconds without mistaking anything else for it.
constexpr double kBiasNoiseStanding_rad2_s3 = 30.0 * kBiasNoise_rad2_s3;
/// Variance of the encoders' heading in one step while the wheels grip: large enough that a disagreement fades in about
/// half a second, so that the error of a track width fades with the bend. At standstill the encoders cannot be wrong
/// about a turn.
constexpr double kGripping_rad2 = (0.06 * kDegree_rad) * (0.06 * kDegree_rad);
constexpr double kStanding_rad2 = (0.012 * kDegree_rad) * (0.012 * kDegree_rad);
/// A bias is learnt only on straight ways: in a bend a track width wrong by 2 % looks like one.
constexpr double kStraight_rad_s = 5.0 * kDegree_rad;
/// Three times the usual offset: more is a broken sensor, and is not hidden by learning it.
constexpr double kBiasMax_rad_s = 3.0 * kDegree_rad;
/// Standing this long before the bias is learnt quickly.
constexpr std::uint16_t kStandingTicks = 50;

// ----- what counts as slip (H10: noticed within 200 ms)

/// 15 deg/s open a gap of 1 deg in 70 ms, 6 deg/s in 200 ms.
constexpr double kApart_rad = 1.0 * kDegree_rad;
/// Per rad/s of turning: a track width wrong by 4 % for the filter's half second, and 10 ms between the two sensors' moments.
constexpr double kApartPerRate_s = 0.04 * 0.5 + 0.01;
/// The slip is over when the rates agree this well for as long as a slip may take to be noticed.
constexpr double kAgree_rad_s = 2.0 * kDegree_rad;
constexpr double kAgreePerRate_norm = 0.05;
constexpr std::uint16_t kQuietTicks = 20;
/// A hoist that stands and seems to turn slowly and steadily shows a new bias of the gyroscope.
constexpr std::uint16_t kStandingForEverTicks = 300;
constexpr double kSmoothing_s = 0.05;
constexpr double kRemembered_s = 0.3;
/// Left-out steps that the gyroscope's newest sample stands for. The drives brake by themselves 40 ms after their last command, so that over
/// a longer gap the rate is another one.
constexpr std::uint32_t kGyroTicksMost = 4;

}  // namespace

void FusedOdometry::predict(double gyro_turn_rad, double wheel_turn_rad, double dt_s) noexcept {
  apart_rad_ += gyro_turn_rad - bias_rad_s_ * dt_s - wheel_turn_rad;
  // P = A P A^T + Q with A = [1 -dt; 0 1].
  Eigen::Matrix2d a, p;
  a << 1.0, -dt_s, 0.0, 1.0;
  p << p_apart_, p_cross_, p_cross_, p_bias_;
  p = (a * p * a.transpose()).eval();
  p_apart_ = p(0, 0) + kHeadingNoise_rad2_s * dt_s;
  p_cross_ = p(0, 1);
  p_bias_ = p(1, 1) + (standing_.reached(kStandingTicks) ? kBiasNoiseStanding_rad2_s3 : kBiasNoise_rad2_s3) * dt_s;
}

// The encoders' measurement: no disagreement.
void FusedOdometry::correct(bool standing, bool turning) noexcept {
  const Eigen::Vector2d cross(p_apart_, p_cross_);
  Eigen::Vector2d gain = cross / (p_apart_ + (standing ? kStanding_rad2 : kGripping_rad2));
  if (turning) gain(1) = 0.0;
  const double innovation_rad = -apart_rad_;
  const double step_rad = gain(0) * innovation_rad;
  apart_rad_ += step_rad;
  given_away_rad_ -= step_rad;
  bias_rad_s_ = std::clamp(bias_rad_s_ + gain(1) * innovation_rad, -kBiasMax_rad_s, kBiasMax_rad_s);
  // P = (I - K C) P; with a gain of zero for the bias its variance stays.
  p_bias_ -= gain(1) * p_cross_;
  p_cross_ -= gain(0) * p_cross_;
  p_apart_ -= gain(0) * p_apart_;
}

// Both agree again: their difference becomes part of the track.
void FusedOdometry::agree() noexcept {
  offset_rad_ += apart_rad_;
  apart_rad_ = 0;
  given_away_rad_ = 0;
  p_apart_ = kGripping_rad2;
  p_cross_ = 0;
  slip_ticks_ = 0;
  quiet_ = {};
}

void FusedOdometry::watch_slip(double wheel_rate_rad_s, double dt_s) noexcept {
  wheel_rate_rad_s_ += (std::fabs(wheel_rate_rad_s) - wheel_rate_rad_s_) * (dt_s / kRemembered_s);
  const double turning_rad_s = std::fmax(wheel_rate_rad_s_, std::fabs(wheel_rate_rad_s));
  if (slip_ticks_ == 0) {
    const double apart_max_rad = threshold<contract::Fault::wheel_slip, "apart">(kApart_rad) +
                                 threshold<contract::Fault::wheel_slip, "apart per rate">(kApartPerRate_s) * turning_rad_s;
    if (std::fabs(apart_rad_) > apart_max_rad) {
      apart_rad_ += given_away_rad_;
      slip_ticks_ = 1;
    }
    return;
  }
  if (slip_ticks_ < 0xFFFF) ++slip_ticks_;
  const bool quiet = std::fabs(slip_rate_rad_s_) < kAgree_rad_s + kAgreePerRate_norm * turning_rad_s;
  if (quiet_.step(quiet, kQuietTicks)) agree();
}

void FusedOdometry::update(const Odometry& wheels, const DriveSensor& left, const DriveSensor& right, const TiltSensor& base,
                           const Derived& derived, double dt_s) noexcept {
  const std::int32_t left_counts = left.moved_counts(), right_counts = right.moved_counts();
  const law::Travel<double> travel = law::odometry_travel(derived.odometry, left_counts, right_counts);
  const bool standing = left_counts == 0 && right_counts == 0 && !left.fresh().lost() && !right.fresh().lost();
  standing_.step(standing, kStandingForEverTicks);
  const double before_rad = offset_rad_ + apart_rad_;
  if (base.rates_fresh().lost() || base.fresh().lost()) {
    // The encoders alone; earlier corrections stay in the track.
    if (gyro_used_) agree();
    gyro_used_ = false;
    slip_rate_rad_s_ = 0;
    yaw_rate_rad_s_ = wheels.yaw_rate_rad_s;
  } else {
    // A new calibration removes its own bias first: what was learnt here shrinks by as much, also when it came while the gyroscope was silent.
    if (gyro_known_) bias_rad_s_ -= derived.base_yaw_bias_rad_s - calibrated_rad_s_;
    calibrated_rad_s_ = derived.base_yaw_bias_rad_s;
    gyro_known_ = true;
    gyro_used_ = true;
    const bool bridged = left.sync_ticks() <= kGyroTicksMost;
    use_gyro({base.yaw_rate_rad_s(), wheels.yaw_rate_rad_s, travel.turn_rad, bridged ? left.sync_ticks() * dt_s : 0.0}, dt_s);
  }
  // Refused only for a track of zero, which params.def does not allow; the pose then simply stays.
  static_cast<void>(law::odometry_advance(law::OdometryMethod::kMidpoint, pose_,
                                          {travel.distance_m, travel.turn_rad + offset_rad_ + apart_rad_ - before_rad}));
}

void FusedOdometry::use_gyro(const Turn& turn, double dt_s) noexcept {
  const double gyro_rad_s = turn.gyro_rad_s, wheel_rate_rad_s = turn.wheel_rad_s;
  // One sample of the gyroscope says nothing about a longer gap: there the encoders alone are believed.
  if (turn.span_s > 0) predict(gyro_rad_s * turn.span_s, turn.wheel_turn_rad, turn.span_s);
  const double true_rad_s = gyro_rad_s - bias_rad_s_;
  // The wheels' rate is a mean since the last report, the gyroscope's one of this moment: after left-out steps they differ without slip.
  if (turn.span_s == dt_s) slip_rate_rad_s_ += (wheel_rate_rad_s - true_rad_s - slip_rate_rad_s_) * (dt_s / kSmoothing_s);
  // A gap that opened in this step is judged before the filter takes any of it for noise.
  watch_slip(wheel_rate_rad_s, dt_s);
  if (!slipping()) {
    given_away_rad_ -= given_away_rad_ * (dt_s / kRemembered_s);
    correct(standing_.reached(kStandingTicks), std::fabs(wheel_rate_rad_s) > kStraight_rad_s);
    yaw_rate_rad_s_ = wheel_rate_rad_s;
    return;
  }
  yaw_rate_rad_s_ = true_rad_s;
  if (!standing_.reached(kStandingForEverTicks) || std::fabs(gyro_rad_s) > kBiasMax_rad_s) return;
  // The apparent turn was bias: the track keeps its heading.
  bias_rad_s_ = std::clamp(bias_rad_s_ - slip_rate_rad_s_, -kBiasMax_rad_s, kBiasMax_rad_s);
  p_bias_ = kBiasAtStart_rad_s * kBiasAtStart_rad_s;
  apart_rad_ = 0;
  slip_rate_rad_s_ = 0;
  agree();
}

}  // namespace hoist::core
