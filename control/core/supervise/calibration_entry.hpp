// The way into CALIBRATE and out of it; what happens between is modes/calibration_run.hpp.
#pragma once
#include <cstdint>

#include "control/contract/calibration.hpp"

namespace hoist::core {

struct CoreState;

/// The lease holder, in the role that the step wants, calibrates: CALIBRATE from STANDBY, or another step there. Refusal bits, 0 = begun.
[[nodiscard]] std::uint32_t enter_calibration(CoreState& state, const contract::CalibrationStepInfo& info) noexcept;
/// CALIBRATE ends: `used` when the result has become parameters.
void leave_calibration(CoreState& state, bool used) noexcept;

}  // namespace hoist::core
