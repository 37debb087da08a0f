// When the watchdog may be fed: only while everything that makes a node safe still moves.
//
// Three counters, each kept by another part of the program: passes of the main loop, 1 kHz ticks, and passes of the CAN service that
// found its controller answering (not frames: a node that hears nothing must brake, not restart). One of them standing still is a hung
// program, whichever of the others goes on. Feeding from an interrupt alone, or from the loop alone, would hide just that.
#pragma once
#include <cstdint>

namespace hoist::firmware {

class WatchdogGate {
 public:
  /// True when all three counters have moved since the last time it was true (at first: since they were zero). May be asked as often as
  /// the loop comes round; the counters wrap.
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
