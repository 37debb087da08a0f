// How busy the wire is: the bits of every frame that passed, in and out, over one second.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "control/contract/can_frame.hpp"

namespace hoist::core {

/// Bit rate of the bus (the wiring plan; the gateway and the interface are set to it).
inline constexpr double kBusBits_s = 250'000;

/// Bits of a data frame with 11-bit id and its intermission, with as many stuff bits as it can have: 47 + 8 s + (34 + 8 s - 1) / 4. Counting
/// the real stuff bits would need the checksum of every frame; so the load shown is at most 18 % of itself too high, and never too low.
[[nodiscard]] constexpr std::uint32_t frame_bits_most(std::uint32_t bytes) noexcept {
  const std::uint32_t data_bits = 8 * (bytes <= 8 ? bytes : 8);
  return 47 + data_bits + (33 + data_bits) / 4;
}

class BusLoad {
 public:
  void take(const contract::CanFrame& frame) noexcept {
    ++frames_;
    bits_ += kBits[frame.dlc <= 8 ? frame.dlc : 8];
    // The longer id costs 20 bits and five more stuff bits.
    if ((frame.flags & contract::CanFrame::kExtended) != 0) bits_ += 25;
  }

  /// Once a second; `span_s` is how long it really was.
  void close(double span_s) noexcept {
    load_norm_ = bits_ / (kBusBits_s * span_s);
    frames_per_s_ = static_cast<std::uint32_t>(std::lround(frames_ / span_s));
    bits_ = 0;
    frames_ = 0;
  }

  /// Of the last whole second.
  [[nodiscard]] double load_norm() const noexcept { return load_norm_; }
  [[nodiscard]] std::uint32_t frames_per_s() const noexcept { return frames_per_s_; }

 private:
  static constexpr auto kBits = [] {
    std::array<std::uint32_t, 9> table{};
    for (std::uint32_t bytes = 0; bytes < table.size(); ++bytes) table[bytes] = frame_bits_most(bytes);
    return table;
  }();

  double load_norm_ = 0;
  std::uint32_t bits_ = 0, frames_ = 0, frames_per_s_ = 0;
};

static_assert(frame_bits_most(0) == 55 && frame_bits_most(6) == 115 && frame_bits_most(8) == 135);

}  // namespace hoist::core
