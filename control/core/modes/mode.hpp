// What a mode is: a file with `enter` (its memory begins anew) and `step` (what it wants now), and a row in mode_list.hpp.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/output/braking.hpp"
#include "control/core/output/speed_limits.hpp"

namespace hoist::core {

struct CoreState;

struct Wish {
  LimitedSpeed speed;
  double yaw_rate_rad_s = 0;
  Braking braking = Braking::none;  // when a stop is in force, the speeds are not looked at
  bool done = false;                // the mode is finished; mode_list.hpp says where that leads
};

}  // namespace hoist::core
