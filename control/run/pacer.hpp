// When steps are due, and how late they are. The time is an argument, so tests choose it.
#pragma once
#include <cstdint>

namespace hoist::run {

inline constexpr std::uint64_t kPeriodNs = 10'000'000;

/// Steps lie on a grid of 10 ms. A step that could not take place is left out, never repeated in a burst (Algorithm 1 is per step, D13);
/// the tick number shows the gap.
class Pacer {
 public:
  explicit Pacer(std::uint64_t first_ns) : wake_ns_(first_ns), due_ns_(first_ns) {}

  /// Until when to sleep, steady clock.
  [[nodiscard]] std::uint64_t wake_ns() const { return wake_ns_; }
  [[nodiscard]] std::uint64_t tick() const { return tick_; }

  /// Start of a step. Returns its lateness: against the grid, or against a period since the previous start, whichever is more. So a late
  /// wake-up counts once, and a step that took too long makes the next one late (H22) although it starts on the grid.
  [[nodiscard]] std::uint64_t begin(std::uint64_t now_ns) {
    const std::uint64_t behind_grid_ns = now_ns > wake_ns_ ? now_ns - wake_ns_ : 0;
    const std::uint64_t behind_last_ns = now_ns > due_ns_ ? now_ns - due_ns_ : 0;
    due_ns_ = now_ns + kPeriodNs;
    return behind_grid_ns > behind_last_ns ? behind_grid_ns : behind_last_ns;
  }
  /// The step has ended.
  void end(std::uint64_t now_ns) {
    const std::uint64_t missed = now_ns > wake_ns_ + kPeriodNs ? (now_ns - wake_ns_) / kPeriodNs : 0;
    tick_ += 1 + missed;
    wake_ns_ += (1 + missed) * kPeriodNs;
  }

 private:
  std::uint64_t wake_ns_, due_ns_, tick_ = 0;
};

}  // namespace hoist::run
