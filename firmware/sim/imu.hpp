// One simulated gyroscope and accelerometer: noise, a bias per axis, and a slow wander of the gyroscope's biases.
#pragma once

#include <cmath>

#include "firmware/sim/model.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::sim {

/// Defaults: the class of consumer MEMS the paper's boards carried (assumed; it names no part). Gyroscope 0.014 deg/s/sqrt(Hz) over 50 Hz,
/// accelerometer 400 ug/sqrt(Hz) over 50 Hz.
struct ImuParams {
  double gyro_noise_rad_s{0.1 * kDegree_rad};
  double gyro_bias_rad_s{1.0 * kDegree_rad};             ///< largest bias at power-on
  double gyro_wander_rad_s_sqrt_s{0.002 * kDegree_rad};  ///< random walk of the bias, per root second
  double acc_noise_m_s2{0.03};
  double acc_bias_m_s2{0.02};  ///< 0.12 deg of tilt
  double gyro_late_s{0.0049};  ///< group delay of the chip's low-pass at 44 Hz (firmware/lib/imu)
};

class Imu {
 public:
  Imu(const ImuParams& params, std::uint64_t seed) : params_(params), random_(seed) {
    for (double& bias : gyro_bias_rad_s_) bias = random_.uniform(-params.gyro_bias_rad_s, params.gyro_bias_rad_s);
    for (double& bias : acc_bias_m_s2_) bias = random_.uniform(-params.acc_bias_m_s2, params.acc_bias_m_s2);
  }

  /// Adds what the chip adds. age_s is the time since the sample before.
  [[nodiscard]] ImuReading corrupt(const ImuReading& truth, double age_s) {
    // Root of the sample interval: 10 ms nearly always.
    const double wander_rad_s = params_.gyro_wander_rad_s_sqrt_s * std::sqrt(age_s);
    for (double& bias : gyro_bias_rad_s_) bias += wander_rad_s * random_.normal();
    ImuReading out;
    out.ax_m_s2 = truth.ax_m_s2 + acc_bias_m_s2_[0] + params_.acc_noise_m_s2 * random_.normal();
    out.ay_m_s2 = truth.ay_m_s2 + acc_bias_m_s2_[1] + params_.acc_noise_m_s2 * random_.normal();
    out.az_m_s2 = truth.az_m_s2 + acc_bias_m_s2_[2] + params_.acc_noise_m_s2 * random_.normal();
    out.alpha_rate_rad_s = truth.alpha_rate_rad_s + gyro_bias_rad_s_[0] + params_.gyro_noise_rad_s * random_.normal();
    out.beta_rate_rad_s = truth.beta_rate_rad_s + gyro_bias_rad_s_[1] + params_.gyro_noise_rad_s * random_.normal();
    out.yaw_rate_rad_s = truth.yaw_rate_rad_s + gyro_bias_rad_s_[2] + params_.gyro_noise_rad_s * random_.normal();
    return out;
  }

  /// A sudden change of the bias of alpha, for the tests of hazard H8.
  void jump_bias(double by_rad_s) { gyro_bias_rad_s_[0] += by_rad_s; }

 private:
  ImuParams params_;
  Random random_;
  double gyro_bias_rad_s_[3]{};
  double acc_bias_m_s2_[3]{};
};

}  // namespace hoist::sim
