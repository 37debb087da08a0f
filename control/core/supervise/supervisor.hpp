// The only place that changes the mode. The allowed transitions and their conditions are in transitions.hpp.
#pragma once
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/core/state.hpp"
#include "control/core/supervise/fault_sets.hpp"
#include "control/core/supervise/refusals.hpp"
#include "control/core/supervise/transitions.hpp"

namespace hoist::core {

/// A fault of the soft_stop kind that came from a lost driver is shown this long after the hoist has stopped.
inline constexpr std::uint8_t kRemoteLostShownTicks = 100;

/// Takes the monitors' findings: raises, clears, and reacts.
void judge_faults(CoreState& state, contract::FaultBits conditions) noexcept;
/// A fault that no monitor watches has just happened (STOP, the gate).
void raise_fault(CoreState& state, contract::Fault fault) noexcept;

/// Before the first step: what earlier runs of the core have stored. A hoist that was out of service stays so.
void restore_stops(CoreState& state, const StopHistory& history) noexcept;
/// What is to be stored after a step that set `stops_changed`.
[[nodiscard]] StopHistory stop_history(const CoreState& state) noexcept;

/// The lease holder asks for a mode; `to` is a mode of the table. Refusal bits, 0 = done or under way.
[[nodiscard]] std::uint32_t request_mode(CoreState& state, contract::Mode to) noexcept;
/// The present mode has finished.
void finish_mode(CoreState& state) noexcept;
/// Once per step: a hoist that must go out of service does so as soon as it stands.
void serve_breakdown(CoreState& state) noexcept;

/// Enters `to`; the caller has checked the table. The former mode's memory is cleared.
void change_mode(CoreState& state, contract::Mode to) noexcept;

}  // namespace hoist::core
