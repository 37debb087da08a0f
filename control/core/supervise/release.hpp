// Acknowledging a stop. The answer may have to wait for a drive to leave its fault.
#pragma once
#include <cstdint>

#include "control/core/command/acknowledgement.hpp"

namespace hoist::core {

struct CoreState;

/// Leaves PROTECTIVE_STOP, FAULT or EMERGENCY_STOP. Refusal bits; 0 = done, or under way while the acknowledgement waits().
[[nodiscard]] std::uint32_t press_release(CoreState& state, const Press& press) noexcept;
/// Once per step: answers a press that waited for a drive, when the drive has left its fault or the time is up.
void serve_release(CoreState& state) noexcept;

}  // namespace hoist::core
