// Each bumper is pressed once, in the order of the bits. A check, not a mapping: a strip that answers in place of
// another is wired wrongly.
#pragma once
#include <cstdint>

#include "control/contract/calibration.hpp"

namespace hoist::core {

class BumperCheck {
 public:
  static constexpr std::uint8_t kStrips = 4;

  /// One step with the bits of the input node. Anything but none ends the check.
  contract::CalibrationReason step(std::uint8_t bits) noexcept {
    using contract::CalibrationReason;
    if (done()) return CalibrationReason::none;
    const auto wanted = static_cast<std::uint8_t>(1U << next_);
    if (bits == 0) {
      if (pressed_) ++next_;
      pressed_ = false;
      stuck_ticks_ = 0;
      free_ = true;
      return CalibrationReason::none;
    }
    // A strip that is pressed at the start may be released within kStuckTicks.
    if (!free_) return ++stuck_ticks_ >= kStuckTicks ? CalibrationReason::bumper_stuck : CalibrationReason::none;
    if ((bits & ~wanted) != 0) return CalibrationReason::bumper_swapped;
    if (++stuck_ticks_ >= kHeldTicks) return CalibrationReason::bumper_stuck;
    pressed_ = true;
    return CalibrationReason::none;
  }

  /// Strip that is wanted now, 0 to 3; 4 when all have answered.
  [[nodiscard]] std::uint8_t next() const noexcept { return next_; }
  [[nodiscard]] bool done() const noexcept { return next_ >= kStrips; }

 private:
  static constexpr std::uint16_t kStuckTicks = 300, kHeldTicks = 2000;  // 3 s, 20 s

  std::uint16_t stuck_ticks_ = 0;
  std::uint8_t next_ = 0;
  bool pressed_ = false, free_ = false;
};

}  // namespace hoist::core
