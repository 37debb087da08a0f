// When the watchdog may be fed: only while every safety-related part still runs.
//
// Three counters: passes of the main loop, 1 kHz ticks, and passes of the CAN service with an answering controller (not frames: a node
// without frames must brake, not restart). If any of them stops, the program hangs. Feeding from an interrupt alone, or from the loop
// alone, would hide that.
#pragma once
#include <cstdint>

namespace hoist::firmware {

class WatchdogGate {
 public:
  /// True when all three counters have advanced since it was last true (at first: since zero). May be called in every pass; the counters
  /// wrap.
  [[nodiscard]] constexpr bool should_feed(std::uint32_t loop_count, std::uint32_t tick_count, std::uint32_t can_count) {
    if (loop_count == loop_count_ || tick_count == tick_count_ || can_count == can_count_) return false;
    loop_count_ = loop_count;
    tick_count_ = tick_count;
    can_count_ = can_count;
    return true;
  }

 private:
  std::uint32_t loop_count_ = 0, tick_count_ = 0, can_count_ = 0;
};

}  // namespace hoist::firmware
