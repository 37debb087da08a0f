// The synchronisation output: pulses by which a motion capture or EMG system, that records the same line, finds the hoist's steps again.
//
// One pulse a second, on the even second of the steps. Its length is a digit: 0.8 s begins a group of 16 pulses, the other 15 spell the number
// of the group, lowest digit first, 0.5 s for 1 and 0.2 s for 0. So any 32 s of the line say which steps they were: group * 1600 is the step
// of the long pulse. Digits repeat after six days. Levels change with the frames to the input node (relay_feed.hpp), each fifth step: a pulse
// begins up to 40 ms late, always as late as its neighbours, and the live value sync_output says in which step.
#pragma once
#include <cstdint>

namespace hoist::core {

inline constexpr std::uint64_t kSyncPulseTicks = 100, kSyncGroupPulses = 16;
inline constexpr std::uint64_t kSyncLongTicks = 80, kSyncOneTicks = 50, kSyncZeroTicks = 20;

/// Whether the output is on in this step.
[[nodiscard]] constexpr bool sync_pulse(std::uint64_t tick) noexcept {
  const std::uint64_t pulse = tick / kSyncPulseTicks, place = pulse % kSyncGroupPulses, group = pulse / kSyncGroupPulses;
  const bool one = place > 0 && ((group >> (place - 1)) & 1U) != 0;
  const std::uint64_t length = place == 0 ? kSyncLongTicks : one ? kSyncOneTicks : kSyncZeroTicks;
  return tick % kSyncPulseTicks < length;
}

}  // namespace hoist::core
