// H5: the way to all nodes is gone. As the port says, at once; R2 within 60 ms, and the drives by themselves within 50.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct BusDown {
  static constexpr contract::Fault kFault = contract::Fault::bus_down;

  bool check(const MonitorView& view) noexcept { return view.mode != contract::Mode::init && !(view.bus_up && view.bus_settled); }
};

}  // namespace hoist::core
