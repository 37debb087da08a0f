// Where the hoist is and how fast it goes: equations (19)-(23) over what both drives report.
#pragma once
#include <cmath>

#include "control/core/base/derived.hpp"
#include "control/core/estimate/drive_sensor.hpp"
#include "control/core/law/odometry.hpp"

namespace hoist::core {

/// Below this wheel speed the hoist stands still (signals.def, standing_still).
inline constexpr double kStandstill_m_s = 0.02;

struct Odometry {
  law::Pose<double> pose;
  double distance_m = 0;
  double wheel_left_m_s = 0, wheel_right_m_s = 0;
  double speed_m_s = 0, yaw_rate_rad_s = 0;
  bool standing_still = false;

  void update(const DriveSensor& left, const DriveSensor& right, const Derived& derived, double dt_s) noexcept {
    const std::int32_t left_counts = left.moved_counts(), right_counts = right.moved_counts();
    if (left.moved_ticks() > 0)
      wheel_left_m_s = static_cast<double>(left_counts) * derived.odometry.left_m_per_count / (dt_s * left.moved_ticks());
    if (right.moved_ticks() > 0)
      wheel_right_m_s = static_cast<double>(right_counts) * derived.odometry.right_m_per_count / (dt_s * right.moved_ticks());
    if (left_counts != 0 || right_counts != 0) {
      distance_m += std::fabs(law::odometry_travel(derived.odometry, left_counts, right_counts).distance_m);
      // Refused only for a track of zero, which params.def does not allow; the pose then simply stays.
      static_cast<void>(law::odometry_step(derived.odometry, pose, left_counts, right_counts));
    }
    speed_m_s = (wheel_left_m_s + wheel_right_m_s) / 2.0;
    yaw_rate_rad_s = (wheel_right_m_s - wheel_left_m_s) / derived.odometry.track_m;
    // Without data from a wheel its standstill is unknown.
    standing_still = !left.fresh().lost() && !right.fresh().lost() && std::fabs(wheel_left_m_s) < kStandstill_m_s &&
                     std::fabs(wheel_right_m_s) < kStandstill_m_s;
  }
};

}  // namespace hoist::core
