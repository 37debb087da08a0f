// A set of parameter values on its way to the core: how long it may be on trial, and how it is sealed: CRC-32 over its rows, in their order.
// The sender of a set computes it over the values it meant, the core over the values that arrived (hazard H27).
#pragma once
#include <array>
#include <bit>
#include <cstdint>

#include "control/contract/crc32.hpp"

namespace hoist::contract {

/// Range of a trial's time before the old values return: long enough to press "keep", short enough that the therapist
/// still watches the effect (hazard H27).
inline constexpr double kTrial_s_min = 1.0, kTrial_s_max = 120.0;

class ParamSetSeal {
 public:
  constexpr void add(std::uint32_t id, double value) {
    std::array<std::uint8_t, 12> bytes{};
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (unsigned i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(id >> (8 * i));
    for (unsigned i = 0; i < 8; ++i) bytes[4 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
    crc_.add(bytes);
  }
  /// For Command::seal: the CRC in the lower half, the parameter version the set was made for in the upper one (0 = whichever is in force).
  [[nodiscard]] constexpr std::uint64_t value(std::uint32_t version = 0) const {
    return static_cast<std::uint64_t>(version) << 32U | crc_.value();
  }

 private:
  Crc32 crc_;
};

}  // namespace hoist::contract
