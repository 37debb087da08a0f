// H30: an id, known or unknown, floods the bus, or the bus as a whole is fuller than allowed. Commands and sensor data
// would soon be late.
#pragma once
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct NodeBabbling {
  static constexpr contract::Fault kFault = contract::Fault::node_babbling;

  bool check(const MonitorView& view) noexcept {
    const bool full = !(view.health.load().load_norm() <= threshold<kFault, "load">(view.params.bus_load_norm_max));
    return view.mode != contract::Mode::init && (full || view.health.babbling_id() != BusHealth::kNoId);
  }
};

}  // namespace hoist::core
