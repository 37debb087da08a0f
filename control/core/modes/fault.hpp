// FAULT: out of service. The hoist stands, its drives are off, the holding brakes closed. It is left to INIT, which checks everything anew.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct FaultMode {
  static constexpr contract::Mode kMode = contract::Mode::fault;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& /*state*/, double /*dt_s*/) noexcept { return {}; }
};

}  // namespace hoist::core
