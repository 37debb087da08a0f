// A leaky bucket: whether frames come far more often than their plan says, without counting frames that the line delayed.
#pragma once
#include <cstdint>

namespace hoist::core {

class RateWatch {
 public:
  /// Budget: lasting, 1.5 times the plan; at once, half a second of the plan and ten frames.
  struct Budget {
    std::uint32_t leak = 0, room = 0;  // in 1/kUnit frames: per step, and in all
  };
  [[nodiscard]] static constexpr Budget budget(std::uint32_t planned_per_s) noexcept {
    return {planned_per_s * kUnit * 3 / 2 / kStepsPerSecond, (10 + planned_per_s / 2) * kUnit};
  }

  /// One frame came in step `tick`. False when it is beyond the budget.
  [[nodiscard]] bool take(std::uint32_t tick, const Budget& budget) noexcept {
    const std::uint32_t steps = tick - last_tick_ < kStepsMax ? tick - last_tick_ : kStepsMax;
    last_tick_ = tick;
    level_ = level_ > steps * budget.leak ? level_ - steps * budget.leak : 0;
    if (level_ + kUnit > budget.room) return false;
    level_ += kUnit;
    return true;
  }

 private:
  static constexpr std::uint32_t kUnit = 16, kStepsPerSecond = 100;
  static constexpr std::uint32_t kStepsMax = 10'000;  // long enough to empty any bucket

  std::uint32_t level_ = 0, last_tick_ = 0;
};

}  // namespace hoist::core
