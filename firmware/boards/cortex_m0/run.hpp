// The main loop of every image: frames, ticks, watchdog, sleep.
//
// A chip's board base (lpc11c24/board.hpp, stm32f072/board.hpp) provides:
//   bool receive(CanFrame&)       next received frame, oldest first
//   bool has_frame()              whether one is waiting
//   bool service()                moves waiting frames into the controller; called at every round; true when the controller answers
//   void feed_watchdog()
//   void set_led(bool on)
//   void started_well()           the program has run for a while: clears the count of failed starts
// and a board, where its hardware asks for it:
//   void tick_1ms()               before the node's
//   bool has_work()               the node has something to do before the next interrupt
#pragma once
#include <cstdint>

#include "control/contract/can_frame.hpp"
#include "firmware/boards/cortex_m0/registers.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/lib/mailbox.hpp"
#include "firmware/lib/watchdog_gate.hpp"

namespace hoist::firmware::cortex_m0 {

inline constexpr std::uint32_t kFramesPerRound = 8;   // a babbling bus must not keep the loop from its tick
inline constexpr std::uint32_t kTicksToCatchUp = 20;  // after a longer pause (flash erase) the missing milliseconds are skipped
inline constexpr std::uint32_t kLedNormal_ms = 500, kLedRefused_ms = 62;

// Milliseconds since start, counted by the SysTick interrupt.
inline volatile std::uint32_t tick_count = 0;
inline void on_systick() { tick_count = tick_count + 1; }

// Sleeps until an interrupt, unless `pending()`. Check and sleep run with interrupts masked; one that arrives in between still wakes the
// processor.
template <class Pending>
void sleep_unless(Pending pending) {
  disable_interrupts();
  if (!pending()) wait_for_interrupt();
  enable_interrupts();
}

template <class Node, class Board>
[[noreturn]] void run(Node& node, Board& board) {
  WatchdogGate gate;
  std::uint32_t loops = 0, ticks = 0, services = 0, led_ms = 0;
  bool led = false;
  std::uint32_t seen = tick_count;
  for (;;) {
    // The stack grows down into variables: its last word must be as it was painted.
    if (hoist_stack_low[0] != kStackPaint) fault_handler();
    ++loops;
    contract::CanFrame frame;
    for (std::uint32_t i = 0; i < kFramesPerRound && board.receive(frame); ++i) node.on_frame(frame);
    const std::uint32_t behind = tick_count - seen;
    if (behind > 0) {
      if (behind > kTicksToCatchUp) seen += behind - kTicksToCatchUp;
      ++seen;
      // A second millisecond has begun before this one was handled: the servo ran late.
      if constexpr (requires { node.note_late_tick(); })
        if (behind > 1) node.note_late_tick();
      if constexpr (requires { board.tick_1ms(); }) board.tick_1ms();
      node.tick_1ms();
      if (++ticks == kStartedWell_ms) board.started_well();
      if (++led_ms == kLedNormal_ms) {
        led_ms = 0;
        led = !led;
        board.set_led(led);
      }
    }
    if constexpr (requires { node.poll(); }) node.poll();
    if (board.service()) ++services;
    if (behind > 0 && gate.should_feed(loops, ticks, services)) board.feed_watchdog();
    sleep_unless([&] {
      if constexpr (requires { board.has_work(); })
        if (board.has_work()) return true;
      return board.has_frame() || tick_count != seen;
    });
  }
}

// A board without a valid strap or with missing hardware: outputs stay off, nothing is sent, the lamp blinks fast.
template <class Board>
[[noreturn]] void refuse_to_start(Board& board) {
  bool led = false;
  std::uint32_t seen = tick_count;
  for (;;) {
    sleep_unless([&] { return tick_count - seen >= kLedRefused_ms; });
    board.feed_watchdog();
    if (tick_count - seen < kLedRefused_ms) continue;
    seen = tick_count;
    led = !led;
    board.set_led(led);
  }
}

}  // namespace hoist::firmware::cortex_m0
