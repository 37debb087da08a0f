// The LPC11C24, for cortex_m0/board.hpp and the images.
#pragma once
#include <cstdint>
#include <string_view>

#include "firmware/boards/lpc11c24/can.hpp"
#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/flash.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"

namespace hoist::firmware {
namespace lpc11c24 {

inline constexpr std::string_view kName = "LPC11C24";
inline constexpr std::uint32_t kInternal_hz = 12'000'000;

inline void start_ports() { syscon::AhbClocks::set(syscon::kGpio | syscon::kIocon); }
inline void start_supply_monitor() { start_brown_out(); }
inline std::uint32_t serial_number() { return iap::serial_number(); }

template <Pin kPin>
void input_pin() {
  set_pin<kPin>(0, kPinPullUp | kPinHysteresis);
}
// PIO1_2 has its GPIO as function 1.
template <Pin kPin>
void output_pin() {
  set_pin<kPin>(kPin.port == 1 && kPin.bit == 2 ? 1 : 0, kPinFloating);
  make_output<kPin>();
}
template <Pin kPin>
void analog_pin() {
  set_pin<kPin>(2, kPinAnalog);
}

}  // namespace lpc11c24
namespace chip = lpc11c24;
}  // namespace hoist::firmware

#include "firmware/boards/cortex_m0/board.hpp"
