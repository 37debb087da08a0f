// CRC-32 as in ISO 3309 and zip: reflected polynomial EDB88320h, start and final inversion. Half a byte at a time: 64 bytes of table, so
// that it fits into the loader of a microcontroller, which checks 20 KB in about 10 ms with it.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace hoist::contract {

inline constexpr std::array<std::uint32_t, 16> kCrc32Table = [] {
  std::array<std::uint32_t, 16> table{};
  for (std::uint32_t i = 0; i < 16; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 4; ++bit) value = (value >> 1) ^ ((value & 1U) != 0 ? 0xEDB88320U : 0U);
    table[i] = value;
  }
  return table;
}();

class Crc32 {
 public:
  constexpr void add(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      state_ = (state_ >> 4) ^ kCrc32Table[(state_ ^ byte) & 15U];
      state_ = (state_ >> 4) ^ kCrc32Table[(state_ ^ (static_cast<std::uint32_t>(byte) >> 4)) & 15U];
    }
  }
  [[nodiscard]] constexpr std::uint32_t value() const { return ~state_; }

 private:
  std::uint32_t state_ = 0xFFFFFFFFU;
};

}  // namespace hoist::contract
