// What the boards around the chips connect to which pin, for both microcontrollers in the same words: from firmware/boards/*/pins.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "control/contract/firmware_image.hpp"
#include "tests/machine/chip.hpp"

namespace hoist::machine {

struct BoardPins {
  PinPlace strap0, strap1;                                 ///< to ground: left, right
  PinPlace service;                                        ///< to ground at reset: stays in the loader
  std::span<const PinPlace> pulled_up, pulled_up_on_tilt;  ///< lines with a resistor to the supply on every board, on the tilt sensor's
  PinPlace bridge_enable, bridge_phase, bridge_awake, bridge_fault;
  std::span<const PinPlace> encoder_a, encoder_b;  ///< every pin that the line goes to
  unsigned motor_current_channel{}, bus_voltage_channel{};
  double current_zero_v{}, current_gain_v_a{}, bus_divider{};
  PinPlace spi_select;
  std::array<PinPlace, 4> bumpers;  ///< front, rear, left, right
  PinPlace emergency_stop;
  std::array<PinPlace, 8> outputs;
  unsigned battery_a_channel{}, battery_both_channel{};
  double battery_a_divider{}, battery_both_divider{};
  PinPlace uart_cts;
  std::uint32_t uart_baud{};
  std::uint32_t flash_base{}, ram_top{};  ///< the first address of the flash, the end of the RAM
  std::uint32_t application_start{};
};

[[nodiscard]] const BoardPins& board_pins(contract::ImageChip chip);

}  // namespace hoist::machine
