// Whether the hoist stands.
#pragma once
#include <cmath>

#include "control/core/state.hpp"

namespace hoist::core {

/// Standstill, as far as it can be known. A wheel whose drive has been silent for as long as an age counts (2.55 s)
/// cannot be asked: its drive stopped 45 ms after it was cut off, and a wheel that still turned would turn the chassis.
/// Starts require every drive (start_refusals), so this only matters for leaving a stop.
[[nodiscard]] inline bool stands(const Estimate& sensed) noexcept {
  if (!sensed.drives_lost()) return sensed.odometry.standing_still;
  // As HoldWatch: 0.05 m/s at one wheel of 0.7 m track.
  constexpr double kTurn_rad_s = 0.07;
  const auto wheel_stands = [](const DriveSensor& drive, double wheel_m_s) {
    return drive.fresh().lost() ? drive.fresh().age_ticks() == kOldestTicks : std::fabs(wheel_m_s) < kStandstill_m_s;
  };
  return wheel_stands(sensed.left_drive, sensed.odometry.wheel_left_m_s) &&
         wheel_stands(sensed.right_drive, sensed.odometry.wheel_right_m_s) &&
         (sensed.base.rates_fresh().lost() || std::fabs(sensed.base.yaw_rate_rad_s()) < kTurn_rad_s);
}

/// Standstill, commanded and measured.
[[nodiscard]] inline bool at_rest(const CoreState& state) noexcept { return state.limiter.at_rest() && stands(state.sensed); }

}  // namespace hoist::core
