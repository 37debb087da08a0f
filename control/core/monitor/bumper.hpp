// H13: a bumper touches something. No debouncing on the press: a bounce is a touch. One report; R2 with 1.5 m/s2 within 30 ms.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct BumperPressed {
  static constexpr contract::Fault kFault = contract::Fault::bumper_pressed;

  bool check(const MonitorView& view) noexcept { return view.mode != contract::Mode::init && view.sensed.io.bumpers() != 0; }
};

}  // namespace hoist::core
