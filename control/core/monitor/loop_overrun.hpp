// H22: the loop woke too late, once badly or twice within a second.
#pragma once
#include <cstdint>

#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

/// A step that began later than this counts as late.
inline constexpr float kLate_s = 0.005F;

class LoopOverrun {
 public:
  static constexpr contract::Fault kFault = contract::Fault::loop_overrun;

  bool check(const MonitorView& view) noexcept {
    if (since_late_ticks_ < kWindowTicks) ++since_late_ticks_;
    bool trip = !(view.wake_lateness_s <= kFarTooLate_s);
    if (!(view.wake_lateness_s <= kLate_s)) {
      trip = trip || since_late_ticks_ < kWindowTicks;
      since_late_ticks_ = 0;
    }
    // A hoist that stands with its drives off loses nothing by a late step; the count of late steps tells of it.
    return view.moving && trip;
  }

 private:
  static constexpr float kFarTooLate_s = 0.030F;
  static constexpr std::uint8_t kWindowTicks = 100;

  std::uint8_t since_late_ticks_ = kWindowTicks;
};

}  // namespace hoist::core
