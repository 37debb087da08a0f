// H5: the way to all nodes is gone. As the port says, at once; and no interface notices a cable that is cut behind it: then all nodes fall
// silent together (kLostTicks), which one cable explains better than six nodes. R2 within 60 ms, and the drives by themselves within 50.
#pragma once
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct BusDown {
  static constexpr contract::Fault kFault = contract::Fault::bus_down;

  bool check(const MonitorView& view) noexcept {
    bool silent = true;
    for (const NodeRow& row : kNodeRows) silent = silent && view.sensed.heard(row.node).age_ticks() >= hold<kFault, "silence">(kLostTicks);
    return view.mode != contract::Mode::init && (silent || !(view.bus_up && view.bus_settled));
  }
};

}  // namespace hoist::core
