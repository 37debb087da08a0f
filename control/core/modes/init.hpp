// INIT: from switching on until every node is known, has its parameters and sends sound data. The wheels do not turn.
#pragma once
#include "control/core/modes/mode.hpp"
#include "control/core/monitor/emergency_stop.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct InitMode {
  static constexpr contract::Mode kMode = contract::Mode::init;
  /// Everything must hold this long before STANDBY, so that an intermittent node does not count as present.
  static constexpr std::uint8_t kClearTicks = 10;
  /// A tool that says nothing for two seconds has gone; a node that restarts needs less.
  static constexpr std::uint8_t kServiceTicks = 200;

  static void enter(CoreState& state) noexcept { state.clear = {}; }

  static Wish step(CoreState& state, double /*dt_s*/) noexcept {
    Service& service = state.in_mode.service;
    if (service.on) {
      // The client that began it must still hold the lease and be reachable.
      const bool led = state.lease.holder != 0 && state.lease.epoch == state.in_mode.epoch && state.server.alive();
      if (!led || ++service.quiet_ticks >= kServiceTicks) service = {};
      state.clear = {};
      return {};
    }
    const Estimate& sensed = state.sensed;
    const auto sound = [](const TiltSensor& tilt) {
      return !tilt.fresh().stale() && !tilt.has(tilt_status::kSelfTestFailed) && !tilt.has(tilt_status::kGyroSaturated);
    };
    // A bus that has just come up may go down again; outside INIT that is a fault.
    const bool ready = state.bus_settle_ticks == 0 && state.master.all_running() && sound(sensed.left_strut) && sound(sensed.right_strut) &&
                       sound(sensed.base) && !sensed.base.rates_fresh().stale() && !sensed.drives_lost() && !sensed.io.fresh().lost() &&
                       sensed.io.battery_known() && !motors_unpowered(sensed) && !state.left_control.resetting() &&
                       !state.right_control.resetting();
    const bool clear = state.clear.step(ready, kClearTicks);
    return {0, 0, Braking::none, clear};
  }
};

}  // namespace hoist::core
