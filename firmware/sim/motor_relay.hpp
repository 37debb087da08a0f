// The relay in the motors' supply (hazards H1, H23): closed while its input keeps changing, open about a second after the last change, or
// at once when its second input is on. Both are outputs of the input node, set by the control computer; the real circuit is described in
// firmware/HARDWARE.md.
#pragma once

#include <cstdint>

namespace hoist::sim {

class MotorRelay {
 public:
  /// The circuit's time is 1.0 s with 20 % of tolerance; the drives have braked to rest after 0.70 s.
  static constexpr std::uint32_t kHold_ms = 1000;
  /// So many changes, each within the time, charge the circuit from empty.
  static constexpr std::uint32_t kChangesToClose = 4;
  /// Released, the circuit is empty at once, and the contact falls off within this.
  static constexpr std::uint32_t kDropOut_ms = 20;

  /// One millisecond with the input at this level and the release on or off. Returns whether the relay is closed.
  ///
  /// Before the first change it counts as bridged: a hoist on the bench, and tests of single nodes, have no computer to feed it.
  bool step_1ms(bool level, bool release = false) {
    release_ms_ = !release ? 0 : release_ms_ < kDropOut_ms ? release_ms_ + 1 : kDropOut_ms;
    if (release) {
      level_ = level;
      changes_ = 0;
      age_ms_ = kHold_ms;
      if (release_ms_ == kDropOut_ms) closed_ = false;
    } else if (level != level_) {
      level_ = level;
      age_ms_ = 0;
      if (changes_ < kChangesToClose) ++changes_;
      if (changes_ == kChangesToClose) closed_ = true;
    } else if (age_ms_ < kHold_ms && ++age_ms_ == kHold_ms && changes_ > 0) {
      changes_ = 0;
      closed_ = false;
    }
    return closed_;
  }
  [[nodiscard]] bool closed() const { return closed_; }

 private:
  std::uint32_t age_ms_{}, changes_{}, release_ms_{};
  bool level_{false}, closed_{true};
};

}  // namespace hoist::sim
