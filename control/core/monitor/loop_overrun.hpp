// H22: the loop woke too late, once badly (loop_late_s_max) or twice within a second (a sixth of it). R2 within 40 ms.
#pragma once
#include <algorithm>
#include <cstdint>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

/// A step that began later than this is counted (H22: 2 ms); alone it changes nothing.
inline constexpr float kLate_s = 0.002F;

class LoopOverrun {
 public:
  static constexpr contract::Fault kFault = contract::Fault::loop_overrun;

  bool check(const MonitorView& view) noexcept {
    since_late_ticks_ = static_cast<std::uint8_t>(std::min(since_late_ticks_ + 1, int{kWindowTicks}));
    const double lateness_s = static_cast<double>(view.wake_lateness_s);
    const double far_too_late_s = view.params.loop_late_s_max;
    bool trip = !(lateness_s <= threshold<kFault, "once">(far_too_late_s));
    if (!(lateness_s <= threshold<kFault, "twice">(far_too_late_s * kLateShare))) {
      trip = trip || since_late_ticks_ < hold<kFault, "window", Laxer::lower>(kWindowTicks);
      since_late_ticks_ = 0;
    }
    // At standstill with the drives off a late step does no harm; it is only counted.
    return view.moving && trip;
  }

 private:
  static constexpr double kLateShare = 1.0 / 6.0;  // H22: 5 ms of 30 ms
  static constexpr std::uint8_t kWindowTicks = 100;

  std::uint8_t since_late_ticks_ = kWindowTicks;
};

}  // namespace hoist::core
