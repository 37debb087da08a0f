// A mode: a file with `enter` (clears its memory) and `step` (what it requests now), and a row in mode_list.hpp.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/output/braking.hpp"
#include "control/core/output/speed_limits.hpp"

namespace hoist::core {

struct CoreState;

struct Wish {
  LimitedSpeed speed;
  double yaw_rate_rad_s = 0;
  Braking braking = Braking::none;  // while a stop is in force the speeds are ignored
  bool done = false;                // the mode is finished; mode_list.hpp says where that leads
};

}  // namespace hoist::core
