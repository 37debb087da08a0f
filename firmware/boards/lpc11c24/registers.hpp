// The registers of the LPC11C24 that this firmware uses, by their names in UM10398. No other register is used.
#pragma once
#include <cstdint>

#include "firmware/boards/cortex_m0/registers.hpp"
#include "firmware/boards/lpc11c24/pins.hpp"

namespace hoist::firmware::lpc11c24 {

using cortex_m0::Register;

// ---- system control, chapter 3
namespace syscon {
using Remap = Register<0x40048000>;            // 1: vectors from RAM
using PeripheralReset = Register<0x40048004>;  // 1 = runs: bit 0 SSP0, 1 I2C, 2 SSP1, 3 C_CAN
using PllControl = Register<0x40048008>;
using PllStatus = Register<0x4004800C>;
using OscillatorControl = Register<0x40048020>;
using WatchdogOscillator = Register<0x40048024>;
using ResetStatus = Register<0x40048030>;  // 0 power, 1 pin, 2 watchdog, 3 brown-out, 4 software; cleared by writing ones
using PllSource = Register<0x40048040>;
using PllSourceUpdate = Register<0x40048044>;
using MainClock = Register<0x40048070>;
using MainClockUpdate = Register<0x40048074>;
using AhbDivider = Register<0x40048078>;
using AhbClocks = Register<0x40048080>;
using Ssp0Divider = Register<0x40048094>;
using UartDivider = Register<0x40048098>;
using WatchdogClock = Register<0x400480D0>;
using WatchdogClockUpdate = Register<0x400480D4>;
using WatchdogDivider = Register<0x400480D8>;
using BrownOut = Register<0x40048150>;
using PowerDown = Register<0x40048238>;

// Bits of AhbClocks.
inline constexpr std::uint32_t kI2c = 1U << 5, kGpio = 1U << 6, kTimer16_0 = 1U << 7, kTimer32_0 = 1U << 9, kSsp0 = 1U << 11,
                               kUart = 1U << 12, kAdc = 1U << 13, kWatchdog = 1U << 15, kIocon = 1U << 16, kCan = 1U << 17;
// Bits of PeripheralReset.
inline constexpr std::uint32_t kSsp0Runs = 1U << 0, kI2cRuns = 1U << 1, kCanRuns = 1U << 3;
// Bits of PowerDown, 1 = off.
inline constexpr std::uint32_t kBrownOutOff = 1U << 3, kAdcOff = 1U << 4, kOscillatorOff = 1U << 5, kWatchdogOscillatorOff = 1U << 6,
                               kPllOff = 1U << 7;
// Bits of ResetStatus.
inline constexpr std::uint32_t kResetPower = 1U << 0, kResetPin = 1U << 1, kResetWatchdog = 1U << 2, kResetBrownOut = 1U << 3,
                               kResetSoftware = 1U << 4;
}  // namespace syscon

using FlashTiming = Register<0x4003C010>;

// ---- pins, chapters 7 and 12

// Register of a pin in the IOCON block; its address follows no rule. 0: the pin is not on this chip or not used by any board.
consteval std::uint32_t iocon_address(Pin pin) {
  struct Row {
    Pin pin;
    std::uint8_t offset;
  };
  constexpr Row kRows[] = {{{2, 6}, 0x00},  {{2, 0}, 0x08}, {{0, 2}, 0x1C},  {{2, 7}, 0x20},  {{2, 8}, 0x24},  {{2, 1}, 0x28},
                           {{0, 4}, 0x30},  {{0, 5}, 0x34}, {{0, 6}, 0x4C},  {{0, 7}, 0x50},  {{2, 10}, 0x58}, {{2, 2}, 0x5C},
                           {{0, 8}, 0x60},  {{0, 9}, 0x64}, {{1, 10}, 0x6C}, {{2, 11}, 0x70}, {{0, 11}, 0x74}, {{1, 0}, 0x78},
                           {{1, 1}, 0x7C},  {{1, 2}, 0x80}, {{3, 0}, 0x84},  {{3, 1}, 0x88},  {{2, 3}, 0x8C},  {{1, 4}, 0x94},
                           {{1, 11}, 0x98}, {{1, 5}, 0xA0}, {{1, 6}, 0xA4},  {{1, 7}, 0xA8},  {{1, 8}, 0x14},  {{0, 3}, 0x2C}};
  for (const Row& row : kRows)
    if (row.pin.port == pin.port && row.pin.bit == pin.bit) return 0x40044000U + row.offset;
  return 0;
}
// How a pin is set up. Bit 7 is the converter pins' ADMODE (1 = digital) and reads as one in all others: reset value 0xD0.
inline constexpr std::uint32_t kPinFloating = 0xC0, kPinPullUp = 0xD0, kPinHysteresis = 0x20, kPinAnalog = 0x40, kPinOpenDrainI2c = 0x00;

template <Pin kPin>
inline void set_pin(std::uint32_t function, std::uint32_t mode) {
  static_assert(iocon_address(kPin) != 0);
  Register<iocon_address(kPin)>::write(mode | function);
}
using SckLocation = Register<0x400440B0>;

inline constexpr std::uint32_t gpio_base(std::uint32_t port) { return 0x50000000U + (port << 16); }
// The data register under an address that carries a mask: only the pins of the mask are read or change.
template <Pin kPin>
inline bool read_pin() {
  return Register<gpio_base(kPin.port) + (4U << kPin.bit)>::read() != 0;
}
template <Pin kPin>
inline void write_pin(bool high) {
  Register<gpio_base(kPin.port) + (4U << kPin.bit)>::write(high ? 1U << kPin.bit : 0U);
}
template <Pin kPin>
inline void make_output() {
  Register<gpio_base(kPin.port) + 0x8000>::set(1U << kPin.bit);
}
template <std::uint32_t kPort>
struct Gpio {
  using Sense = Register<gpio_base(kPort) + 0x8004>;      // 0 = edge
  using BothEdges = Register<gpio_base(kPort) + 0x8008>;  // 1 = both
  using Enable = Register<gpio_base(kPort) + 0x8010>;
  using Clear = Register<gpio_base(kPort) + 0x801C>;
};

// ---- interrupts, table 55
namespace irq {
inline constexpr std::uint32_t kCan = 13, kUart = 21, kGpio2 = 29;
}
// Encoder edges first: they are the shortest and the most frequent. Then what must not be lost, then the tick.
inline constexpr std::uint32_t kPriorityEncoder = 0, kPriorityUart = 1, kPriorityCan = 2, kPriorityTick = 3;

}  // namespace hoist::firmware::lpc11c24
