// Edges of the synchronisation input, as events. A line that never rests, such as a camera's frame pulse, does not fill the log: after
// kBurst edges in a row one is told each kRestTicks; the live value `switches` shows all.
#pragma once
#include <cstdint>

namespace hoist::core {

class SyncEdges {
 public:
  static constexpr std::uint8_t kBurst = 20, kRestTicks = 50;

  /// Once per step with a fresh frame of the input node. The first level is where it begins, no edge.
  [[nodiscard]] bool changes(bool level) noexcept {
    if (spent_ > 0 && ++rest_ticks_ >= kRestTicks) {
      rest_ticks_ = 0;
      --spent_;
    }
    const bool first = !known_, same = level == level_;
    known_ = true;
    level_ = level;
    if (first || same || spent_ == kBurst) return false;
    ++spent_;
    return true;
  }

 private:
  bool known_ = false, level_ = false;
  std::uint8_t spent_ = 0, rest_ticks_ = 0;
};

}  // namespace hoist::core
