// Whether a stream of frames that should come in even steps has holes or comes too often. Exact for frames that answer each SYNC, where a
// step is a SYNC; frames with a timer of their own are followed as their clock drifts against ours.
//
// A frame that is merely late is no lost one: what is missing counts only when it is still missing at the end of a window in which it could
// have come. A serial line that holds frames up for less than a window loses nothing here.
#pragma once
#include <cstdint>

namespace hoist::core {

/// Clocks and periods of a stream count in this part of a step, so that a drifting timer can be followed.
inline constexpr std::int32_t kStreamUnit = 256;

class StreamWatch {
 public:
  /// One frame came at `now` (in 1/kStreamUnit steps, may wrap). True when it is one more than the stream can have by now.
  [[nodiscard]] bool take(std::uint32_t now, std::int32_t period) noexcept {
    const auto late = static_cast<std::int32_t>(now - due_);
    if (!known_ || late > kForgetPeriods * period || late < -2 * period) {
      // The first one, or the first after so long a silence that nobody knows what should have come, or that the clock has wrapped.
      *this = StreamWatch{};
      known_ = true;
      due_ = now + static_cast<std::uint32_t>(period);
      return false;
    }
    // -1: before its time, a frame that was held up or one too many. Never less, because `due_` is at most 1.75 periods ahead. Three quarters
    // of a period, not one half: a 20 ms timer seen in steps of 10 ms is off by one half now and then; what is really missing stays missing
    // and shows with the next frame.
    const std::int32_t missed = late >= -period * 3 / 4 ? (late + period / 4) / period : -1;
    due_ += static_cast<std::uint32_t>((missed + 1) * period);
    if (missed == 0) due_ += static_cast<std::uint32_t>(late / kFollow);
    owed_ += missed;
    if (owed_ < least_) least_ = owed_;
    if (owed_ > most_) most_ = owed_;
    return missed < 0 && owed_ < 0;
  }

  /// At the end of a window: how many frames were missing during the whole of it. They are settled then, and so is a surplus.
  [[nodiscard]] std::uint32_t settle() noexcept {
    const std::uint32_t lost = least_ > 0 ? static_cast<std::uint32_t>(least_) : 0;
    owed_ -= least_ > 0 ? least_ : (most_ < 0 ? most_ : 0);
    least_ = most_ = owed_;
    return lost;
  }

  /// The sender or the way to it began anew; nothing is expected until its next frame.
  void forget() noexcept { *this = StreamWatch{}; }
  [[nodiscard]] bool known() const noexcept { return known_; }

 private:
  static constexpr std::int32_t kForgetPeriods = 100;  // a second of silence of a 10 ms stream: its sender is lost, which is another alarm
  static constexpr std::int32_t kFollow = 8;           // share of the observed offset by which the expectation follows

  std::uint32_t due_ = 0;
  std::int32_t owed_ = 0, least_ = 0, most_ = 0;  // frames that should have come and have not
  bool known_ = false;
};

}  // namespace hoist::core
