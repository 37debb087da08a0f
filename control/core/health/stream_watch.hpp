// Whether a stream of frames that should come in even steps has holes or comes too often. Exact for frames that answer each SYNC, where a
// step is a SYNC; frames with a timer of their own are followed as their clock drifts against ours.
//
// A late frame is not a lost one: it counts as missing only when it is still missing at the end of a window in which it
// could have come. A serial line that delays frames by less than a window loses nothing here.
#pragma once
#include <cstdint>

namespace hoist::core {

/// Clocks and periods of a stream count in this part of a step, so that a drifting timer can be followed.
inline constexpr std::int32_t kStreamUnit = 256;

class StreamWatch {
 public:
  enum class Came : std::uint8_t {
    in_time,
    late,     // or the first after a silence
    early,    // or one that made up for a late one
    too_many  // one more than the stream can have by now
  };

  /// One frame came at `now` (in 1/kStreamUnit steps, may wrap).
  [[nodiscard]] Came take(std::uint32_t now, std::int32_t period) noexcept {
    const auto late = static_cast<std::int32_t>(now - due_);
    const std::int32_t nearly = period - period / 4;
    // On time means within three quarters of a period, not one half: a 20 ms timer seen in steps of 10 ms is off by one
    // half now and then; what is really missing stays missing and shows with the next frame.
    if (known_ && late >= -nearly && late < nearly) {
      due_ += static_cast<std::uint32_t>(period + late / kFollow);
      return Came::in_time;
    }
    if (!known_ || late > kForgetPeriods * period || late < -2 * period) {
      // The first one, or the first after a silence so long that the number of missing frames is unknown or the clock has wrapped.
      *this = StreamWatch{};
      known_ = true;
      due_ = now + static_cast<std::uint32_t>(period);
      return Came::late;
    }
    // -1: before its time, a delayed frame or one too many. Never less, because `due_` is at most 1.75 periods ahead.
    const std::int32_t missed = late > 0 ? (late + period / 4) / period : -1;
    due_ += static_cast<std::uint32_t>((missed + 1) * period);
    owed_ += missed;
    if (owed_ < least_) least_ = owed_;
    if (owed_ > most_) most_ = owed_;
    if (missed > 0) return Came::late;
    if (owed_ < 0) return Came::too_many;
    wavers_ = true;
    wavered_at_ = now;
    return Came::early;
  }

  /// At the end of a window: how many frames were missing during all of it. They are cleared then, and so is a surplus.
  [[nodiscard]] std::uint32_t settle() noexcept {
    const std::uint32_t lost = least_ > 0 ? static_cast<std::uint32_t>(least_) : 0;
    owed_ -= least_ > 0 ? least_ : (most_ < 0 ? most_ : 0);
    least_ = most_ = owed_;
    return lost;
  }

  /// Frames have come late and made up for it within the last seconds. A timer of about one step, seen in steps, does so while its clock
  /// drifts across ours, and then misses a step without a frame being lost.
  [[nodiscard]] bool wavers(std::uint32_t now) const noexcept { return wavers_ && now - wavered_at_ < kWaverPeriod; }

  /// The sender or its link restarted; nothing is expected until its next frame.
  void forget() noexcept { *this = StreamWatch{}; }
  [[nodiscard]] bool known() const noexcept { return known_; }

 private:
  static constexpr std::int32_t kForgetPeriods = 100;  // a second of silence of a 10 ms stream: its sender is lost, which is another alarm
  static constexpr std::int32_t kFollow = 8;           // share of the observed offset by which the expectation follows

  static constexpr std::uint32_t kWaverPeriod = 500U * kStreamUnit;  // 5 s: at 100 ppm a frame needs that long past a millisecond of jitter

  std::uint32_t due_ = 0, wavered_at_ = 0;
  std::int32_t owed_ = 0, least_ = 0, most_ = 0;  // frames that should have come and have not
  bool known_ = false, wavers_ = false;
};

}  // namespace hoist::core
