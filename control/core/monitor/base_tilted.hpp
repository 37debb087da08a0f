// H9: the chassis stands so steeply, on a ramp or half over a threshold, that it may run away or tip.
//
// base_tilt_stop_rad for 100 ms; R2 within 200 ms.
#pragma once
#include <cstdint>

#include "control/core/monitor/base_tilt.hpp"
#include "control/core/monitor/mutation.hpp"

namespace hoist::core {

class BaseTilted {
 public:
  static constexpr contract::Fault kFault = contract::Fault::base_tilted;

  bool check(const MonitorView& view) noexcept {
    const std::uint8_t limit_ticks = hold<kFault, "time">(kBaseTiltTicks);
    const bool steep = base_leans_beyond(view.sensed, threshold<kFault, "angle">(view.params.base_tilt_stop_rad));
    ticks_ = !steep ? std::uint8_t{0} : static_cast<std::uint8_t>(ticks_ < limit_ticks ? ticks_ + 1 : limit_ticks);
    return view.mode != contract::Mode::init && ticks_ >= limit_ticks;
  }

 private:
  std::uint8_t ticks_ = 0;
};

}  // namespace hoist::core
