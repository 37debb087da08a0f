// One CAN frame, the same in nodes, core, bus back ends and captures.
#pragma once
#include <array>
#include <cstdint>

namespace hoist::contract {

struct CanFrame {
  static constexpr std::uint8_t kExtended = 1;  // 29-bit id
  static constexpr std::uint8_t kRemote = 2;    // remote request: dlc without data
  static constexpr std::uint8_t kError = 4;     // reported by the bus back end, never on the wire
  std::uint32_t id = 0;
  std::uint8_t dlc = 0;  // 0 to 8
  std::uint8_t flags = 0;
  std::array<std::uint8_t, 8> data{};
  friend constexpr bool operator==(const CanFrame&, const CanFrame&) = default;
};
static_assert(sizeof(CanFrame) == 16);

}  // namespace hoist::contract
