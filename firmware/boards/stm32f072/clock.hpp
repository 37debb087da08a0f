// 8 MHz crystal to 48 MHz (RM0091, 6.2), reset causes, watchdog.
#pragma once
#include <cstdint>

#include "firmware/boards/stm32f072/registers.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware::stm32f072 {

inline constexpr std::uint32_t kClock_hz = 48'000'000;
inline constexpr std::uint32_t kStart_loops = 100'000;  // at 8 MHz more than 100 ms; a crystal takes a few

[[nodiscard]] inline bool start_clock() {
  const auto ready = [](std::uint32_t bit) {
    for (std::uint32_t i = 0; i < kStart_loops; ++i)
      if ((rcc::Control::read() & bit) != 0) return true;
    return false;
  };
  FlashAccess::write(1U | (1U << 4));  // one wait state above 24 MHz, prefetch
  rcc::Control::set(1U << 16);
  if (!ready(1U << 17)) return false;
  rcc::Configuration::write((1U << 16) | (4U << 18));  // crystal times 6
  rcc::Control::set(1U << 24);
  if (!ready(1U << 25)) return false;
  rcc::Configuration::set(2);
  for (std::uint32_t i = 0; i < kStart_loops; ++i)
    if ((rcc::Configuration::read() & (3U << 2)) == (2U << 2)) return true;
  return false;
}

// Why the processor started, and forgets it. The pin's bit is set with every other one: the chip pulls its own reset line.
[[nodiscard]] inline ResetCause take_reset_cause() {
  const std::uint32_t status = rcc::Status::read();
  rcc::Status::set(1U << 24);
  if ((status & ((1U << 29) | (1U << 30))) != 0) return ResetCause::watchdog;
  if ((status & (1U << 28)) != 0) return ResetCause::software;
  return (status & (1U << 27)) != 0 ? ResetCause::power : ResetCause::pin;
}

// The independent watchdog, on its own oscillator of 30 to 50 kHz (data sheet): 50 ms are 40 to 67 ms. It cannot be switched off again.
namespace watchdog {
using Key = Register<0x40003000>;
using Prescale = Register<0x40003004>;
using Reload = Register<0x40003008>;
using Status = Register<0x4000300C>;
inline constexpr std::uint32_t kTicks_per_ms = 10;  // 40 kHz by 4
inline constexpr std::uint32_t kTimeout_ms = 50;
inline constexpr std::uint32_t kFlashTimeout_ms = 400;   // an erase takes 40 ms, in which the processor waits
inline constexpr std::uint32_t kUpdate_loops = 100'000;  // a change takes five of the slow clocks

inline void feed() { Key::write(0xAAAA); }
inline void set_timeout(std::uint32_t timeout_ms) {
  feed();
  for (std::uint32_t i = 0; i < kUpdate_loops && (Status::read() & 3U) != 0; ++i) {
  }
  Key::write(0x5555);
  Prescale::write(0);
  Reload::write(timeout_ms * kTicks_per_ms);
  for (std::uint32_t i = 0; i < kUpdate_loops && (Status::read() & 3U) != 0; ++i) {
  }
  feed();
}
inline void start() {
  Key::write(0xCCCC);
  set_timeout(kTimeout_ms);
}
}  // namespace watchdog

}  // namespace hoist::firmware::stm32f072
