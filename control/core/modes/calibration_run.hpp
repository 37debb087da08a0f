// A calibration step from its request to its result. Nothing here sends anything or changes a parameter.
#pragma once
#include <cstdint>

#include "control/contract/calibration.hpp"
#include "control/contract/commands.hpp"

namespace hoist::core {

struct CoreState;
struct Staging;

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
/// Whether wheels, bumpers and strut sensors were found on their sides and the right way round, with the sensors and drives that are there now
/// (H2, H7, H13).
[[nodiscard]] bool parts_checked(const CoreState& state) noexcept;
/// What a used check leaves beside its date: which parts it was about. With others than before, the other checks are due again.
void sign_parts(const CoreState& state, Staging& set) noexcept;

}  // namespace hoist::core
