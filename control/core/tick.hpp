// One control step: frames in, decisions, frames out. A pure function of its arguments: same state and inputs, same outputs, bit for bit.
//
// The caller wakes at t_k, hands over everything received, calls tick() and sends the frames in their order. Nodes answer the SYNC of
// step k at once, so their data arrive in step k + 1.
#pragma once
#include "control/core/state.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

/// One step of dt_s (kTick_s; anything else that is finite and positive also works, see D13). Writes all of `out`.
void tick(CoreState& state, const TickInputs& inputs, double dt_s, TickOutputs& out) noexcept;

/// Takes over a stored set before the first step. False, and nothing changed, when a value is not a number, out of range, or the set
/// contradicts itself, or when steps have already run.
[[nodiscard]] bool load_params(CoreState& state, const contract::Params& params) noexcept;

}  // namespace hoist::core
