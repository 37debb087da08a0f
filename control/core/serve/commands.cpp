#include "control/core/serve/commands.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "control/contract/param_set.hpp"
#include "control/core/events.hpp"
#include "control/core/modes/calibration_run.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "control/core/standstill.hpp"
#include "control/core/supervise/calibration_entry.hpp"
#include "control/core/supervise/release.hpp"
#include "control/core/supervise/service.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::Command;
using contract::CommandKind;
using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

namespace {

// Odometry marks beyond these are mistakes: the widest hall, and some tens of turns.
constexpr double kPoseLargest_m = 1000.0, kPoseLargest_rad = 1000.0;
// "Set neutral": a patient whose harness moved further than this within the second was not standing at ease. Gait sway of a walking
// patient is 12 mm forward and back (paper readings, section 5); a standing one moves by a few.
constexpr double kNeutralSpread_m = 0.02;

// What a command came to: refusal bits (0 = done) and, for parameters, which row it was about.
struct Verdict {
  std::uint32_t bits = 0;
  std::uint32_t item = 0;
  bool later = false;  // answered in a later step
};

constexpr Verdict refused(Refusal refusal, std::uint32_t item = 0) { return {refusal_bit(refusal), item, false}; }

bool standing(const CoreState& state) noexcept { return state.mode == Mode::standby && at_rest(state); }

// ----- parameters -----

Verdict stage(CoreState& state, const Command& command) noexcept {
  Staging& staging = state.staging;
  if (command.b == 0) {
    staging.rows.clear();
    staging.client = command.client;
  }
  // A row of another client's set, or one out of order: the set is not the one that its sender meant.
  if (staging.client != command.client || command.b != staging.rows.size()) return refused(Refusal::out_of_order, command.a);
  const auto index = contract::find_param_id(command.a);
  if (!index) return refused(Refusal::unknown_item, command.a);
  switch (contract::check_param(*index, command.v0)) {
    case contract::ParamCheck::ok:
      break;
    case contract::ParamCheck::unknown:
      return refused(Refusal::unknown_item, command.a);
    case contract::ParamCheck::not_finite:
      return refused(Refusal::not_finite, command.a);
    case contract::ParamCheck::out_of_range:
      return refused(Refusal::out_of_range, command.a);
  }
  for (const Staging::Row& row : staging.rows)
    if (row.index == *index) return refused(Refusal::inconsistent_set, command.a);
  if (!staging.rows.push_back({*index, command.v0})) return refused(Refusal::out_of_order, command.a);
  return {};
}

// All reasons against a set, and the first row they are about.
Verdict check_set(const CoreState& state, const Staging& set, contract::Role role, bool trial) noexcept {
  Verdict verdict;
  // What is in force afterwards, and what is left of it when a running trial goes back: both must fit together.
  contract::Params next = state.params, later = state.params;
  if (!trial && state.trial.left_s > 0)
    for (std::size_t i = 0; i < contract::kParamCount; ++i) contract::set_param_unchecked(later, i, kept_param(state, i));
  for (const Staging::Row& row : set.rows) {
    const contract::ParamInfo& info = contract::kParams[row.index];
    std::uint32_t bits = 0;
    if (static_cast<int>(role) < static_cast<int>(info.role)) bits |= refusal_bit(Refusal::not_allowed);
    // What may not change while moving may not go back while moving either.
    if (info.edit == contract::EditRule::stopped && (trial || !standing(state))) bits |= refusal_bit(Refusal::only_when_stopped);
    if (bits != 0 && verdict.item == 0) verdict.item = info.id;
    verdict.bits |= bits;
    contract::set_param_unchecked(next, row.index, row.value);
    contract::set_param_unchecked(later, row.index, row.value);
  }
  if (contract::check_param_set(next) != nullptr || contract::check_param_set(later) != nullptr)
    verdict.bits |= refusal_bit(Refusal::inconsistent_set);
  for (const contract::ParamRoom& room : contract::kParamRooms) {
    if (contract::leaves_room(room, next) && contract::leaves_room(room, later)) continue;
    for (const Staging::Row& row : set.rows) {
      const bool about = row.index == contract::param_index(room.smaller) || row.index == contract::param_index(room.larger);
      // A value that is in force already is no change: a patient's settings name every value that a therapist may set.
      if (!about || row.value == contract::get_param(state.params, row.index)) continue;
      if (verdict.item == 0) verdict.item = contract::kParams[row.index].id;
      verdict.bits |= refusal_bit(Refusal::inconsistent_set);
    }
  }
  return verdict;
}

// The set as it arrived is the set as it was sent, and was made for the parameters that are in force.
bool sealed(const CoreState& state, const Staging& set, std::uint64_t seal) noexcept {
  contract::ParamSetSeal arrived;
  for (const Staging::Row& row : set.rows) arrived.add(contract::kParams[row.index].id, row.value);
  const auto version = static_cast<std::uint32_t>(seal >> 32U);
  return arrived.value(version) == seal && (version == 0 || version == static_cast<std::uint32_t>(state.parameter_version));
}

Verdict commit(CoreState& state, const Command& command) noexcept {
  const Staging set = state.staging;
  if (set.client != command.client || set.rows.empty() || command.a != set.rows.size()) return refused(Refusal::out_of_order);
  state.staging.rows.clear();
  if (command.b > static_cast<std::uint32_t>(contract::Role::engineer)) return refused(Refusal::not_allowed);
  if (!std::isfinite(command.v0)) return refused(Refusal::not_finite);
  const bool trial = command.v0 != 0;
  if (trial && !(command.v0 >= contract::kTrial_s_min && command.v0 <= contract::kTrial_s_max)) return refused(Refusal::out_of_range);
  Verdict verdict = check_set(state, set, static_cast<contract::Role>(command.b), trial);
  if (!sealed(state, set, command.bits)) verdict.bits |= refusal_bit(Refusal::set_outdated);
  if (verdict.bits == 0) put_into_force(state, set, {command.request_id, command.client}, command.v0);
  return verdict;
}

Verdict end_trial(CoreState& state, const Command& command, bool keep) noexcept {
  std::uint32_t bits = 0;
  if (command.b != static_cast<std::uint32_t>(contract::Role::therapist) &&
      command.b != static_cast<std::uint32_t>(contract::Role::engineer))
    bits |= refusal_bit(Refusal::not_allowed);
  // Only values that the client has seen may be kept; reverting is always safe.
  if (keep && command.a != 0 && command.a != static_cast<std::uint32_t>(state.parameter_version))
    bits |= refusal_bit(Refusal::set_outdated);
  if (bits != 0) return {bits, 0, false};
  const Asked asked{command.request_id, command.client};
  return (keep ? confirm_trial(state, asked) : revert_trial(state, asked)) ? Verdict{} : refused(Refusal::out_of_order);
}

// The date comes from outside, because the core knows no calendar; 0 would mean never. False: it is no date.
[[nodiscard]] bool add_date(Staging& set, contract::ParamName date, double utc_s) noexcept {
  const std::size_t row = contract::param_index(date);
  return contract::check_param(row, utc_s) == contract::ParamCheck::ok && utc_s > 0 && set.rows.push_back({row, utc_s});
}

Verdict set_neutral(CoreState& state, const Command& command) noexcept {
  if (!standing(state)) return refused(at_rest(state) ? Refusal::only_when_stopped : Refusal::moving);
  const auto posture = state.intent.last_second();
  if (!posture.complete) return refused(Refusal::sensors_settling);
  std::uint32_t bits = 0;
  if (posture.dx_spread_m > kNeutralSpread_m) bits |= refusal_bit(Refusal::moving);
  constexpr std::size_t kLean = contract::param_index(contract::ParamName::neutral_lean_m);
  constexpr std::size_t kTurn = contract::param_index(contract::ParamName::neutral_turn_rad);
  // The range of the parameter is the bound on a neutral posture: 0.10 m.
  if (contract::check_param(kLean, posture.dx_m) != contract::ParamCheck::ok ||
      contract::check_param(kTurn, posture.dpsi_rad) != contract::ParamCheck::ok)
    bits |= refusal_bit(Refusal::out_of_range);
  if (bits != 0) return {bits, contract::kParams[kLean].id, false};
  Staging set;
  static_cast<void>(set.rows.push_back({kLean, posture.dx_m}));
  static_cast<void>(set.rows.push_back({kTurn, posture.dpsi_rad}));
  if (!add_date(set, contract::ParamName::calibrated_neutral_s, command.v0)) return refused(Refusal::out_of_range);
  put_into_force(state, set, {command.request_id, command.client}, 0);
  Event event;
  event.kind = EventKind::neutral_set;
  event.request_id = command.request_id;
  event.client = command.client;
  event.value = posture.dx_m;
  emit(state, event);
  return {};
}

// ----- pose, lease, modes -----

Verdict set_pose(CoreState& state, const Command& command) noexcept {
  if (!std::isfinite(command.v0) || !std::isfinite(command.v1) || !std::isfinite(command.v2)) return refused(Refusal::not_finite);
  if (std::fabs(command.v0) > kPoseLargest_m || std::fabs(command.v1) > kPoseLargest_m || std::fabs(command.v2) > kPoseLargest_rad)
    return refused(Refusal::out_of_range);
  if (!at_rest(state)) return refused(Refusal::moving);
  // The start mark is not moved during a walk, and an exercise stays where it began, also while hold-to-run is released.
  if (state.mode != Mode::standby && state.mode != Mode::calibrate) return refused(Refusal::not_standby);
  // The exercise of this mark goes on: pose and way stay.
  if (command.a != 0 && command.a == state.start.exercise && command.b != contract::kStartAgain) return {};
  ++state.start.number;
  state.start.exercise = command.a;
  state.sensed.odometry.pose = {command.v0, command.v1, command.v2};
  state.sensed.odometry.distance_m = 0;
  state.sensed.fused.set_pose(state.sensed.odometry.pose);
  Event event;
  event.kind = EventKind::pose_set;
  event.code = state.start.number;
  event.request_id = command.request_id;
  event.client = command.client;
  emit(state, event);
  return {};
}

Verdict take_lease(CoreState& state, const Command& command) noexcept {
  // The server itself never drives.
  if (command.client == 0) return refused(Refusal::no_lease);
  const std::uint32_t holder = state.lease.holder;
  // A hand-over names the epoch of the lease: it is void when another client, or none, holds it by now.
  const bool handed_over = command.a == contract::kHandOver;
  if (handed_over && (holder == 0 || command.lease_epoch != state.lease.epoch)) return refused(Refusal::no_lease);
  if (holder != 0 && holder != command.client) {
    if (command.a != contract::kTakeOver && !handed_over) return refused(Refusal::no_lease);
    if (!at_rest(state)) return refused(Refusal::moving);
  }
  give_lease(state, command.client);
  return {};
}

Verdict release_lease(CoreState& state, const Command& command) noexcept {
  const std::uint32_t holder = state.lease.holder;
  // The server releases for a client that is gone and names it in `a`; 0 means the present holder.
  const bool by_server = command.client == 0 && (command.a == 0 || command.a == holder);
  if (holder == 0 || (!by_server && command.client != holder)) return refused(Refusal::no_lease);
  // H21: its console vanished, and is missed while the hoist is led.
  if (command.client == 0 || command.a == contract::kConsoleGone) state.console.left(is_moving(state.mode));
  give_lease(state, 0);
  return {};
}

Verdict ask_mode(CoreState& state, const Command& command) noexcept {
  if (command.a >= contract::kModes.size()) return refused(Refusal::unknown_item);
  const auto to = static_cast<Mode>(command.a);
  // Anyone may end a motion, gently, as anyone may stop it at once. Everything else is the lease holder's.
  const bool ends = to == Mode::standby && is_moving(state.mode);
  const bool holds = state.lease.held_by(command.client, command.lease_epoch);
  // All reasons at once: a client without the lease also learns what else is in the way.
  if (!holds && !ends) {
    const bool start = to == Mode::user || to == Mode::remote || to == Mode::guided;
    return {refusal_bit(Refusal::no_lease) | (start ? start_refusals(state) : 0U), 0, false};
  }
  return {request_mode(state, to), 0, false};
}

Verdict begin_guided(CoreState& state, const Command& command) noexcept {
  const contract::GuidedPath path = contract::guided_of(command);
  const contract::GuidedProblems problems = contract::check_guided(path, contract::guided_limits(state.params));
  const bool holds = state.lease.held_by(command.client, command.lease_epoch);
  Verdict verdict;
  for (std::size_t i = 0; i < problems.count; ++i) {
    verdict.bits |= refusal_bit(Refusal::exercise_limits);
    verdict.bits |= refusal_bit(problems.rows[i].finite ? Refusal::out_of_range : Refusal::not_finite);
    if (i == 0) verdict.item = static_cast<std::uint32_t>(problems.rows[i].field);
  }
  // All reasons at once, also those that have nothing to do with the figure.
  if (!holds) verdict.bits |= refusal_bit(Refusal::no_lease);
  const bool elsewhere = find_transition(state.mode, Mode::guided, Asker::driver) == nullptr;
  verdict.bits |=
      (elsewhere ? request_mode(state, Mode::guided) : start_refusals(state, Mode::guided)) & ~refusal_bit(Refusal::no_exercise);
  if (verdict.bits != 0) return verdict;
  if (state.guided.continues(path, state.start.number)) {
    state.guided.go_on(path);
  } else {
    state.guided.load(path);
  }
  verdict.bits = request_mode(state, Mode::guided);
  if (verdict.bits != 0) state.guided.unload();
  return verdict;
}

Verdict ask_acknowledge(CoreState& state, const Command& command) noexcept {
  if (!state.lease.held_by(command.client, command.lease_epoch)) return refused(Refusal::no_lease);
  if (state.acknowledgement.waits()) return refused(Refusal::out_of_order);
  if (command.b > static_cast<std::uint32_t>(contract::Role::engineer)) return refused(Refusal::not_allowed);
  const Press press{command.request_id, command.client, static_cast<contract::Role>(command.b), command.bits};
  const std::uint32_t bits = press_release(state, press);
  return {bits, 0, state.acknowledgement.waits()};
}

// ----- alarms -----

/// Pauses the sound of the alarms in force (a = 1), or ends the pause. Needs no lease: the therapist beside the hoist may not be the one in control.
Verdict pause_alarm(CoreState& state, const Command& command) noexcept {
  if (command.b != static_cast<std::uint32_t>(contract::Role::therapist) &&
      command.b != static_cast<std::uint32_t>(contract::Role::engineer))
    return refused(Refusal::not_allowed);
  if (command.a > 1) return refused(Refusal::out_of_range);
  if (!(command.a == 1 ? state.alarm.pause(state.latched) : state.alarm.resume())) return refused(Refusal::out_of_order);
  Event event;
  event.kind = EventKind::alarm_paused;
  event.code = command.a;
  event.value = state.alarm.pause_s();
  event.request_id = command.request_id;
  event.client = command.client;
  emit(state, event);
  return {};
}

// ----- service -----

Verdict ask_service(CoreState& state, const Command& command) noexcept {
  std::uint32_t bits = 0;
  if (command.b != static_cast<std::uint32_t>(contract::Role::engineer)) bits |= refusal_bit(Refusal::not_allowed);
  if (!state.lease.held_by(command.client, command.lease_epoch)) bits |= refusal_bit(Refusal::no_lease);
  return {bits != 0 ? bits : begin_service(state), 0, false};
}

Verdict service_frame(CoreState& state, const Command& command) noexcept {
  if (!state.lease.held_by(command.client, command.lease_epoch)) return refused(Refusal::no_lease);
  Service& service = state.in_mode.service;
  // One a step: a tool that sends more is not waiting for the answers.
  if (!service.on || service.waiting) return refused(Refusal::out_of_order);
  if (!(command.v1 >= 0.0 && command.v1 <= 8.0) || command.v1 != std::floor(command.v1)) return refused(Refusal::out_of_range);
  contract::CanFrame frame{command.a, static_cast<std::uint8_t>(command.v1), 0, {}};
  frame.data = std::bit_cast<decltype(frame.data)>(command.v0);
  if (!SafetyGate::is_service_frame(frame)) return refused(Refusal::out_of_range);
  service.frame = frame;
  service.waiting = true;
  service.quiet_ticks = 0;
  return {};
}

Verdict end_service(CoreState& state, const Command& command) noexcept {
  if (!state.lease.held_by(command.client, command.lease_epoch)) return refused(Refusal::no_lease);
  if (!state.in_mode.service.on) return refused(Refusal::out_of_order);
  state.in_mode.service = {};
  return {};
}

// ----- calibration -----

Verdict ask_calibration(CoreState& state, const Command& command) noexcept {
  const contract::CalibrationStepInfo* info = contract::find_calibration_step(command.a);
  if (info == nullptr) return refused(Refusal::unknown_item);
  std::uint32_t bits = 0;
  if (command.b > static_cast<std::uint32_t>(contract::Role::engineer) || command.b < static_cast<std::uint32_t>(info->role))
    bits |= refusal_bit(Refusal::not_allowed);
  if (!state.lease.held_by(command.client, command.lease_epoch)) bits |= refusal_bit(Refusal::no_lease);
  // No sensor tells a motionless patient from an empty harness: the operator has to (DECISIONS 110).
  if (info->empty_harness && command.v0 != 1.0) bits |= refusal_bit(Refusal::harness_unconfirmed);
  // All reasons at once; with one of them nothing begins.
  return {bits != 0 ? bits | calibration_refusals(state, *info) : enter_calibration(state, *info), 0, false};
}

// Common to all steps after the first: the mode is CALIBRATE, and the client that began it asks.
std::uint32_t calibration_lead(const CoreState& state, const Command& command) noexcept {
  if (!state.lease.held_by(command.client, command.lease_epoch)) return refusal_bit(Refusal::no_lease);
  return state.mode == Mode::calibrate ? 0U : refusal_bit(Refusal::out_of_order);
}

Verdict use_calibration(CoreState& state, const Command& command) noexcept {
  if (const std::uint32_t bits = calibration_lead(state, command); bits != 0) return {bits, 0, false};
  const Calibration& calibration = state.in_mode.calibration;
  if (calibration.phase != contract::CalibrationPhase::result) return refused(Refusal::out_of_order);
  if (!at_rest(state)) return refused(Refusal::moving);
  const contract::CalibrationStepInfo& info = *contract::find_calibration_step(static_cast<std::uint32_t>(calibration.step));
  Staging set = calibration.result;
  if (!add_date(set, info.date, command.v0)) return refused(Refusal::out_of_range);
  // The step takes the neutral posture back, so its date is no longer true.
  if (info.step == contract::CalibrationStep::zero)
    static_cast<void>(set.rows.push_back({contract::param_index(contract::ParamName::calibrated_neutral_s), 0.0}));
  sign_parts(state, set);
  put_into_force(state, set, {command.request_id, command.client}, 0);
  leave_calibration(state, true);
  return {};
}

Verdict cancel_calibration(CoreState& state, const Command& command) noexcept {
  if (const std::uint32_t bits = calibration_lead(state, command); bits != 0) return {bits, 0, false};
  leave_calibration(state, false);
  return {};
}

Verdict take_measurement(CoreState& state, const Command& command) noexcept {
  const std::uint32_t bits = calibration_lead(state, command);
  return {bits != 0 ? bits : measure_calibration(state, command), 0, false};
}

Verdict execute(CoreState& state, const Command& command) noexcept {
  switch (command.kind) {
    case CommandKind::stop:
      raise_fault(state, Fault::stop_pressed);
      return {};
    case CommandKind::request_mode:
      return ask_mode(state, command);
    case CommandKind::acknowledge:
      return ask_acknowledge(state, command);
    case CommandKind::take_lease:
      return take_lease(state, command);
    case CommandKind::release_lease:
      return release_lease(state, command);
    case CommandKind::stage_parameter:
      return stage(state, command);
    case CommandKind::commit_parameters:
      return commit(state, command);
    case CommandKind::confirm_parameters:
      return end_trial(state, command, true);
    case CommandKind::revert_parameters:
      return end_trial(state, command, false);
    case CommandKind::set_pose:
      return set_pose(state, command);
    case CommandKind::set_neutral:
      return set_neutral(state, command);
    case CommandKind::begin_service:
      return ask_service(state, command);
    case CommandKind::service_frame:
      return service_frame(state, command);
    case CommandKind::end_service:
      return end_service(state, command);
    case CommandKind::begin_calibration:
      return ask_calibration(state, command);
    case CommandKind::measure_calibration:
      return take_measurement(state, command);
    case CommandKind::use_calibration:
      return use_calibration(state, command);
    case CommandKind::cancel_calibration:
      return cancel_calibration(state, command);
    case CommandKind::begin_guided:
      return begin_guided(state, command);
    case CommandKind::pause_alarm:
      return pause_alarm(state, command);
    case CommandKind::none:
      break;
  }
  return refused(Refusal::unknown_item);
}

void answer(CoreState& state, const Command& command, const Verdict& verdict) noexcept {
  if (verdict.later) return;
  Event event;
  event.request_id = command.request_id;
  event.client = command.client;
  event.item = verdict.item;
  if (verdict.bits == 0) {
    event.kind = EventKind::command_done;
  } else {
    event.kind = EventKind::command_refused;
    event.code = static_cast<std::uint32_t>(std::countr_zero(verdict.bits));
    event.bits = verdict.bits;
    ++state.commands_refused;
  }
  emit(state, event);
}

// Taken in any order: they can only end a motion. After a lost server the first command sets the count to any value; a wrong number there must not
// let the patient walk on.
bool only_stops(const Command& command) noexcept {
  return command.kind == CommandKind::stop ||
         (command.kind == CommandKind::request_mode && command.a == static_cast<std::uint32_t>(Mode::standby));
}

// H17: on its way for longer than what its sender had seen may be old. Who asked for it may be gone.
bool is_late(const CoreState& state, const Command& command) noexcept {
  const std::uint64_t echo = contract::echo_of(command);
  return echo != 0 && !only_stops(command) && !contract::is_fresh_echo(echo, state.time_ns, contract::kEchoAge_s_max);
}

// A driver who leaves ends a led motion, too; but an old release would take the lease from its next holder, so it keeps its order.
bool may_be_busy(const Command& command) noexcept { return !only_stops(command) && command.kind != CommandKind::release_lease; }

// True when the command comes in its order. After a gap (the ring was overwritten) the order continues from the newest number. An old number never
// moves the count back, so no command can be replayed.
bool count_sequence(CoreState& state, const Command& command) noexcept {
  const bool in_order = state.next_sequence == 0 || command.sequence == state.next_sequence;
  if (in_order || command.sequence > state.next_sequence) state.next_sequence = command.sequence + 1;
  return in_order;
}

// `left`: how many commands come after it in this step, each of which has an answer.
void take_command(CoreState& state, const Command& command, std::size_t left) noexcept {
  const bool in_order = count_sequence(state, command);
  if (!in_order && !only_stops(command)) {
    answer(state, command, refused(Refusal::out_of_order));
  } else if (is_late(state, command)) {
    answer(state, command, refused(Refusal::stale_command));
  } else if (may_be_busy(command) && state.events.room() < kEventsOfCommandMost + left + kEventsAfterCommands) {
    answer(state, command, refused(Refusal::busy));
  } else {
    answer(state, command, execute(state, command));
  }
}

}  // namespace

void take_commands(CoreState& state, std::span<const Command> commands) noexcept {
  for (std::size_t i = 0; i < commands.size(); ++i) {
    // Copied once, because another program can write there: the checked values are the used ones.
    const Command command = commands[i];
    if (i < kCommandsPerTick) {
      take_command(state, command, std::min(commands.size(), kCommandsPerTick) - i - 1);
      continue;
    }
    static_cast<void>(count_sequence(state, command));
    if (only_stops(command)) static_cast<void>(execute(state, command));
    ++state.commands_refused;
  }
}

void take_drive_command(CoreState& state, const contract::DriveCommand& command) noexcept {
  if (!state.remote.take(command, state.lease, state.time_ns, state.params.remote_stop_age_s)) ++state.commands_refused;
}

void watch_server(CoreState& state, std::uint64_t heartbeat, std::uint64_t life) noexcept {
  if (state.server.update(heartbeat, life) == ServerWatch::News::none) return;
  // The server is gone or is a new one: its clients no longer drive, and its numbers start again.
  if (state.lease.holder != 0) state.console.left(is_moving(state.mode));
  give_lease(state, 0);
  state.staging.rows.clear();
  state.next_sequence = 0;
}

}  // namespace hoist::core
