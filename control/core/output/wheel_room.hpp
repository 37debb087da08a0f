// What the wheels leave for turning: on a curve the outer wheel is faster than the hoist.
#pragma once
#include <cmath>

#include "control/contract/params.hpp"

namespace hoist::core {

/// No motor is asked for more: the top speed of 0.65 m/s through the gear and a wheel of 0.10 m (H1). A full battery turns it hardly faster
/// (24 V / 0.115 V s/rad = 209 rad/s without load), and at 225 rad/s its drive stops it (firmware/nodes/drive, kOverSpeed_rad_s).
inline constexpr double kMotorTop_rad_s = 195.0;

class WheelRoom {
 public:
  explicit WheelRoom(const contract::Params& p) noexcept
      : wheel_m_s_max_{kMotorTop_rad_s / contract::kGearRatio_norm * p.wheel_radius_m * contract::smaller_wheel_scale_norm(p)},
        half_track_m_{p.track_width_m / 2.0} {}

  /// The fastest that the hoist may go while it turns at this rate, and the fastest that it may turn at this speed. Never negative.
  [[nodiscard]] double speed_m_s(double yaw_rate_rad_s) const noexcept { return left(std::fabs(yaw_rate_rad_s) * half_track_m_); }
  [[nodiscard]] double yaw_rate_rad_s(double speed_m_s) const noexcept { return left(std::fabs(speed_m_s)) / half_track_m_; }
  /// The fastest on a curve of this curvature, 1/m.
  [[nodiscard]] double curve_speed_m_s(double kappa_per_m) const noexcept {
    return wheel_m_s_max_ / (1.0 + std::fabs(kappa_per_m) * half_track_m_);
  }

 private:
  [[nodiscard]] double left(double taken_m_s) const noexcept { return taken_m_s < wheel_m_s_max_ ? wheel_m_s_max_ - taken_m_s : 0.0; }

  double wheel_m_s_max_, half_track_m_;
};

}  // namespace hoist::core
