// What the wheels leave for turning: on a curve the outer wheel is faster than the hoist.
#pragma once
#include <cmath>

#include "control/contract/params.hpp"

namespace hoist::core {

/// What speed and turn together may ask of a motor: 0.70 m/s through the gear and a wheel of 0.10 m, so that a hoist at its top speed of
/// 0.65 m/s can still steer. Without load an empty battery turns it at 198 rad/s and a full one at 223 (22.8 and 25.6 V / 0.115 V s/rad); a
/// wheel that stays behind by so little trips nothing (following_error_m_s_max), and at 225 rad/s its drive stops it (H1; firmware/nodes/drive,
/// kOverSpeed_rad_s).
inline constexpr double kMotorTop_rad_s = 210.0;

class WheelRoom {
 public:
  explicit WheelRoom(const contract::Params& p) noexcept
      : wheel_m_s_max_{kMotorTop_rad_s / contract::kGearRatio_norm * p.wheel_radius_m * contract::smaller_wheel_scale_norm(p)},
        half_track_m_{p.track_width_m / 2.0} {}

  /// How far these two requests can be met together. The turn has priority up to half of the wheels' range: the whole
  /// range could stop the walk for a turn on the spot (small wheels, wide track).
  [[nodiscard]] double speed_share_m_s(double speed_m_s, double yaw_rate_rad_s) const noexcept {
    return std::fmin(std::fabs(speed_m_s), std::fmax(speed_left_m_s(yaw_rate_rad_s), wheel_m_s_max_ / 2.0));
  }
  [[nodiscard]] double yaw_share_rad_s(double speed_m_s, double yaw_rate_rad_s) const noexcept {
    return std::fmin(std::fabs(yaw_rate_rad_s), yaw_left_rad_s(speed_share_m_s(speed_m_s, yaw_rate_rad_s)));
  }
  /// What a hoist that turns so leaves for its speed, and one that goes so for its turn. Never negative.
  [[nodiscard]] double speed_left_m_s(double yaw_rate_rad_s) const noexcept {
    return std::fmax(wheel_m_s_max_ - std::fabs(yaw_rate_rad_s) * half_track_m_, 0.0);
  }
  [[nodiscard]] double yaw_left_rad_s(double speed_m_s) const noexcept {
    return std::fmax(wheel_m_s_max_ - std::fabs(speed_m_s), 0.0) / half_track_m_;
  }
  /// The fastest on a curve of this curvature, 1/m.
  [[nodiscard]] double curve_speed_m_s(double kappa_per_m) const noexcept {
    return wheel_m_s_max_ / (1.0 + std::fabs(kappa_per_m) * half_track_m_);
  }

 private:
  double wheel_m_s_max_, half_track_m_;
};

}  // namespace hoist::core
