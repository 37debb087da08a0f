// The registers of the STM32F072 that this firmware uses, by their places in RM0091. No other register is used.
#pragma once
#include <cstdint>

#include "firmware/boards/cortex_m0/registers.hpp"
#include "firmware/boards/stm32f072/pins.hpp"

namespace hoist::firmware::stm32f072 {

using cortex_m0::Register;

// ---- reset and clock control, section 6.4
namespace rcc {
using Control = Register<0x40021000>;
using Configuration = Register<0x40021004>;
using AhbClocks = Register<0x40021014>;
using Apb2Clocks = Register<0x40021018>;
using Apb1Clocks = Register<0x4002101C>;
using Status = Register<0x40021024>;
using Configuration3 = Register<0x40021030>;
inline constexpr std::uint32_t kPorts = (1U << 17) | (1U << 18) | (1U << 19);  // A, B, C
inline constexpr std::uint32_t kSyscfg = 1U << 0, kAdc = 1U << 9, kTimer1 = 1U << 11, kSpi1 = 1U << 12, kUsart1 = 1U << 14;
inline constexpr std::uint32_t kTimer2 = 1U << 0, kTimer3 = 1U << 1, kI2c1 = 1U << 21, kCan = 1U << 25;
}  // namespace rcc
using FlashAccess = Register<0x40022000>;
using MemoryMap = Register<0x40010000>;  // SYSCFG_CFGR1: 3 in the lowest bits shows RAM at address 0

// ---- ports, section 8.4
inline constexpr std::uint32_t gpio_base(char port) { return 0x48000000U + (static_cast<std::uint32_t>(port - 'A') << 10); }
enum class PinMode : std::uint8_t { input = 0, output = 1, alternate = 2, analog = 3 };
enum class PinPull : std::uint8_t { none = 0, up = 1, down = 2 };
enum class PinSpeed : std::uint8_t { to_2_mhz = 0, to_10_mhz = 1, to_50_mhz = 3 };  // data sheet, I/O AC characteristics; reset: the lowest

template <Pin kPin>
inline void set_pin(PinMode mode, PinPull pull = PinPull::none, std::uint32_t alternate = 0, bool open_drain = false) {
  constexpr std::uint32_t kBase = gpio_base(kPin.port), kShift = 2U * kPin.bit;
  const auto field = [](std::uint32_t address, std::uint32_t mask, std::uint32_t shift, std::uint32_t value) {
    cortex_m0::write_word(address, (cortex_m0::read_word(address) & ~(mask << shift)) | (value << shift));
  };
  field(kBase + 0x04, 1, kPin.bit, open_drain ? 1 : 0);
  field(kBase + 0x0C, 3, kShift, static_cast<std::uint32_t>(pull));
  field(kBase + (kPin.bit < 8 ? 0x20U : 0x24U), 15, 4U * (kPin.bit & 7U), alternate);
  field(kBase, 3, kShift, static_cast<std::uint32_t>(mode));
}
template <Pin kPin>
inline void set_pin_speed(PinSpeed speed) {
  constexpr std::uint32_t kShift = 2U * kPin.bit;
  using Speeds = Register<gpio_base(kPin.port) + 0x08>;
  Speeds::write((Speeds::read() & ~(3U << kShift)) | (static_cast<std::uint32_t>(speed) << kShift));
}
template <Pin kPin>
inline bool read_pin() {
  return (Register<gpio_base(kPin.port) + 0x10>::read() & (1U << kPin.bit)) != 0;
}
template <Pin kPin>
inline void write_pin(bool high) {
  Register<gpio_base(kPin.port) + 0x18>::write(1U << (kPin.bit + (high ? 0U : 16U)));
}

// ---- interrupts, table 37
namespace irq {
inline constexpr std::uint32_t kUsart1 = 27, kCan = 30;
}
inline constexpr std::uint32_t kPriorityUart = 1, kPriorityCan = 2, kPriorityTick = 3;

}  // namespace hoist::firmware::stm32f072
