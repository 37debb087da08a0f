// CALIBRATE: the machine is measured. The drives are off, so the hoist can be pushed by hand; it ends when asked to, when whoever began it no
// longer leads, or after a minute.
#pragma once
#include <cstdint>

#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct CalibrateMode {
  static constexpr contract::Mode kMode = contract::Mode::calibrate;
  /// Research on safety 2.3: 60 s.
  static constexpr std::uint64_t kTicksMax = 6000;

  static void enter(CoreState& /*state*/) noexcept {}
  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    const bool led = state.lease.holder != 0 && state.lease.epoch == state.motion.epoch && state.server.alive();
    return {0, 0, Braking::none, !led || state.motion.leaving || state.motion.ticks >= kTicksMax};
  }
};

}  // namespace hoist::core
