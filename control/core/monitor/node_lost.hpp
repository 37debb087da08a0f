// H3, H4, H14: a node's periodic data have stopped for 50 ms (kLostTicks); of the input node also the batteries' for kBatteryTicks (H12: a
// held voltage must not pass for a charged battery). R2 within 60 ms.
#pragma once
#include "control/core/monitor/monitor.hpp"
#include "control/core/monitor/mutation.hpp"

namespace hoist::core {

template <contract::Node kNode, contract::Fault kWhich>
struct NodeLost {
  static constexpr contract::Fault kFault = kWhich;

  // 25 of its frames: one in a hundred may be lost without ever coming to this.
  static constexpr int kBatteryTicks = 250;

  bool check(const MonitorView& view) noexcept {
    bool batteries_lost = false;
    if constexpr (kNode == contract::Node::io) batteries_lost = view.sensed.io.battery_silent(hold<kFault, "batteries">(kBatteryTicks));
    // While the whole bus is down there is one cause to mend and one alarm to read, not six more.
    return view.mode != contract::Mode::init && view.bus_settled &&
           (batteries_lost || view.sensed.heard(kNode).age_ticks() >= hold<kFault, "silence">(kLostTicks));
  }
};

}  // namespace hoist::core
