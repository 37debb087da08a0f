// H3, H4, H14: a node's periodic data have stopped for 50 ms (kLostTicks).
#pragma once
#include "control/core/monitor/monitor.hpp"
#include "control/core/monitor/mutation.hpp"

namespace hoist::core {

template <contract::Node kNode, contract::Fault kWhich>
struct NodeLost {
  static constexpr contract::Fault kFault = kWhich;

  bool check(const MonitorView& view) noexcept {
    // While the whole bus is down there is one cause to mend and one alarm to read, not six more.
    return view.mode != contract::Mode::init && view.bus_settled &&
           view.sensed.heard(kNode).age_ticks() >= hold<kFault, "silence">(kLostTicks);
  }
};

}  // namespace hoist::core
