// Debouncing: a condition counts once it has lasted for some control steps without a break.
#pragma once
#include <cstdint>

namespace hoist::core {

struct Lasting {
  std::uint16_t ticks = 0;  // steps in a row, up to the limit of the latest step()

  /// One step. True when the condition has now been true in at least `limit_ticks` steps in a row.
  bool step(bool now, std::uint16_t limit_ticks) noexcept {
    ticks = !now ? std::uint16_t{0} : static_cast<std::uint16_t>(ticks < limit_ticks ? ticks + 1 : limit_ticks);
    return reached(limit_ticks);
  }
  [[nodiscard]] constexpr bool reached(std::uint16_t limit_ticks) const noexcept { return ticks >= limit_ticks; }
};

}  // namespace hoist::core
