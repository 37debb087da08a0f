// Why motion may not start, and why the mode may not change: every reason at once, as refusal bits. Nothing is changed here.
#pragma once
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/core/state.hpp"
#include "control/core/supervise/transitions.hpp"

namespace hoist::core {

/// How long the hoist must have stood before an acknowledgement counts: one second.
inline constexpr std::uint8_t kStillTicks = 100;
/// A node that is silent for longer than any node takes to restart: 2.5 s.
inline constexpr std::uint8_t kGoneTicks = 250;

/// Every reason, as refusal bits, why motion may not start now; without the ones that depend on who asks or for which mode. 0 = it may.
[[nodiscard]] std::uint32_t start_refusals(const CoreState& state) noexcept;
/// The reasons against this way of starting: start_refusals, less the bumper that REMOTE is to drive away from.
[[nodiscard]] std::uint32_t start_refusals(const CoreState& state, contract::Mode to) noexcept;

/// The further reasons against GUIDED: no figure, or hold-to-run already held.
[[nodiscard]] std::uint32_t guided_refusals(const CoreState& state) noexcept;

/// The reasons against a row of the transition table with this guard.
[[nodiscard]] std::uint32_t guard_refusals(const CoreState& state, Guard guard) noexcept;
/// The reason that the present mode gives against any start.
[[nodiscard]] std::uint32_t where_it_stands(const CoreState& state) noexcept;

}  // namespace hoist::core
