// From platform speed to what the two drives are told: wheel ground speeds, then motor speed in steps of 60FFh.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/law/differential_drive.hpp"

namespace hoist::core {

struct WheelCommand {
  std::int32_t left_raw = 0, right_raw = 0;  // 60FFh
};

/// 60FFh: one step is this many rad/s at the motor, and no drive takes more than its range.
inline constexpr const contract::ObjectInfo& kTargetVelocity = *contract::find_object(contract::NodeKind::drive, 0x60FF, 0);

[[nodiscard]] inline double wheel_m_s(std::int32_t raw, double motor_per_m) noexcept {
  return static_cast<double>(raw) * kTargetVelocity.scale / motor_per_m;
}

/// When one wheel would pass the range of its drive, both slow down alike: the hoist stays on its curve.
[[nodiscard]] inline WheelCommand mix_wheels(double speed_m_s, double yaw_rate_rad_s, const Derived& derived) noexcept {
  const auto wheels = law::wheel_speeds<double>({speed_m_s, yaw_rate_rad_s}, derived.odometry.track_m);
  double left = wheels.left_m_s * derived.left_motor_per_m / kTargetVelocity.scale;
  double right = wheels.right_m_s * derived.right_motor_per_m / kTargetVelocity.scale;
  const double largest = std::fmax(std::fabs(left), std::fabs(right));
  if (!(largest <= kTargetVelocity.max)) {
    if (!std::isfinite(largest)) return {};
    left *= kTargetVelocity.max / largest;
    right *= kTargetVelocity.max / largest;
  }
  return {static_cast<std::int32_t>(std::lround(left)), static_cast<std::int32_t>(std::lround(right))};
}

}  // namespace hoist::core
