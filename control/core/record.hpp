// Fills the record of a step: every live value of signals.def.
#pragma once
#include "control/contract/signals.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/state.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

void fill_record(const CoreState& state, const TickInputs& inputs, const Wish& wish, contract::TickRecord& record) noexcept;

}  // namespace hoist::core
