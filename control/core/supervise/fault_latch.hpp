// The faults in force and their details. Protective faults are latched until acknowledged.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/state.hpp"
#include "control/core/supervise/refusals.hpp"

namespace hoist::core {

/// A protective stop is judged this long after it began, before any acknowledgement can count: by then what explains its first fault is
/// known (HOIST_EXPLAINS), and so is the emergency code of a drive.
inline constexpr std::uint64_t kJudgeTicks = kStillTicks - 1;
/// No hand answers an alarm within 0.2 s, and what an open chain does to the drives shows within it: their supply is missed after 10 ms, the
/// input node after 50.
inline constexpr std::uint64_t kHandTicks = 20;

/// Updates the faults in force: this step's conditions and, of the earlier ones, those in `kept`. Emits an event for
/// each fault that is raised or cleared; returns the raised ones.
contract::FaultBits take_conditions(CoreState& state, contract::FaultBits conditions, contract::FaultBits kept) noexcept;
/// Raises a fault, with its event; no effect when it is in force already.
void latch(CoreState& state, contract::Fault fault) noexcept;
/// Faults that an earlier run of the core left latched.
void restore_latched(CoreState& state, contract::FaultBits bits) noexcept;
/// Acknowledges these faults; one whose condition is found again comes back.
void clear_latched(CoreState& state, contract::FaultBits bits) noexcept;

/// Faults in force that floor, load or patient caused.
[[nodiscard]] contract::FaultBits from_outside(const CoreState& state) noexcept;
/// The drive reports a fault.
[[nodiscard]] bool drive_in_fault(const DriveSensor& drive) noexcept;

}  // namespace hoist::core
