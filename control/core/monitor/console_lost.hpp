// H21: nobody is in control of a hoist that was led, because the console is gone. Patient-led walking goes on; the hoist calls for somebody.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct ConsoleLost {
  static constexpr contract::Fault kFault = contract::Fault::console_lost;

  bool check(const MonitorView& view) noexcept { return view.console_gone; }
};

}  // namespace hoist::core
