// What a mode is: a file with `enter` (its memory begins anew) and `step` (what it wants now), and a row in mode_list.hpp.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/output/limiter.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct Wish {
  double speed_m_s = 0;
  double yaw_rate_rad_s = 0;
  Braking braking = Braking::none;  // when a stop is in force, the speeds are not looked at
  bool done = false;                // the mode is finished; mode_list.hpp says where that leads
};

/// Standstill, commanded and measured.
[[nodiscard]] inline bool at_rest(const CoreState& state) noexcept {
  return state.limiter.at_rest() && state.sensed.odometry.standing_still;
}

}  // namespace hoist::core
