// Where the hoist is, although its wheels may slip: the heading of the encoders, held against the gyroscope of the chassis. The paper lost
// the track of its fifth subject to slip; here the encoder-only track stays beside this one.
//
// While the wheels grip, the encoders are the better compass: they do not drift. A Kalman filter over two states watches how far the
// heading of the gyroscope runs away from theirs: the disagreement since they last agreed, and the gyroscope's bias. Wheels that slip turn
// the encoders without the hoist, or the hoist without the encoders, and the disagreement grows faster than drift and a wrong track width
// can explain. From then on the gyroscope leads, and what the filter gave away to the encoders since the slip began is taken back; once
// both agree again the whole disagreement is kept as a correction.
//
// What cannot be seen: both wheels slipping by the same amount (the yaw rate is right, the distance is not), and a slip slower than the
// drift of the bias. During a slip the distance is the mean of both wheels; which of them grips is not known.
#pragma once
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/estimate/odometry.hpp"
#include "control/core/estimate/tilt_sensor.hpp"

namespace hoist::core {

class FusedOdometry {
 public:
  /// After Odometry::update of the same step. Without the gyroscope (its message lost or its samples invalid for 50 ms) the encoders lead alone.
  void update(const Odometry& wheels, const DriveSensor& left, const DriveSensor& right, const TiltSensor& base, const Derived& derived,
              double dt_s) noexcept;

  /// Puts the track somewhere else; what is known about gyroscope and slip stays.
  void set_pose(const law::Pose<double>& pose) noexcept { pose_ = pose; }

  [[nodiscard]] const law::Pose<double>& pose() const noexcept { return pose_; }
  /// Left positive; of the encoders while they grip, of the gyroscope without its bias while they do not.
  [[nodiscard]] double yaw_rate_rad_s() const noexcept { return yaw_rate_rad_s_; }
  /// What the gyroscope shows at rest beyond what its node and the calibration (base_yaw_bias_rad_s) have taken away already.
  [[nodiscard]] double gyro_bias_rad_s() const noexcept { return bias_rad_s_; }
  /// How much faster the encoders turn than the gyroscope, smoothed over 50 ms.
  [[nodiscard]] double slip_rate_rad_s() const noexcept { return slip_rate_rad_s_; }
  [[nodiscard]] bool slipping() const noexcept { return slip_ticks_ > 0; }
  /// Steps from noticing the slip to its last sign; 0 = the wheels grip.
  [[nodiscard]] std::uint16_t slip_ticks() const noexcept { return static_cast<std::uint16_t>(slip_ticks_ - quiet_.ticks); }
  /// False while the track is the encoders' alone.
  [[nodiscard]] bool gyro_used() const noexcept { return gyro_used_; }

 private:
  struct Turn {
    double gyro_rad_s, wheel_rad_s, wheel_turn_rad;
    double span_s;  // between the newest two SYNCs; 0 = longer than the gyroscope's sample can stand for
  };
  void use_gyro(const Turn& turn, double dt_s) noexcept;
  void predict(double gyro_turn_rad, double wheel_turn_rad, double dt_s) noexcept;
  void correct(bool standing, bool turning) noexcept;
  void watch_slip(double wheel_rate_rad_s, double dt_s) noexcept;
  void agree() noexcept;

  law::Pose<double> pose_;
  double yaw_rate_rad_s_ = 0, slip_rate_rad_s_ = 0, wheel_rate_rad_s_ = 0;
  // States: how far the gyroscope's heading is ahead of the encoders' since they last agreed, and the bias.
  double apart_rad_ = 0, bias_rad_s_ = 0;
  // Their covariance; at first nothing is known about the bias but its size.
  double p_apart_ = 0, p_cross_ = 0, p_bias_ = kBiasAtStart_rad_s * kBiasAtStart_rad_s;
  double calibrated_rad_s_ = 0;  // taken away by calibration when the bias was learnt
  double offset_rad_ = 0;        // all that earlier slips have turned the hoist beyond the encoders
  double given_away_rad_ = 0;    // what corrections took from `apart` lately
  std::uint16_t slip_ticks_ = 0;
  Lasting quiet_, standing_;
  bool gyro_used_ = false;
  bool gyro_known_ = false;  // it was used once

  static constexpr double kBiasAtStart_rad_s = 0.0175;  // 1 deg/s: the usual offset of a consumer gyroscope
};

}  // namespace hoist::core
