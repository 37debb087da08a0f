#include "control/core/supervise/supervisor.hpp"

#include <bit>

#include "control/core/events.hpp"
#include "control/core/modes/calibration_run.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/standstill.hpp"
#include "control/core/supervise/fault_latch.hpp"
#include "control/core/supervise/fault_sets.hpp"

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

/// Ends the exercise, for every reason.
void tell_guided_end(CoreState& state) noexcept {
  state.guided.end(contract::GuidedEnd::stopped);
  // It cannot be continued.
  if (state.guided.ended() == contract::GuidedEnd::finished) state.start.exercise = 0;
  Event event;
  event.kind = EventKind::guided_ended;
  event.code = static_cast<std::uint32_t>(state.guided.ended());
  event.value = state.guided.left_m();
  emit(state, event);
}

void stop_protectively(CoreState& state, FaultBits causes) noexcept {
  if (find_transition(state.mode, Mode::protective_stop, Asker::fault) != nullptr) {
    const bool counts = state.mode != Mode::init;
    change_mode(state, Mode::protective_stop);
    state.in_mode.braking = Braking::protective;
    state.in_mode.causes = counts ? causes : FaultBits{0};
    state.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(contract::first_cause(causes)) + 1U);
  }
  if ((causes & fault_bit(Fault::bumper_pressed)) != 0) state.in_mode.braking = Braking::bumper;
}

/// H22: machine faults that stopped the hoist too often put it out of service. Not what one of `explaining` has brought.
void count_stop(CoreState& state, FaultBits explaining) noexcept {
  const FaultBits own = state.in_mode.causes & kCountedStops & ~contract::consequences(explaining) & ~from_outside(state);
  for (FaultBits bits = own; bits != 0; bits &= bits - 1) {
    state.stops_changed = true;
    if (!state.repeats.note(static_cast<std::uint8_t>(std::countr_zero(bits)), state.time_ns, state.params)) continue;
    if (watches(Fault::control_fault)) latch(state, Fault::control_fault);
  }
}

/// In the first second of a protective stop a cause that is found after its consequence takes its place. At the end of
/// it machine faults are counted.
void judge_stop(CoreState& state) noexcept {
  if (state.mode != Mode::protective_stop || state.in_mode.ticks > kJudgeTicks) return;
  for (const contract::Explanation& row : contract::kExplanations) {
    if (state.stop_cause != static_cast<std::uint8_t>(row.effect) + 1U || (state.latched & fault_bit(row.cause)) == 0) continue;
    state.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(row.cause) + 1U);
    if (state.in_mode.causes != 0) state.in_mode.causes |= fault_bit(row.cause);
  }
  if (state.in_mode.ticks == kJudgeTicks) count_stop(state, state.latched);
}

/// The power is gone: the controller's motion state is cleared, and driving ends.
void stop_without_power(CoreState& state) noexcept {
  if (find_transition(state.mode, Mode::emergency_stop, Asker::hardware) == nullptr) return;
  // What an opened chain looks like to the drives comes with it. A stop that is older had its own cause, and then a hand came; but a relay that
  // opens without a word is found a second after what it has brought.
  if (state.mode == Mode::protective_stop && state.in_mode.ticks >= kHandTicks && state.in_mode.ticks <= kJudgeTicks)
    count_stop(state, state.sensed.io.emergency_stop_open() ? state.latched & ~fault_bit(Fault::emergency_stop) : state.latched);
  change_mode(state, Mode::emergency_stop);
  state.stop_cause = static_cast<std::uint8_t>(Fault::emergency_stop) + 1;
  state.acknowledgement.drop();
  give_lease(state, 0);
}

/// Motion ends gently, then STANDBY.
void stop_softly(CoreState& state, Asker asker) noexcept {
  if (find_transition(state.mode, Mode::standby, asker) == nullptr || !is_moving(state.mode)) return;
  state.in_mode.leaving = true;
  if (state.in_mode.braking < Braking::soft) state.in_mode.braking = Braking::soft;
}

}  // namespace

void change_mode(CoreState& state, Mode to) noexcept {
  const Mode from = state.mode;
  if (from == Mode::calibrate) end_calibration(state);
  if (from == Mode::guided) tell_guided_end(state);
  state.mode = to;
  state.in_mode = {};
  state.in_mode.epoch = state.lease.epoch;
  state.still = {};
  state.lean = {};
  state.turn = {};
  if (to != Mode::protective_stop) {
    state.limiter.reset();
  } else if (!is_moving(from)) {
    // Drives off, perhaps pushed by hand: the ramp begins at the wheels' speed.
    state.limiter.start_from(state.params, state.sensed.odometry.speed_m_s, state.sensed.odometry.yaw_rate_rad_s);
  }
  mode_row_of(to).enter(state);
  Event event;
  event.kind = EventKind::mode_changed;
  event.code = static_cast<std::uint32_t>(to);
  event.item = static_cast<std::uint32_t>(from);
  emit(state, event);
}

void judge_faults(CoreState& state, FaultBits conditions) noexcept {
  // Out of service or without power nothing is left to stop, and INIT checks everything again: only what led here stays
  // an alarm.
  if (state.mode == Mode::fault || state.mode == Mode::emergency_stop) conditions &= ~kProtective;
  // Drives whose supply the core has taken away (H1) report it as their fault.
  if (state.relay.is_cut()) conditions &= ~kDriveFaults;
  // Also for a cause that is latched already and returns; bumpers are remembered one by one.
  if ((conditions & ~state.conditions & kProtective & ~kBumper) != 0) state.acknowledgement.overtake();
  // Protective faults stay until acknowledged. In INIT nothing has run yet that an acknowledgement could be about, but for what puts the
  // hoist out of service.
  const FaultBits raised = take_conditions(state, conditions, state.mode == Mode::init ? kBreakdown : kLatching);
  if ((raised & kPowerOff) != 0) stop_without_power(state);
  if ((raised & kProtective) != 0 && state.mode != Mode::init) stop_protectively(state, raised & kProtective);
  if ((raised & kSoft) != 0) stop_softly(state, Asker::core);
  judge_stop(state);
  if (state.repeats.expire(state.time_ns, state.params)) state.stops_changed = true;
  state.in_mode.silent.step(state.mode == Mode::protective_stop && (conditions & kSilence) != 0, kGoneTicks);
}

void raise_fault(CoreState& state, Fault fault) noexcept {
  if (!watches(fault)) return;
  state.acknowledgement.overtake();
  latch(state, fault);
  // In INIT and at standstill there is nothing to brake: the hoist goes out of service within this step.
  if ((fault_bit(fault) & kBreakdown) != 0 && (state.mode == Mode::init || (!is_moving(state.mode) && at_rest(state)))) return;
  stop_protectively(state, fault_bit(fault));
}

void serve_breakdown(CoreState& state) noexcept {
  if ((state.latched & kBreakdown) == 0) return;
  const Transition* row = find_transition(state.mode, Mode::fault, Asker::breakdown);
  if (row == nullptr || guard_refusals(state, row->guard) != 0) return;
  change_mode(state, Mode::fault);
  // control_fault only says that there were too many stops: their own cause stays the one that is shown.
  const bool known = state.stop_cause != 0 && (state.latched >> (state.stop_cause - 1U) & 1U) != 0;
  if (!known || (state.latched & kBreakdown) != fault_bit(Fault::control_fault))
    state.stop_cause = static_cast<std::uint8_t>(std::countr_zero(state.latched & kBreakdown) + 1);
  state.stops_changed = true;
  state.acknowledgement.drop();
}

void restore_stops(CoreState& state, const StopHistory& history) noexcept {
  if (state.started) return;
  state.repeats.restore(history);
  if ((history.out_of_service & fault_bit(Fault::control_fault)) == 0) return;
  const FaultBits known = fault_bit(Fault::control_fault) | (kProtective & ~kNotOfTheMachine);
  restore_latched(state, history.out_of_service & known);
  change_mode(state, Mode::fault);
  // H1: it may have run away; a new start must not restore the supply.
  if ((state.latched & fault_bit(Fault::overspeed)) != 0) state.relay.cut();
  state.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(Fault::control_fault) + 1U);
}

StopHistory stop_history(const CoreState& state) noexcept {
  StopHistory history = state.repeats.history();
  const FaultBits bit = fault_bit(Fault::control_fault);
  // On its way to FAULT or there, also through the emergency stop.
  if ((state.latched & bit) != 0) history.out_of_service = state.latched & (bit | (kProtective & ~kNotOfTheMachine));
  return history;
}

std::uint32_t request_mode(CoreState& state, Mode to) noexcept {
  if (to == state.mode && to == Mode::standby) return 0;
  const Transition* row = find_transition(state.mode, to, Asker::driver);
  if (row == nullptr) {
    // A mode that the table offers from STANDBY may be requested; a request in another mode is answered with every reason.
    const bool start = find_transition(Mode::standby, to, Asker::driver) != nullptr;
    if (!start && to != Mode::standby) return refusal_bit(Refusal::unknown_item);
    return refusal_bit(Refusal::not_standby) | where_it_stands(state) | (is_moving(to) ? start_refusals(state, to) : 0U);
  }
  if (is_moving(state.mode)) {
    stop_softly(state, Asker::driver);
    return 0;
  }
  const std::uint32_t bits = is_moving(to) ? start_refusals(state, to) : guard_refusals(state, row->guard);
  if (bits != 0) return bits;
  change_mode(state, to);
  return 0;
}

void finish_mode(CoreState& state) noexcept {
  if (find_transition(state.mode, Mode::standby, Asker::core) != nullptr) change_mode(state, Mode::standby);
}

}  // namespace hoist::core
