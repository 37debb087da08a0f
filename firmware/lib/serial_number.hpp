// Serial number 1018h:4 out of a chip's unique id, which is longer than 32 bits: its CRC-32, never 0, which would mean "unknown".
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/crc32.hpp"

namespace hoist::firmware {

constexpr std::uint32_t serial_of(std::span<const std::uint32_t> unique_id) {
  contract::Crc32 crc;
  for (const std::uint32_t word : unique_id) {
    std::array<std::uint8_t, 4> bytes{};
    contract::write_le(bytes.data(), bytes.size(), word);
    crc.add(bytes);
  }
  return crc.value() == 0 ? 1 : crc.value();
}

}  // namespace hoist::firmware
