// A condition that counts once it has held for some control steps without a break.
#pragma once
#include <cstdint>

namespace hoist::core {

struct HeldFor {
  std::uint16_t ticks = 0;  // steps in a row, up to the limit of the latest step()

  /// One step. True when the condition has now held in at least `limit_ticks` steps in a row.
  bool step(bool holds, std::uint16_t limit_ticks) noexcept {
    ticks = !holds ? std::uint16_t{0} : static_cast<std::uint16_t>(ticks < limit_ticks ? ticks + 1 : limit_ticks);
    return reached(limit_ticks);
  }
  [[nodiscard]] constexpr bool reached(std::uint16_t limit_ticks) const noexcept { return ticks >= limit_ticks; }
};

}  // namespace hoist::core
