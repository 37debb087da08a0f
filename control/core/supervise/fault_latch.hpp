// The faults in force and their details. Protective faults are latched until acknowledged.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

/// Takes over what holds in this step, beside what stays latched (`kept`). Tells what came and what went. Returns what came.
contract::FaultBits take_conditions(CoreState& state, contract::FaultBits conditions, contract::FaultBits kept) noexcept;
/// A fault from now on, and told; nothing when it is in force already.
void latch(CoreState& state, contract::Fault fault) noexcept;
/// What an earlier run of the core has left behind.
void restore_latched(CoreState& state, contract::FaultBits bits) noexcept;
/// Acknowledged: these are no longer in force, unless they are found again.
void clear_latched(CoreState& state, contract::FaultBits bits) noexcept;

/// Faults in force that floor, load or patient have brought about.
[[nodiscard]] contract::FaultBits from_outside(const CoreState& state) noexcept;
/// The drive says so itself.
[[nodiscard]] bool drive_in_fault(const DriveSensor& drive) noexcept;

}  // namespace hoist::core
