// The one clock of the bench: 48 MHz, the fastest clock on any board, so that every bit and every core clock is a whole number.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace hoist::machine {

using Time = std::uint64_t;  ///< since the bench was made, in 1/48 us
inline constexpr Time kMicrosecond = 48;
inline constexpr Time kMillisecond = 48'000;
inline constexpr Time kSecond = 48'000'000;
inline constexpr Time kNever = UINT64_MAX;

/// Called for each violation.
using Complain = std::function<void(const std::string&)>;

}  // namespace hoist::machine
