// INIT: from switching on until every node is known, has its parameters and sends sound data. The wheels do not turn.
#pragma once
#include "control/core/modes/mode.hpp"

namespace hoist::core {

struct InitMode {
  static constexpr contract::Mode kMode = contract::Mode::init;
  /// Everything must hold this long before STANDBY: a node that comes and goes is not there.
  static constexpr std::uint8_t kClearTicks = 10;

  static void enter(CoreState& state) noexcept { state.clear_ticks = 0; }

  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    const Estimate& sensed = state.sensed;
    const auto sound = [](const TiltSensor& tilt) {
      return !tilt.fresh().stale() && !tilt.has(tilt_status::kSelfTestFailed) && !tilt.has(tilt_status::kGyroSaturated);
    };
    // A bus that has only just come up may still go again; outside INIT that would be a fault.
    const bool ready = state.bus_settle_ticks == 0 && state.master.all_running() && sound(sensed.left_strut) && sound(sensed.right_strut) &&
                       sound(sensed.base) && !sensed.drives_lost() && !sensed.io.fresh().lost() && sensed.io.battery_known();
    state.clear_ticks =
        !ready ? std::uint8_t{0} : static_cast<std::uint8_t>(state.clear_ticks < kClearTicks ? state.clear_ticks + 1 : kClearTicks);
    return {0, 0, Braking::none, state.clear_ticks == kClearTicks};
  }
};

}  // namespace hoist::core
