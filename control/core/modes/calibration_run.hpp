// A calibration step from its request to its result. Nothing here sends anything or changes a parameter.
#pragma once
#include <cstdint>

#include "control/contract/calibration.hpp"
#include "control/contract/commands.hpp"

namespace hoist::core {

struct CoreState;

/// What a step needs that holds now; refusal bits, 0 = it may begin.
[[nodiscard]] std::uint32_t calibration_refusals(const CoreState& state, const contract::CalibrationStepInfo& info) noexcept;
/// Starts the step again.
void begin_calibration(CoreState& state, contract::CalibrationStep step) noexcept;
/// The operator's figures. Refusal bits, 0 = taken, at once or as soon as everything rests.
[[nodiscard]] std::uint32_t measure_calibration(CoreState& state, const contract::Command& command) noexcept;
/// Once per step of CALIBRATE. False when it is over: a minute without progress, or a lost sensor.
[[nodiscard]] bool advance_calibration(CoreState& state, double dt_s) noexcept;
/// Reports how it ended.
void end_calibration(CoreState& state) noexcept;
/// Whether patients may walk: the struts have been zeroed at least once. Simulated struts are upright by themselves.
[[nodiscard]] bool calibration_valid(const CoreState& state) noexcept;

}  // namespace hoist::core
