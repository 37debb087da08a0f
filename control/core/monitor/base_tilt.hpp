// H9: how steeply the chassis stands. Shared by the warning (base_tilt_high.hpp) and the stop (base_tilted.hpp).
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

/// Duration: beyond the jolt of a threshold; the rest of H9's 200 ms is left for the sensor's filter.
inline constexpr std::uint8_t kBaseTiltTicks = 10;

/// Whether the chassis leans by more than this in any direction. A silent sensor says nothing: its loss is another
/// fault.
[[nodiscard]] inline bool base_leans_beyond(const Estimate& sensed, double limit_rad) noexcept {
  if (sensed.base.fresh().lost()) return false;
  const double alpha_rad = sensed.base.alpha_rad(), beta_rad = sensed.base.beta_rad();
  return !(alpha_rad * alpha_rad + beta_rad * beta_rad <= limit_rad * limit_rad);
}

}  // namespace hoist::core
