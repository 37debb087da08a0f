// STANDBY: everything is there and nothing moves; the drives are off and their spring-applied brakes hold; the hoist can be pushed once
// its brakes are released by hand. A body in the stops that rolls it is held all the same (monitor/fall.hpp).
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct StandbyMode {
  static constexpr contract::Mode kMode = contract::Mode::standby;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& /*state*/, double /*dt_s*/) noexcept { return {}; }
};

}  // namespace hoist::core
