// H5: the way to all nodes is gone.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct BusDown {
  static constexpr contract::Fault kFault = contract::Fault::bus_down;

  bool check(const MonitorView& view) noexcept { return view.mode != contract::Mode::init && !(view.bus_up && view.bus_settled); }
};

}  // namespace hoist::core
