// The result of a calibration solver: a value, or the reason why there is none.
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

/// A measured length is plausible within a fifth of its design value: a misread tape or a wrong sign is further off, workshop tolerances are
/// smaller.
[[nodiscard]] inline bool near_design(double value, double design) noexcept { return std::fabs(value - design) <= 0.2 * std::fabs(design); }

}  // namespace hoist::core
