// H13: a bumper touches something. No debouncing on the press: a bounce is a touch. One report; R2 with 1.5 m/s2 within 30 ms.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct BumperPressed {
  static constexpr contract::Fault kFault = contract::Fault::bumper_pressed;

  // While the bumpers are calibrated each is pressed once; the drives are off then.
  bool check(const MonitorView& view) noexcept {
    return view.mode != contract::Mode::init && view.mode != contract::Mode::calibrate &&
           (view.sensed.io.bumpers() & ~view.bumpers_acknowledged) != 0;
  }
};

}  // namespace hoist::core
