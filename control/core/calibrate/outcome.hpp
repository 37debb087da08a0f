// What a calculator of this folder comes to: a value, or why there is none.
#pragma once
#include <cmath>

#include "control/contract/calibration.hpp"

namespace hoist::core {

struct Outcome {
  double value = 0;
  contract::CalibrationReason reason = contract::CalibrationReason::none;
  [[nodiscard]] bool good() const noexcept { return reason == contract::CalibrationReason::none; }
};

[[nodiscard]] constexpr Outcome no_outcome(contract::CalibrationReason reason) noexcept { return {0, reason}; }

/// A measured length is believed when it is within a fifth of what the machine was built to: nearer than any slip of the tape or of the
/// sign, wider than any tolerance of a workshop.
[[nodiscard]] inline bool near_design(double value, double design) noexcept { return std::fabs(value - design) <= 0.2 * std::fabs(design); }

}  // namespace hoist::core
