// H21: the console in control of a hoist that was led is gone, and no other has taken over. Patient-led walking goes on; the alarm calls a person.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct ConsoleLost {
  static constexpr contract::Fault kFault = contract::Fault::console_lost;

  bool check(const MonitorView& view) noexcept { return view.console_gone; }
};

}  // namespace hoist::core
