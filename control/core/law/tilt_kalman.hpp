// The one-axis tilt filter of the sensor nodes: static Kalman filter, equations (8)-(18), page 5. Two of these per sensor.
#pragma once

#include <cmath>

#include "control/core/law/finite.hpp"

namespace hoist::law {

/// Static gain. The default is the PRINTED one (14). It is not the solution of (13), which is (0.028434, -0.034849) (see
/// kalman_gain.hpp); it rejects gait accelerations about 2.8 times better and learns a gyro bias more slowly (17 s), so the bias is
/// measured at standstill on start instead.
template <typename Real>
struct TiltGain {
  Real k_angle{Real(0.0102)};
  Real k_bias{Real(-0.0013)};
};

/// What one axis remembers.
template <typename Real>
struct TiltState {
  Real angle_rad{};
  Real bias_rad_s{};           ///< the gyro's output at rest
  Real previous_rate_rad_s{};  ///< (15) integrates the rate of the previous sample (D22)
};

/// Angles from gravity alone.
template <typename Real>
struct AccAngles {
  Real alpha_rad{};
  Real beta_rad{};
  bool valid{false};  ///< false when a component is not finite or the vector is zero; the angles are then zero
};

/// Reading of (17)-(18) that is consistent with z up (D21): specific force in the sensor frame (at rest 0, 0, +g), any unit.
template <typename Real>
[[nodiscard]] inline AccAngles<Real> acc_angles(Real ax, Real ay, Real az) {
  if (!finite(ax) || !finite(ay) || !finite(az)) return {};
  if (ax == Real(0) && ay == Real(0) && az == Real(0)) return {};
  return {std::atan2(-ax, az), std::atan2(ay, az), true};
}

/// Start of the filter (D23): the first accelerometer angle, the bias measured at rest, the first rate sample.
template <typename Real>
[[nodiscard]] inline TiltState<Real> tilt_start(Real angle_rad, Real bias_rad_s, Real rate_rad_s) {
  if (!finite(angle_rad) || !finite(bias_rad_s) || !finite(rate_rad_s)) return {};
  return {angle_rad, bias_rad_s, rate_rad_s};
}

/// One step, prediction (15) and correction (16). `rate_rad_s` is this sample's rate (used by the next step), `acc_angle_rad` this
/// sample's angle from gravity. False when an input is not usable: the state is then unchanged and the caller must count the sample as
/// missing.
template <typename Real>
[[nodiscard]] inline bool tilt_step(const TiltGain<Real>& gain, TiltState<Real>& state, Real rate_rad_s, Real acc_angle_rad, Real dt_s) {
  if (!finite(rate_rad_s) || !finite(acc_angle_rad) || !finite(dt_s) || !(dt_s > Real(0))) return false;
  const Real predicted_rad = state.angle_rad + dt_s * (state.previous_rate_rad_s - state.bias_rad_s);  // (15)
  const Real innovation_rad = acc_angle_rad - predicted_rad;
  const Real angle_rad = predicted_rad + gain.k_angle * innovation_rad;     // (16)
  const Real bias_rad_s = state.bias_rad_s + gain.k_bias * innovation_rad;  // (16)
  // Two finite inputs can still overflow together.
  if (!finite(angle_rad) || !finite(bias_rad_s)) return false;
  state = {angle_rad, bias_rad_s, rate_rad_s};
  return true;
}

}  // namespace hoist::law
