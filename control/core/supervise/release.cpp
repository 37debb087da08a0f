#include "control/core/supervise/release.hpp"

#include <bit>

#include "control/core/events.hpp"
#include "control/core/supervise/fault_latch.hpp"
#include "control/core/supervise/fault_sets.hpp"
#include "control/core/supervise/refusals.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::fault_bit;
using contract::FaultBits;
using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

namespace {

/// FAULT was entered only for silent nodes or a silent bus.
bool therapist_mends(const CoreState& state) noexcept {
  const FaultBits causes = state.latched & (kProtective & ~kNotOfTheMachine);
  return (state.latched & kBreakdown) == fault_bit(Fault::control_fault) && causes != 0 && (causes & ~kSilence) == 0;
}

struct Way {
  const Transition* row = nullptr;
  std::uint32_t against = 0;  // refusal bits
};

/// The first transition that is open; when none is, the first one with the reasons against it.
Way way_out(const CoreState& state, contract::Role role, FaultBits seen) noexcept {
  Way way;
  for (const Transition& each : kTransitions) {
    if (each.from != state.mode || each.asker != Asker::acknowledgement) continue;
    const std::uint32_t against = guard_refusals(state, each.guard);
    if (way.row != nullptr && against != 0) continue;
    way = {&each, against};
    if (against == 0) break;
  }
  if (way.row == nullptr) return {nullptr, refusal_bit(Refusal::unknown_item)};
  if (way.row->guard == Guard::checked && role != contract::Role::engineer && !therapist_mends(state))
    way.against |= refusal_bit(Refusal::not_allowed);
  if (seen != 0 && (state.latched & kLatching & ~seen) != 0) way.against |= refusal_bit(Refusal::cause_not_seen);
  return way;
}

/// A drive leaves its fault only when it is reset, which the acknowledgement asks for.
void reset_drives(CoreState& state) noexcept {
  const bool left = drive_in_fault(state.sensed.left_drive) || (state.conditions & fault_bit(Fault::drive_left_fault)) != 0;
  const bool right = drive_in_fault(state.sensed.right_drive) || (state.conditions & fault_bit(Fault::drive_right_fault)) != 0;
  if (left) state.left_control.reset_fault();
  if (right) state.right_control.reset_fault();
}

bool causes_hold(const CoreState& state) noexcept { return (state.conditions & kProtective & ~kBumper) != 0; }

void leave_the_stop(CoreState& state, const Transition& row) noexcept {
  if (row.to != Mode::init) {
    clear_latched(state, kProtective);
    change_mode(state, row.to);
    return;
  }
  // INIT configures every node as after switching on. Releasing the emergency stop needs no role, so a hoist that was
  // out of service stays so: causes and counts are kept, and INIT returns to FAULT within this step.
  const bool checked = row.guard == Guard::checked;
  if (checked) {
    state.repeats.forget();
    state.stops_changed = true;
    state.relay.restore();
  }
  const bool broken = !checked && (state.latched & kBreakdown) != 0;
  state.master.meet_all_again();
  change_mode(state, Mode::init);
  clear_latched(state, broken ? kPowerOff : kLatching);
}

}  // namespace

std::uint32_t press_release(CoreState& state, const Press& press) noexcept {
  const Way way = way_out(state, press.role, press.seen);
  if (way.against != 0) return way.against;
  reset_drives(state);
  Acknowledgement& own = state.acknowledgement;
  const std::uint8_t touching = state.sensed.io.bumpers();
  if (way.row->to == Mode::init) {
    leave_the_stop(state, *way.row);
  } else if (causes_hold(state)) {
    own.wait({press.request_id, press.client, state.lease.epoch, touching, kResetTicksMax, false});
  } else {
    own.accept(touching);
    leave_the_stop(state, *way.row);
  }
  return 0;
}

void serve_release(CoreState& state) noexcept {
  Acknowledgement& own = state.acknowledgement;
  if (!own.waits()) return;
  own.count_down();
  const Acknowledgement::Waiting& pressed = own.pressed();
  const bool cleared = !causes_hold(state);
  std::uint32_t bits = pressed.overtaken ? refusal_bit(Refusal::cause_not_cleared) : 0U;
  if (state.lease.epoch != pressed.lease_epoch) bits |= refusal_bit(Refusal::no_lease);
  if (bits == 0 && !cleared && pressed.ticks_left > 0 && state.mode == Mode::protective_stop) return;
  if (!cleared) bits |= refusal_bit(Refusal::cause_not_cleared);
  if (bits == 0) {
    const Way way = way_out(state, contract::Role::therapist, 0);
    bits = way.against;
    if (bits == 0) {
      reset_drives(state);
      // A bumper that touched only after the press is not acknowledged.
      own.accept(pressed.bumpers);
      leave_the_stop(state, *way.row);
    }
  }
  Event event;
  event.kind = bits == 0 ? EventKind::command_done : EventKind::command_refused;
  event.request_id = pressed.request_id;
  event.client = pressed.client;
  event.bits = bits;
  event.code = bits == 0 ? 0U : static_cast<std::uint32_t>(std::countr_zero(bits));
  own.drop();
  if (bits != 0) ++state.commands_refused;
  emit(state, event);
}

}  // namespace hoist::core
