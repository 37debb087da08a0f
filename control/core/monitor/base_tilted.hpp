// H9: the chassis stands so steeply, on a ramp or half over a threshold, that it may run away or tip.
//
// base_tilt_stop_rad for 100 ms; R2 within 200 ms.
#pragma once
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/base_tilt.hpp"

namespace hoist::core {

class BaseTilted {
 public:
  static constexpr contract::Fault kFault = contract::Fault::base_tilted;

  bool check(const MonitorView& view) noexcept {
    const bool steep = base_leans_beyond(view.sensed, threshold<kFault, "angle">(view.params.base_tilt_stop_rad));
    const bool lasts = steep_.step(steep, hold<kFault, "time">(kBaseTiltTicks));
    return view.mode != contract::Mode::init && lasts;
  }

 private:
  Lasting steep_;
};

}  // namespace hoist::core
