#include "control/core/output/supervisor.hpp"

#include <bit>

#include "control/core/modes/mode_list.hpp"

namespace hoist::core {

using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::fault_bit;
using contract::FaultBits;
using contract::Mode;
using contract::Reaction;
using contract::Refusal;
using contract::refusal_bit;

namespace {

constexpr FaultBits kProtective = faults_with(Reaction::protective_stop);
constexpr FaultBits kBreakdown = faults_with(Reaction::out_of_service);
constexpr FaultBits kPowerOff = faults_with(Reaction::power_off);
// What stays until somebody has acknowledged it.
constexpr FaultBits kLatching = kProtective | kBreakdown | kPowerOff;
constexpr FaultBits kSoft = faults_with(Reaction::soft_stop);
constexpr FaultBits kWarnings = faults_with(Reaction::warn);
constexpr FaultBits kBumper = fault_bit(Fault::bumper_pressed);
constexpr FaultBits kDriveFaults = fault_bit(Fault::drive_left_fault) | fault_bit(Fault::drive_right_fault);

void tell_faults(CoreState& state, FaultBits bits, EventKind kind) noexcept {
  for (; bits != 0; bits &= bits - 1) {
    Event event;
    event.kind = kind;
    event.code = static_cast<std::uint32_t>(std::countr_zero(bits));
    // Which device it is about, where a fault may be about any.
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_duplicate))
      event.item = state.health.duplicate_id();
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_babbling))
      event.item = state.health.babbling_id();
    if (kind == EventKind::fault_raised && (contract::faults_with_details() >> event.code & 1U) != 0)
      event.item = state.fault_codes[event.code];
    emit(state, event);
  }
}

bool drive_in_fault(const DriveSensor& drive) noexcept {
  using State = contract::canopen::drive::State;
  return !drive.fresh().lost() && (drive.state() == State::fault || drive.state() == State::fault_reaction);
}

/// What a fault that holds now is about (HOIST_DETAIL); 0 = it has nothing to say.
std::uint16_t code_now(const CoreState& state, Fault fault) noexcept {
  const bool left = fault == Fault::drive_left_fault;
  if (left || fault == Fault::drive_right_fault) {
    const DriveSensor& drive = left ? state.sensed.left_drive : state.sensed.right_drive;
    if (!drive_in_fault(drive)) return 0;
    // The emergency message comes at once, 603Fh up to 50 ms later. The register tells whether that error is still there.
    const NodeHealth& node = state.health.node(left ? contract::Node::drive_left : contract::Node::drive_right);
    return node.error_register != 0 ? node.emcy_code : drive.error_code();
  }
  if (fault == Fault::tilt_implausible) return std::get<TiltImplausible>(state.monitors).code();
  if (fault == Fault::overspeed) return std::get<Overspeed>(state.monitors).code();
  return 0;
}

/// Codes belong to the beginning of a fault: what a drive says while it is reset, or a strut that swings back, is not its cause.
void keep_codes(CoreState& state, FaultBits raised) noexcept {
  for (FaultBits bits = contract::faults_with_details(); bits != 0; bits &= bits - 1) {
    const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
    const bool held = (state.latched >> bit & 1U) != 0, begins = (raised >> bit & 1U) != 0;
    if (!held) state.fault_codes[bit] = 0;
    // A drive's code may be later than its fault.
    if (held && (begins || (state.fault_codes[bit] == 0 && state.motion.ticks <= kJudgeTicks &&
                            (fault_bit(static_cast<Fault>(bit)) & kDriveFaults) != 0)))
      state.fault_codes[bit] = code_now(state, static_cast<Fault>(bit));
  }
}

/// Faults in force that floor, load or patient have brought about.
FaultBits from_outside(const CoreState& state) noexcept {
  FaultBits bits = 0;
  for (const contract::DetailInfo& detail : contract::kDetails)
    if (detail.origin == contract::Origin::outside && state.fault_codes[static_cast<std::size_t>(detail.fault)] == detail.code)
      bits |= fault_bit(detail.fault);
  return bits;
}

void latch(CoreState& state, Fault fault) noexcept {
  const FaultBits bit = fault_bit(fault);
  if ((state.latched & bit) != 0) return;
  state.latched |= bit;
  keep_codes(state, bit);
  tell_faults(state, bit, EventKind::fault_raised);
}

/// Acknowledged: these are no longer in force, unless they are found again.
void clear_latched(CoreState& state, FaultBits bits) noexcept {
  tell_faults(state, state.latched & bits, EventKind::fault_cleared);
  state.latched &= ~bits;
  keep_codes(state, 0);
}

/// The exercise is over, whatever ended it.
void tell_guided_end(CoreState& state) noexcept {
  state.guided.end(contract::GuidedEnd::stopped);
  // Nothing is left to go on with.
  if (state.guided.ended() == contract::GuidedEnd::finished) state.start.exercise = 0;
  Event event;
  event.kind = EventKind::guided_ended;
  event.code = static_cast<std::uint32_t>(state.guided.ended());
  event.value = state.guided.left_m();
  emit(state, event);
}

void change_mode(CoreState& state, Mode to) noexcept {
  const Mode from = state.mode;
  if (from == Mode::calibrate) end_calibration(state);
  if (from == Mode::guided) tell_guided_end(state);
  state.mode = to;
  state.motion = {};
  state.motion.epoch = state.lease.epoch;
  state.still = {};
  state.lean = {};
  state.turn = {};
  if (to != Mode::protective_stop) {
    state.limiter.reset();
  } else if (!is_moving(from)) {
    // Drives off, and perhaps being pushed: the ramp begins at what the wheels do.
    state.limiter.start_from(state.params, state.sensed.odometry.speed_m_s, state.sensed.odometry.yaw_rate_rad_s);
  }
  mode_row_of(to).enter(state);
  Event event;
  event.kind = EventKind::mode_changed;
  event.code = static_cast<std::uint32_t>(to);
  event.item = static_cast<std::uint32_t>(from);
  emit(state, event);
}

void stop_protectively(CoreState& state, FaultBits causes) noexcept {
  if (find_transition(state.mode, Mode::protective_stop, Asker::fault) != nullptr) {
    const bool counts = state.mode != Mode::init;
    change_mode(state, Mode::protective_stop);
    state.motion.braking = Braking::protective;
    state.motion.causes = counts ? causes : FaultBits{0};
    state.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(contract::first_cause(causes)) + 1U);
  }
  if ((causes & fault_bit(Fault::bumper_pressed)) != 0) state.motion.braking = Braking::bumper;
}

/// The first second of a protective stop: a cause that is found after its consequence takes its place. At the end, what was the machine's
/// own fault counts; a stop that became an emergency stop meanwhile was that one's consequence and does not.
void judge_stop(CoreState& state) noexcept {
  if (state.mode != Mode::protective_stop || state.motion.ticks > kJudgeTicks) return;
  for (const contract::Explanation& row : contract::kExplanations) {
    if (state.stop_cause != static_cast<std::uint8_t>(row.effect) + 1U || (state.latched & fault_bit(row.cause)) == 0) continue;
    state.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(row.cause) + 1U);
    if (state.motion.causes != 0) state.motion.causes |= fault_bit(row.cause);
  }
  if (state.motion.ticks != kJudgeTicks) return;
  const FaultBits own = state.motion.causes & kCountedStops & ~contract::consequences(state.latched) & ~from_outside(state);
  for (FaultBits bits = own; bits != 0; bits &= bits - 1) {
    state.stops_changed = true;
    if (!state.repeats.note(static_cast<std::uint8_t>(std::countr_zero(bits)), state.time_ns, state.params)) continue;
    if (watches(Fault::control_fault)) latch(state, Fault::control_fault);
  }
}

/// The power is gone. What the controller remembers of motion goes with it, and whoever drove does so no longer.
void stop_without_power(CoreState& state) noexcept {
  if (find_transition(state.mode, Mode::emergency_stop, Asker::hardware) == nullptr) return;
  change_mode(state, Mode::emergency_stop);
  state.stop_cause = static_cast<std::uint8_t>(Fault::emergency_stop) + 1;
  state.pending = {};
  give_lease(state, 0);
}

/// Motion ends gently, then STANDBY.
void stop_softly(CoreState& state, Asker asker) noexcept {
  if (find_transition(state.mode, Mode::standby, asker) == nullptr || !is_moving(state.mode)) return;
  state.motion.leaving = true;
  if (state.motion.braking < Braking::soft) state.motion.braking = Braking::soft;
}

/// FAULT was entered for nothing but what plugs and cables explain.
bool therapist_mends(const CoreState& state) noexcept {
  const FaultBits causes = state.latched & (kProtective & ~kNotOfTheMachine);
  return (state.latched & kBreakdown) == fault_bit(Fault::control_fault) && causes != 0 && (causes & ~kSilence) == 0;
}

/// What there is to say about a mode that nothing can be started from.
std::uint32_t where_it_stands(const CoreState& state) noexcept {
  switch (state.mode) {
    case Mode::init:
      return refusal_bit(Refusal::nodes_missing);
    case Mode::protective_stop:
      return refusal_bit(Refusal::fault_active);
    case Mode::fault:
      return refusal_bit(Refusal::fault_mode);
    case Mode::emergency_stop:
      return refusal_bit(Refusal::emergency_stop_open);
    case Mode::standby:
    case Mode::user:
    case Mode::remote:
    case Mode::calibrate:
    case Mode::guided:
      break;
  }
  return 0;
}

std::uint32_t guard_refusals(const CoreState& state, Guard guard) noexcept {
  std::uint32_t bits = 0;
  switch (guard) {
    case Guard::none:
    case Guard::finished:
    case Guard::ramp_first:
      return 0;
    case Guard::at_rest:
      return at_rest(state) ? 0U : refusal_bit(Refusal::moving);
    case Guard::stood:
    case Guard::checked:
      return !state.still.reached(kStillTicks) ? refusal_bit(Refusal::moving) : 0U;
    case Guard::ready:
      return start_refusals(state, Mode::user);
    case Guard::ready_off_a_bumper:
      return start_refusals(state, Mode::remote);
    case Guard::ready_with_a_path:
      return start_refusals(state, Mode::guided);
    case Guard::cause_gone:
      // A drive's own fault goes with the acknowledgement; so does a bumper that touches, which only driving can clear (H13). A hoist on its
      // way out of service does not come back by this one.
      if ((state.conditions & kProtective & ~kDriveFaults & ~kBumper) != 0) bits |= refusal_bit(Refusal::cause_not_cleared);
      if ((state.latched & kBreakdown) != 0) bits |= refusal_bit(Refusal::fault_mode);
      if (!state.still.reached(kStillTicks)) bits |= refusal_bit(Refusal::moving);
      return bits;
    case Guard::only_silence:
      if ((state.conditions & kProtective & ~kSilence & ~kDriveFaults & ~kBumper) != 0 || !state.motion.silent.reached(kGoneTicks))
        bits |= refusal_bit(Refusal::cause_not_cleared);
      if ((state.latched & kBreakdown) != 0) bits |= refusal_bit(Refusal::fault_mode);
      if (!state.still.reached(kStillTicks)) bits |= refusal_bit(Refusal::moving);
      return bits;
    case Guard::chain_closed:
      if ((state.conditions & kPowerOff) != 0) bits |= refusal_bit(Refusal::emergency_stop_open);
      if (!at_rest(state)) bits |= refusal_bit(Refusal::moving);
      return bits;
  }
  return refusal_bit(Refusal::unknown_item);
}

}  // namespace

void emit(CoreState& state, Event event) noexcept {
  event.tick = state.tick;
  event.time_ns = state.time_ns;
  state.events.push(event);
}

void give_lease(CoreState& state, std::uint32_t client) noexcept {
  if (state.lease.holder == client) return;
  state.lease.holder = client;
  ++state.lease.epoch;
  state.remote.reset();
  Event event;
  event.kind = EventKind::lease_changed;
  event.client = client;
  event.code = state.lease.epoch;
  emit(state, event);
}

std::uint32_t start_refusals(const CoreState& state) noexcept {
  const Estimate& sensed = state.sensed;
  std::uint32_t bits = 0;
  const auto add = [&bits](bool when, Refusal refusal) {
    if (when) bits |= refusal_bit(refusal);
  };
  add(state.mode != Mode::standby, Refusal::not_standby);
  add(state.mode == Mode::fault || (state.latched & kBreakdown) != 0, Refusal::fault_mode);
  add(state.mode == Mode::emergency_stop || (state.conditions & kPowerOff) != 0, Refusal::emergency_stop_open);
  add(!state.master.all_running() || sensed.tilts_stale() || sensed.base.rates_fresh().stale() || sensed.drives_lost() ||
          sensed.io.fresh().lost() || !sensed.io.battery_known(),
      Refusal::nodes_missing);
  add(state.master.any_other_version(), Refusal::node_version);
  add((state.latched & ~kWarnings) != 0, Refusal::fault_active);
  add(!state.intent.neutral(), Refusal::not_neutral);
  add(!at_rest(state), Refusal::moving);
  add((state.latched & fault_bit(Fault::battery_empty)) != 0, Refusal::battery_empty_start);
  add(!sensed.left_strut.has(tilt_status::kConverged) || !sensed.right_strut.has(tilt_status::kConverged) ||
          !sensed.base.has(tilt_status::kConverged),
      Refusal::sensors_settling);
  add(state.lease.holder == 0, Refusal::no_lease);
  // A stick out of the middle counts as long as somebody's hand may still be on it.
  add(!state.remote.neutral() && state.remote.age_s(state.time_ns) <= state.params.remote_stop_age_s, Refusal::stick_not_neutral);
  add(sensed.io.bumpers() != 0, Refusal::bumper_start);
  add(!calibration_valid(state), Refusal::not_calibrated);
  return bits;
}

std::uint32_t guided_refusals(const CoreState& state) noexcept {
  std::uint32_t bits = state.guided.loaded() ? 0U : refusal_bit(Refusal::no_exercise);
  // The dead-man is to be pressed for this exercise, not still held from something else.
  if (state.remote.held() && state.remote.age_s(state.time_ns) <= state.params.remote_stop_age_s)
    bits |= refusal_bit(Refusal::release_first);
  return bits;
}

std::uint32_t start_refusals(const CoreState& state, Mode to) noexcept {
  std::uint32_t bits = start_refusals(state);
  // In REMOTE the hoist may leave what it touches; limiter and gate see to it that it does nothing else.
  if (to == Mode::remote && (state.sensed.io.bumpers() & ~state.bumpers_acknowledged) == 0) bits &= ~refusal_bit(Refusal::bumper_start);
  if (to == Mode::guided) bits |= guided_refusals(state);
  return bits;
}

void judge_faults(CoreState& state, FaultBits conditions) noexcept {
  // Out of service or without power there is nothing left to stop, and INIT will look at everything anew: only what led here is an alarm.
  if (state.mode == Mode::fault || state.mode == Mode::emergency_stop) conditions &= ~kProtective;
  // Drives whose supply the core has taken away (H1) report it as their fault.
  if (state.relay.is_cut()) conditions &= ~kDriveFaults;
  // Also a cause that is latched already and comes again; bumpers are remembered one by one.
  if ((conditions & ~state.conditions & kProtective & ~kBumper) != 0) state.pending.overtaken = true;
  state.conditions = conditions;
  const FaultBits before = state.latched;
  // Protective faults stay until acknowledged. In INIT nothing has run yet that an acknowledgement could be about, but for what puts the
  // hoist out of service.
  const FaultBits kept = before & (state.mode == Mode::init ? kBreakdown : kLatching);
  state.latched = conditions | kept;
  const FaultBits raised = state.latched & ~before;
  keep_codes(state, raised);
  tell_faults(state, before & ~state.latched, EventKind::fault_cleared);
  tell_faults(state, raised, EventKind::fault_raised);
  if ((raised & kPowerOff) != 0) stop_without_power(state);
  if ((raised & kProtective) != 0 && state.mode != Mode::init) stop_protectively(state, raised & kProtective);
  if ((raised & kSoft) != 0) stop_softly(state, Asker::core);
  judge_stop(state);
  if (state.repeats.expire(state.time_ns, state.params)) state.stops_changed = true;
  state.motion.silent.step(state.mode == Mode::protective_stop && (conditions & kSilence) != 0, kGoneTicks);
}

void raise_fault(CoreState& state, Fault fault) noexcept {
  if (!watches(fault)) return;
  state.pending.overtaken = true;
  latch(state, fault);
  // In INIT, and where everything stands, there is nothing to brake: what is to go out of service does so within this step.
  if ((fault_bit(fault) & kBreakdown) != 0 && (state.mode == Mode::init || (!is_moving(state.mode) && at_rest(state)))) return;
  stop_protectively(state, fault_bit(fault));
}

void serve_breakdown(CoreState& state) noexcept {
  if ((state.latched & kBreakdown) == 0) return;
  const Transition* row = find_transition(state.mode, Mode::fault, Asker::breakdown);
  if (row == nullptr || guard_refusals(state, row->guard) != 0) return;
  change_mode(state, Mode::fault);
  // control_fault tells only that there were too many stops: what they were for stays the cause.
  const bool known = state.stop_cause != 0 && (state.latched >> (state.stop_cause - 1U) & 1U) != 0;
  if (!known || (state.latched & kBreakdown) != fault_bit(Fault::control_fault))
    state.stop_cause = static_cast<std::uint8_t>(std::countr_zero(state.latched & kBreakdown) + 1);
  state.stops_changed = true;
  state.pending = {};
}

void restore_stops(CoreState& state, const StopHistory& history) noexcept {
  if (state.started) return;
  state.repeats.restore(history);
  if ((history.out_of_service & fault_bit(Fault::control_fault)) == 0) return;
  const FaultBits known = fault_bit(Fault::control_fault) | (kProtective & ~kNotOfTheMachine);
  state.latched = history.out_of_service & known;
  tell_faults(state, state.latched, EventKind::fault_raised);
  change_mode(state, Mode::fault);
  // H1: it may have run away, and a new start must not give it the supply back.
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
    // What stands in the table from STANDBY is a mode to ask for; whoever asks elsewhere hears every reason, not only that it is elsewhere.
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

std::uint32_t begin_service(CoreState& state) noexcept {
  if (state.mode != Mode::init) {
    const Transition* row = find_transition(state.mode, Mode::init, Asker::engineer);
    if (row == nullptr) return refusal_bit(Refusal::not_standby) | where_it_stands(state);
    if (const std::uint32_t bits = guard_refusals(state, row->guard); bits != 0) return bits;
    change_mode(state, Mode::init);
  }
  state.motion.epoch = state.lease.epoch;
  state.motion.service.on = true;
  state.motion.service.quiet_ticks = 0;
  return 0;
}

std::uint32_t enter_calibration(CoreState& state, const contract::CalibrationStepInfo& info) noexcept {
  if (const std::uint32_t bits = calibration_refusals(state, info); bits != 0) return bits;
  if (state.mode == Mode::calibrate) {
    end_calibration(state);
  } else {
    if (find_transition(state.mode, Mode::calibrate, Asker::driver) == nullptr) return refusal_bit(Refusal::not_standby);
    change_mode(state, Mode::calibrate);
  }
  state.motion.epoch = state.lease.epoch;
  begin_calibration(state, info.step);
  return 0;
}

void leave_calibration(CoreState& state, bool used) noexcept {
  state.motion.calibration.used = used;
  if (!used) state.motion.calibration.reason = contract::CalibrationReason::cancelled;
  change_mode(state, Mode::standby);
}

void finish_mode(CoreState& state) noexcept {
  if (find_transition(state.mode, Mode::standby, Asker::core) != nullptr) change_mode(state, Mode::standby);
}

std::uint32_t acknowledge(CoreState& state, contract::Role role, FaultBits seen, bool& wait) noexcept {
  wait = false;
  const Transition* row = nullptr;
  std::uint32_t bits = 0;
  // The first way that is open; when none is, the reasons of the first one.
  for (const Transition& each : kTransitions) {
    if (each.from != state.mode || each.asker != Asker::acknowledgement) continue;
    const std::uint32_t against = guard_refusals(state, each.guard);
    if (row != nullptr && against != 0) continue;
    row = &each;
    bits = against;
    if (against == 0) break;
  }
  if (row == nullptr) return refusal_bit(Refusal::unknown_item);
  if (row->guard == Guard::checked && role != contract::Role::engineer && !therapist_mends(state))
    bits |= refusal_bit(Refusal::not_allowed);
  if (seen != 0 && (state.latched & kLatching & ~seen) != 0) bits |= refusal_bit(Refusal::cause_not_seen);
  if (bits != 0) return bits;
  // A drive leaves its fault only when told to, and telling it is what the press means.
  const bool reset_left = drive_in_fault(state.sensed.left_drive) || (state.conditions & fault_bit(Fault::drive_left_fault)) != 0;
  const bool reset_right = drive_in_fault(state.sensed.right_drive) || (state.conditions & fault_bit(Fault::drive_right_fault)) != 0;
  if (reset_left) state.left_control.reset_fault();
  if (reset_right) state.right_control.reset_fault();
  if (row->to == Mode::init) {
    // Everything is looked at anew, each node met as if the hoist had just been switched on. But the button asks for no role: what put the
    // hoist out of service stays, with its causes and counts, and INIT leads back to FAULT within this step.
    const bool checked = row->guard == Guard::checked;
    if (checked) {
      state.repeats.forget();
      state.stops_changed = true;
      state.relay.restore();
    }
    const bool broken = !checked && (state.latched & kBreakdown) != 0;
    state.master.meet_all_again();
    change_mode(state, Mode::init);
    clear_latched(state, broken ? kPowerOff : kLatching);
    return 0;
  }
  if ((state.conditions & kProtective & ~kBumper) != 0) {
    wait = true;
    return 0;
  }
  state.bumpers_acknowledged = state.sensed.io.bumpers();
  clear_latched(state, kProtective);
  change_mode(state, row->to);
  return 0;
}

void serve_pending(CoreState& state) noexcept {
  PendingAcknowledge& pending = state.pending;
  if (pending.ticks_left == 0) return;
  --pending.ticks_left;
  pending.bumpers &= state.sensed.io.bumpers();
  const bool cleared = (state.conditions & kProtective & ~kBumper) == 0;
  std::uint32_t bits = pending.overtaken ? refusal_bit(Refusal::cause_not_cleared) : 0U;
  if (state.lease.epoch != pending.lease_epoch) bits |= refusal_bit(Refusal::no_lease);
  if (bits == 0 && !cleared && pending.ticks_left > 0 && state.mode == Mode::protective_stop) return;
  if (!cleared) bits |= refusal_bit(Refusal::cause_not_cleared);
  bool wait = false;
  if (bits == 0) bits = acknowledge(state, contract::Role::therapist, 0, wait);
  // What touched only after the press is a touch that nobody has acknowledged.
  if (bits == 0) state.bumpers_acknowledged = pending.bumpers;
  pending.ticks_left = 0;
  Event event;
  event.kind = bits == 0 ? EventKind::command_done : EventKind::command_refused;
  event.request_id = pending.request_id;
  event.client = pending.client;
  event.bits = bits;
  event.code = bits == 0 ? 0U : static_cast<std::uint32_t>(std::countr_zero(bits));
  if (bits != 0) ++state.commands_refused;
  emit(state, event);
}

}  // namespace hoist::core
