// FAULT: out of service. Standstill, drives off, holding brakes closed. INIT follows, which checks everything again.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct FaultMode {
  static constexpr contract::Mode kMode = contract::Mode::fault;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& /*state*/, double /*dt_s*/) noexcept { return {}; }
};

}  // namespace hoist::core
