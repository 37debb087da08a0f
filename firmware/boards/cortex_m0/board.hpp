// Common to the boards of every chip: CAN, stored parameters, cause of the reset, lamp, straps, watchdog. The boards of the four node kinds add
// the hardware of their kind (*_image.hpp). A chip's board.hpp includes this at its end: its namespace is hoist::firmware::chip.
//
// Interrupt handlers need the board, so there is one per image, a global that is initialised at compile time.
#pragma once
#include <cstdint>
#include <string_view>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/can_filter.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/mailbox.hpp"
#include "firmware/lib/program_control.hpp"

namespace hoist::firmware::cortex_m0 {
using namespace chip;

inline Mailbox& mailbox() { return *reinterpret_cast<Mailbox*>(kMailboxStart); }

[[gnu::always_inline]] inline void wait_for_pull_ups() {
  for (std::uint32_t i = 0; i < 100; ++i) asm volatile("nop");  // 50 kOhm and a few pF
}

struct Straps {
  bool strap0 = false, strap1 = false;  // true = wired to ground
};
inline Straps read_straps() {
  input_pin<kStrap0>();
  input_pin<kStrap1>();
  wait_for_pull_ups();
  return {!read_pin<kStrap0>(), !read_pin<kStrap1>()};
}

class Board {
 public:
  static constexpr std::string_view kHardwareName = chip::kName;  // 1009h

  // Clock, tick, lamp, supply monitor. False without an exact clock: the node cannot be on the bus then.
  [[nodiscard]] bool start_core() {
    start_ports();
    reset_cause_ = take_reset_cause();
    const bool exact = start_clock();
    start_supply_monitor();
    set_led(false);
    output_pin<kLed>();
    cortex_m0::start_systick(exact ? kClock_hz / 1000 : kInternal_hz / 1000, kPriorityTick);
    watchdog::start();
    return exact;
  }
  [[nodiscard]] bool start_can(CanFilter filter) { return can_.start(filter); }

  // For the node.
  bool send(const contract::CanFrame& frame) { return can_.send(frame); }
  [[nodiscard]] bool all_sent() const { return can_.all_sent(); }
  [[nodiscard]] bool simulated() const { return false; }
  [[nodiscard]] std::uint32_t serial_number() const { return chip::serial_number(); }
  [[nodiscard]] CanHealth can_health() const { return can_.health(); }
  void drop_unsent() { can_.drop_unsent(); }
  void can_restart() { can_.restart(); }
  ParameterFlash& flash() { return flash_; }
  [[nodiscard]] ResetCause reset_cause() const { return reset_cause_; }
  void restart(bool into_loader) {
    hoist_outputs_off();
    forget_request(mailbox());
    if (into_loader) request_loader(mailbox());
    cortex_m0::reset_now();
  }
  [[nodiscard]] ProgramInfo program() const {
    return {cortex_m0::read_word(kApplicationStart + contract::kImageHeaderAt + 12),
            cortex_m0::read_word(kApplicationStart + contract::kImageCrcAt)};
  }

  // For the main loop.
  bool receive(contract::CanFrame& frame) { return can_.receive(frame); }
  [[nodiscard]] bool has_frame() const { return can_.has_frame(); }
  [[nodiscard]] bool service() { return can_.service(); }
  void feed_watchdog() { watchdog::feed(); }
  void set_led(bool on) { write_pin<kLed>(!on); }
  void started_well() { forget_failures(mailbox()); }

  void on_can_interrupt() { can_.on_interrupt(); }

 private:
  Can can_{};
  ParameterFlash flash_{};
  ResetCause reset_cause_ = ResetCause::power;
};

}  // namespace hoist::firmware::cortex_m0
