// What every STM32F072 board has; as lpc11c24/board.hpp, which explains it.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/boards/stm32f072/can.hpp"
#include "firmware/boards/stm32f072/clock.hpp"
#include "firmware/boards/stm32f072/flash.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/boot/mailbox.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/lib/program_control.hpp"
#include "firmware/lib/serial_number.hpp"

namespace hoist::firmware::stm32f072 {

inline Mailbox& mailbox() { return *reinterpret_cast<Mailbox*>(kMailboxStart); }

struct Straps {
  bool strap0 = false, strap1 = false;  // true = wired to ground
};
inline Straps read_straps() {
  set_pin<kStrap0>(PinMode::input, PinPull::up);
  set_pin<kStrap1>(PinMode::input, PinPull::up);
  for (std::uint32_t i = 0; i < 100; ++i) asm volatile("nop");
  return {!read_pin<kStrap0>(), !read_pin<kStrap1>()};
}

// The unique device id: 96 bits that the factory wrote (RM0091, 33.1).
inline std::uint32_t chip_serial_number() {
  constexpr std::uint32_t kUniqueId = 0x1FFFF7AC;
  const std::array<std::uint32_t, 3> id{cortex_m0::read_word(kUniqueId), cortex_m0::read_word(kUniqueId + 4),
                                        cortex_m0::read_word(kUniqueId + 8)};
  return serial_of(id);
}

class Board {
 public:
  static constexpr std::string_view kHardwareName = "STM32F072";  // 1009h

  [[nodiscard]] bool start_core() {
    rcc::AhbClocks::set(rcc::kPorts);
    reset_cause_ = take_reset_cause();
    const bool exact = start_clock();
    set_led(false);
    set_pin<kLed>(PinMode::output);
    cortex_m0::start_systick(exact ? kClock_hz / 1000 : kInternal_hz / 1000, kPriorityTick);
    watchdog::start();
    return exact;
  }
  [[nodiscard]] bool start_can(CanFilter filter) { return can_.start(filter); }

  // For the node.
  bool send(const contract::CanFrame& frame) { return can_.send(frame); }
  [[nodiscard]] bool all_sent() const { return can_.all_sent(); }
  [[nodiscard]] bool simulated() const { return false; }
  [[nodiscard]] std::uint32_t serial_number() const { return chip_serial_number(); }
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
  static constexpr std::uint32_t kInternal_hz = 8'000'000;
  Can can_{};
  ParameterFlash flash_{};
  ResetCause reset_cause_ = ResetCause::power;
};

}  // namespace hoist::firmware::stm32f072
