#include "control/core/supervise/service.hpp"

#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

std::uint32_t begin_service(CoreState& state) noexcept {
  if (state.mode != Mode::init) {
    const Transition* row = find_transition(state.mode, Mode::init, Asker::engineer);
    if (row == nullptr) return refusal_bit(Refusal::not_standby) | where_it_stands(state);
    if (const std::uint32_t bits = guard_refusals(state, row->guard); bits != 0) return bits;
    change_mode(state, Mode::init);
  }
  state.in_mode.epoch = state.lease.epoch;
  state.in_mode.service.on = true;
  state.in_mode.service.quiet_ticks = 0;
  return 0;
}

}  // namespace hoist::core
