// How old a reading is, in control steps. A reading is never used without asking this first.
#pragma once
#include <cstdint>

namespace hoist::core {

/// From this age a reading counts as stale: a tilt then means "no intent", never "the last intent" (hazard H4: 30 ms).
inline constexpr std::uint8_t kStaleTicks = 3;
/// From this age its sender counts as lost and the hoist stops (hazards H3, H4, H14: 50 ms, so that braking begins within 60 ms).
inline constexpr std::uint8_t kLostTicks = 5;
inline constexpr std::uint8_t kOldestTicks = 255;

class Freshness {
 public:
  /// At the start of every step, before its frames are read.
  constexpr void next_tick() noexcept {
    if (age_ticks_ < kOldestTicks) ++age_ticks_;
  }
  constexpr void renew() noexcept { age_ticks_ = 0; }
  constexpr void forget() noexcept { age_ticks_ = kOldestTicks; }
  /// 0 = arrived in this step; 255 = that long ago or never.
  [[nodiscard]] constexpr std::uint8_t age_ticks() const noexcept { return age_ticks_; }
  [[nodiscard]] constexpr bool now() const noexcept { return age_ticks_ == 0; }
  [[nodiscard]] constexpr bool stale() const noexcept { return age_ticks_ >= kStaleTicks; }
  [[nodiscard]] constexpr bool lost() const noexcept { return age_ticks_ >= kLostTicks; }

 private:
  std::uint8_t age_ticks_ = kOldestTicks;
};

}  // namespace hoist::core
