// What a real machine hides from its own parameters: how it was built, mounted and wired. Calibration has to find it.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/sim/model.hpp"
#include "firmware/sim/plant.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::sim {

/// How far each figure may stray: a welded frame, a sensor fixed by two screws, tyres of one make.
inline constexpr double kHiddenLength_norm = 0.08, kHiddenMounting_rad = 1.8 * kDegree_rad, kHiddenWheel_norm = 0.015;

/// A machine as it came out of a workshop: the same seed gives the same one. 0 = exactly as designed.
[[nodiscard]] inline PlantParams with_hidden_errors(PlantParams params, std::uint64_t seed) {
  if (seed == 0) return params;
  Random random(seed * 7919 + 17);
  const auto stray = [&random](double& length) { length *= 1.0 + random.uniform(-kHiddenLength_norm, kHiddenLength_norm); };
  stray(params.strut_length_m);
  stray(params.strut_spacing_m);
  stray(params.track_width_m);
  stray(params.wheel_radius_m);
  for (MountingError& mounting : params.mounting)
    mounting = {random.uniform(-kHiddenMounting_rad, kHiddenMounting_rad), random.uniform(-kHiddenMounting_rad, kHiddenMounting_rad)};
  const double unequal = random.uniform(-kHiddenWheel_norm, kHiddenWheel_norm);
  params.wheel_norm = {1.0 + unequal, 1.0 - unequal};
  return params;
}

}  // namespace hoist::sim
