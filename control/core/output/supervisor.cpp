#include "control/core/output/supervisor.hpp"

#include <bit>

#include "control/core/modes/mode_list.hpp"

namespace hoist::core {

using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::fault_bit;
using contract::Mode;
using contract::Reaction;
using contract::Refusal;
using contract::refusal_bit;

namespace {

constexpr std::uint32_t kProtective = faults_with(Reaction::protective_stop);
constexpr std::uint32_t kSoft = faults_with(Reaction::soft_stop);
constexpr std::uint32_t kWarnings = faults_with(Reaction::warn);
constexpr std::uint32_t kDriveFaults = fault_bit(Fault::drive_left_fault) | fault_bit(Fault::drive_right_fault);

void tell_faults(CoreState& state, std::uint32_t bits, EventKind kind) noexcept {
  for (; bits != 0; bits &= bits - 1) {
    Event event;
    event.kind = kind;
    event.code = static_cast<std::uint32_t>(std::countr_zero(bits));
    // Which device it is about, where a fault may be about any.
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_duplicate))
      event.item = state.health.duplicate_id();
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_babbling))
      event.item = state.health.babbling_id();
    emit(state, event);
  }
}

void change_mode(CoreState& state, Mode to) noexcept {
  const Mode from = state.mode;
  state.mode = to;
  state.motion = {};
  state.motion.epoch = state.lease.epoch;
  state.still_ticks = 0;
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

void stop_protectively(CoreState& state, std::uint32_t causes) noexcept {
  if (find_transition(state.mode, Mode::protective_stop, Asker::fault) != nullptr) {
    change_mode(state, Mode::protective_stop);
    state.motion.braking = Braking::protective;
    state.stop_cause = static_cast<std::uint8_t>(std::countr_zero(causes) + 1);
  }
  if ((causes & fault_bit(Fault::bumper_pressed)) != 0) state.motion.braking = Braking::bumper;
}

/// Motion ends gently, then STANDBY.
void stop_softly(CoreState& state, Asker asker) noexcept {
  if (find_transition(state.mode, Mode::standby, asker) == nullptr || !is_moving(state.mode)) return;
  state.motion.leaving = true;
  if (state.motion.braking < Braking::soft) state.motion.braking = Braking::soft;
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
  add(!state.master.all_running() || sensed.tilts_stale() || sensed.drives_lost() || sensed.io.fresh().lost(), Refusal::nodes_missing);
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
  return bits;
}

void judge_faults(CoreState& state, std::uint32_t conditions) noexcept {
  state.conditions = conditions;
  const std::uint32_t before = state.latched;
  // Protective faults stay until acknowledged. In INIT nothing has run yet that an acknowledgement could be about.
  const std::uint32_t kept = state.mode == Mode::init ? 0U : before & kProtective;
  state.latched = conditions | kept;
  if (state.latched == before) return;
  const std::uint32_t raised = state.latched & ~before;
  tell_faults(state, before & ~state.latched, EventKind::fault_cleared);
  tell_faults(state, raised, EventKind::fault_raised);
  if ((raised & kProtective) != 0 && state.mode != Mode::init) stop_protectively(state, raised & kProtective);
  if ((raised & kSoft) != 0) stop_softly(state, Asker::core);
}

void raise_fault(CoreState& state, Fault fault) noexcept {
  if (!watches(fault)) return;
  const std::uint32_t bit = fault_bit(fault);
  if ((state.latched & bit) == 0) {
    state.latched |= bit;
    tell_faults(state, bit, EventKind::fault_raised);
  }
  stop_protectively(state, bit);
}

std::uint32_t request_mode(CoreState& state, Mode to) noexcept {
  if (to == Mode::standby) {
    if (state.mode == Mode::standby) return 0;
    const Transition* row = find_transition(state.mode, to, Asker::driver);
    if (row == nullptr)
      return refusal_bit(state.mode == Mode::init ? Refusal::nodes_missing : Refusal::fault_active) | refusal_bit(Refusal::not_standby);
    stop_softly(state, Asker::driver);
    return 0;
  }
  if (to != Mode::user && to != Mode::remote) return refusal_bit(Refusal::unknown_item);
  const std::uint32_t bits = start_refusals(state);
  if (bits != 0) return bits;
  // The table has the last word, so that a mode added to faults.def is not reachable before somebody wrote down from where.
  if (find_transition(state.mode, to, Asker::driver) == nullptr) return refusal_bit(Refusal::not_standby);
  change_mode(state, to);
  return 0;
}

std::uint32_t begin_service(CoreState& state) noexcept {
  if (state.mode != Mode::init) {
    if (find_transition(state.mode, Mode::init, Asker::engineer) == nullptr) return refusal_bit(Refusal::not_standby);
    if (!at_rest(state)) return refusal_bit(Refusal::moving);
    change_mode(state, Mode::init);
  }
  state.motion.epoch = state.lease.epoch;
  state.motion.service.on = true;
  state.motion.service.quiet_ticks = 0;
  return 0;
}

void finish_mode(CoreState& state) noexcept {
  if (find_transition(state.mode, Mode::standby, Asker::core) != nullptr) change_mode(state, Mode::standby);
}

std::uint32_t acknowledge(CoreState& state, bool& wait) noexcept {
  wait = false;
  if (find_transition(state.mode, Mode::standby, Asker::acknowledgement) == nullptr) return refusal_bit(Refusal::unknown_item);
  const std::uint32_t causes = state.conditions & kProtective;
  std::uint32_t bits = 0;
  if ((causes & ~kDriveFaults) != 0) bits |= refusal_bit(Refusal::cause_not_cleared);
  if (state.still_ticks < kStillTicks) bits |= refusal_bit(Refusal::moving);
  if (bits != 0) return bits;
  if (causes != 0) {
    // A drive leaves its fault only when told to, and telling it is what the therapist's press means.
    if ((causes & fault_bit(Fault::drive_left_fault)) != 0) state.left_control.reset_fault();
    if ((causes & fault_bit(Fault::drive_right_fault)) != 0) state.right_control.reset_fault();
    wait = true;
    return 0;
  }
  tell_faults(state, state.latched & kProtective, EventKind::fault_cleared);
  state.latched &= ~kProtective;
  change_mode(state, Mode::standby);
  return 0;
}

void serve_pending(CoreState& state) noexcept {
  PendingAcknowledge& pending = state.pending;
  if (pending.ticks_left == 0) return;
  --pending.ticks_left;
  const bool cleared = (state.conditions & kProtective) == 0;
  if (!cleared && pending.ticks_left > 0 && state.mode == Mode::protective_stop) return;
  bool wait = false;
  std::uint32_t bits = cleared ? acknowledge(state, wait) : refusal_bit(Refusal::cause_not_cleared);
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
