// Fills the record of a step: every live value of signals.def.
#pragma once
#include "control/contract/signals.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

/// From the moment STOP is pressed or a sensor speaks to the first braking: one step for the bus and one for the loop, and the drive's lag.
inline constexpr double kReaction_s = 0.05;

/// How far the hoist would roll if everything were let go now: stick or lean. Walking, the built-up speed fades with the roll-out time,
/// but never faster than the normal ramp; driving, the driver's ramp; in a stop, the ramp in force.
[[nodiscard]] double stop_distance_m(const CoreState& state) noexcept;

void fill_record(const CoreState& state, const TickInputs& inputs, const Wish& wish, contract::TickRecord& record) noexcept;

}  // namespace hoist::core
