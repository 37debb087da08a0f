// H30: two nodes share one id, or a second control computer is on the bus. Frames of that id come from either of them,
// so none can be trusted. Evidence and its limits: health/bus_health.hpp.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct NodeDuplicate {
  static constexpr contract::Fault kFault = contract::Fault::node_duplicate;

  bool check(const MonitorView& view) noexcept { return view.mode != contract::Mode::init && view.health.duplicate_id() != 0; }
};

}  // namespace hoist::core
