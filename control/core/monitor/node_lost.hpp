// H3, H4, H14: a node's periodic data have stopped for 50 ms (kLostTicks), of the chassis also its rates alone (slip, a lost zero and the
// watch over a stop go by them: H2, H8, H10); of the input node also the batteries' for kBatteryTicks (H12: a held voltage must not pass for
// a charged battery). R2 within 60 ms.
#pragma once
#include <algorithm>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <contract::Node kNode>
struct NodeLost {
  static constexpr const NodeRow& kRow = kNodeRows[static_cast<std::size_t>(kNode)];
  static constexpr contract::Fault kFault = kRow.lost;

  // 25 of its frames: one in a hundred may be lost without ever coming to this.
  static constexpr int kBatteryTicks = 250;

  bool check(const MonitorView& view) noexcept {
    bool batteries_lost = false;
    if constexpr (kRow.io != nullptr) batteries_lost = view.sensed.io.battery_silent(hold<kFault, "batteries">(kBatteryTicks));
    auto age_ticks = view.sensed.heard(kNode).age_ticks();
    if constexpr (kRow.yaw_bias_rad_s != nullptr) age_ticks = std::max(age_ticks, view.sensed.base.rates_fresh().age_ticks());
    // While the whole bus is down only bus_down is raised: one cause, one alarm.
    return view.mode != contract::Mode::init && view.bus_settled && (batteries_lost || age_ticks >= hold<kFault, "silence">(kLostTicks));
  }
};

}  // namespace hoist::core
