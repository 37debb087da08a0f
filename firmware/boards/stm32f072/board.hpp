// The STM32F072, for cortex_m0/board.hpp and the images.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "firmware/boards/stm32f072/can.hpp"
#include "firmware/boards/stm32f072/clock.hpp"
#include "firmware/boards/stm32f072/flash.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/lib/serial_number.hpp"

namespace hoist::firmware {
namespace stm32f072 {

inline constexpr std::string_view kName = "STM32F072";
inline constexpr std::uint32_t kInternal_hz = 8'000'000;

inline void start_ports() { rcc::AhbClocks::set(rcc::kPorts); }
inline void start_supply_monitor() {}
// Of the unique device id: 96 bits that the factory wrote (RM0091, 33.1).
inline std::uint32_t serial_number() {
  constexpr std::uint32_t kUniqueId = 0x1FFFF7AC;
  const std::array<std::uint32_t, 3> id{cortex_m0::read_word(kUniqueId), cortex_m0::read_word(kUniqueId + 4),
                                        cortex_m0::read_word(kUniqueId + 8)};
  return serial_of(id);
}

template <Pin kPin>
void input_pin() {
  set_pin<kPin>(PinMode::input, PinPull::up);
}
template <Pin kPin>
void output_pin() {
  set_pin<kPin>(PinMode::output);
}
template <Pin kPin>
void analog_pin() {
  set_pin<kPin>(PinMode::analog);
}

}  // namespace stm32f072
namespace chip = stm32f072;
}  // namespace hoist::firmware

#include "firmware/boards/cortex_m0/board.hpp"
