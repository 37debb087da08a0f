// The one place that changes the mode. Who may lead where, and what must hold for it, stands in transitions.hpp; everything else is refused.
#pragma once
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/core/state.hpp"
#include "control/core/supervise/fault_sets.hpp"
#include "control/core/supervise/refusals.hpp"
#include "control/core/supervise/transitions.hpp"

namespace hoist::core {

/// A protective stop is judged this long after it began, before any acknowledgement can count: by then what explains its first fault is
/// known (HOIST_EXPLAINS), and so is the emergency code of a drive.
inline constexpr std::uint64_t kJudgeTicks = kStillTicks - 1;
/// A fault of the soft_stop kind that came from a lost driver is shown this long after the hoist has stopped.
inline constexpr std::uint8_t kRemoteLostShownTicks = 100;

/// Takes over what the monitors found: raises, clears, and reacts.
void judge_faults(CoreState& state, contract::FaultBits conditions) noexcept;
/// A fault that no monitor watches happened just now (STOP, the gate).
void raise_fault(CoreState& state, contract::Fault fault) noexcept;

/// Before the first step: what earlier runs of the core have stored. A hoist that was out of service stays so.
void restore_stops(CoreState& state, const StopHistory& history) noexcept;
/// What is to be stored after a step that set `stops_changed`.
[[nodiscard]] StopHistory stop_history(const CoreState& state) noexcept;

/// The lease holder asks for a mode; `to` is a mode of the table. Refusal bits, 0 = done or under way.
[[nodiscard]] std::uint32_t request_mode(CoreState& state, contract::Mode to) noexcept;
/// The mode in charge says that it is finished.
void finish_mode(CoreState& state) noexcept;
/// Once per step: a hoist that is to go out of service does so as soon as it stands.
void serve_breakdown(CoreState& state) noexcept;

/// Enters `to`; the caller has checked the table. The memory of the mode before ends.
void change_mode(CoreState& state, contract::Mode to) noexcept;

}  // namespace hoist::core
