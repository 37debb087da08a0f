// Two driven wheels on one axle: platform speed and yaw rate to wheel speeds and back. Implied by the paper only (D26).
#pragma once

#include <cmath>

namespace hoist::law {

template <typename Real>
struct WheelSpeeds {
  Real left_m_s{};
  Real right_m_s{};
};

template <typename Real>
struct PlatformSpeed {
  Real v_m_s{};
  Real omega_rad_s{};  ///< positive turns left
};

/// The size of the controllers' "speed unit" (D18). The defaults are those of the preset "paper": 1 cm/s and 1 deg/s.
template <typename Real>
struct SpeedScale {
  Real v_m_s_per_unit{Real(0.01)};
  Real omega_rad_s_per_unit{Real(0.017453292519943295)};
};

template <typename Real>
[[nodiscard]] constexpr PlatformSpeed<Real> platform_speed(Real v_units, Real omega_units, const SpeedScale<Real>& scale) {
  return {v_units * scale.v_m_s_per_unit, omega_units * scale.omega_rad_s_per_unit};
}

/// v_left = v - omega d_ww / 2, v_right = v + omega d_ww / 2: ground speed of each wheel.
template <typename Real>
[[nodiscard]] constexpr WheelSpeeds<Real> wheel_speeds(const PlatformSpeed<Real>& speed, Real track_m) {
  const Real half_m_s = speed.omega_rad_s * track_m / Real(2);
  return {speed.v_m_s - half_m_s, speed.v_m_s + half_m_s};
}

/// The inverse of wheel_speeds; the track must not be zero.
template <typename Real>
[[nodiscard]] constexpr PlatformSpeed<Real> platform_speed_of(const WheelSpeeds<Real>& wheels, Real track_m) {
  return {(wheels.left_m_s + wheels.right_m_s) / Real(2), (wheels.right_m_s - wheels.left_m_s) / track_m};
}

}  // namespace hoist::law
