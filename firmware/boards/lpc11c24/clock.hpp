// 12 MHz crystal to 48 MHz (UM10398, 3.5 and 3.11), flash at three clocks an access, brown-out reset, watchdog.
#pragma once
#include <cstdint>

#include "firmware/boards/lpc11c24/registers.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware::lpc11c24 {

inline constexpr std::uint32_t kClock_hz = 48'000'000;
inline constexpr std::uint32_t kCrystalStart_loops = 2000;  // of at least 3 cycles at 12 MHz: half a millisecond for the crystal
inline constexpr std::uint32_t kPllLock_loops = 100'000;    // data sheet: 100 us; this is more than 20 ms

// False when the PLL does not lock. The processor then still runs from its own 12 MHz, too inexact for the bus.
[[nodiscard]] inline bool start_clock() {
  syscon::OscillatorControl::write(0);  // crystal, 1 to 20 MHz
  syscon::PowerDown::clear(syscon::kOscillatorOff);
  for (std::uint32_t i = 0; i < kCrystalStart_loops; ++i) asm volatile("nop");
  syscon::PllSource::write(1);
  syscon::PllSourceUpdate::write(0);
  syscon::PllSourceUpdate::write(1);
  // 12 MHz times 4; the inner oscillator runs at 48 x 2 x 2 = 192 MHz, inside its 156 to 320 MHz.
  syscon::PowerDown::set(syscon::kPllOff);
  syscon::PllControl::write(3U | (1U << 5));
  syscon::PowerDown::clear(syscon::kPllOff);
  std::uint32_t waited = 0;
  while ((syscon::PllStatus::read() & 1U) == 0)
    if (++waited == kPllLock_loops) return false;
  FlashTiming::write((FlashTiming::read() & ~3U) | 2U);
  syscon::AhbDivider::write(1);
  syscon::MainClock::write(3);
  syscon::MainClockUpdate::write(0);
  syscon::MainClockUpdate::write(1);
  return true;
}

// Reset when the supply falls below 2.7 V: above what the flash needs, so that a sinking supply cannot run the processor wild.
inline void start_brown_out() {
  syscon::PowerDown::clear(syscon::kBrownOutOff);
  syscon::BrownOut::write(3U | (1U << 4));
}

// Why the processor started, and forgets it. Several can be set: after power-on the pin usually is, too. A brown-out counts as power.
[[nodiscard]] inline ResetCause take_reset_cause() {
  const std::uint32_t status = syscon::ResetStatus::read();
  syscon::ResetStatus::write(status);
  if ((status & syscon::kResetWatchdog) != 0) return ResetCause::watchdog;
  if ((status & syscon::kResetSoftware) != 0) return ResetCause::software;
  if ((status & (syscon::kResetPower | syscon::kResetBrownOut)) != 0) return ResetCause::power;
  return ResetCause::pin;
}

// The watchdog, on its own oscillator: a dead crystal does not stop it. That oscillator is good to 40 % (data sheet), so 50 ms are 36 to
// 83 ms. It cannot be switched off again.
namespace watchdog {
using Mode = Register<0x40004000>;
using Reload = Register<0x40004004>;
using Feed = Register<0x40004008>;
inline constexpr std::uint32_t kTicks_per_ms = 75;  // 0.6 MHz, by 2 in the oscillator, by 4 in the watchdog
inline constexpr std::uint32_t kTimeout_ms = 50;
inline constexpr std::uint32_t kFlashTimeout_ms = 400;  // while the factory's routines hold the processor; an erase takes 100 ms

inline void feed() {
  const cortex_m0::InterruptsOff off;  // any other access to the watchdog between the two words is a fault
  Feed::write(0xAA);
  Feed::write(0x55);
}
inline void start() {
  syscon::AhbClocks::set(syscon::kWatchdog);
  syscon::WatchdogOscillator::write(1U << 5);
  syscon::PowerDown::clear(syscon::kWatchdogOscillatorOff);
  syscon::WatchdogClock::write(2);
  syscon::WatchdogClockUpdate::write(0);
  syscon::WatchdogClockUpdate::write(1);
  syscon::WatchdogDivider::write(1);
  Reload::write(kTimeout_ms * kTicks_per_ms);
  Mode::write(3);  // enabled, resets the chip
  feed();
}
inline void set_timeout(std::uint32_t timeout_ms) {
  Reload::write(timeout_ms * kTicks_per_ms);
  feed();
}
}  // namespace watchdog

}  // namespace hoist::firmware::lpc11c24
