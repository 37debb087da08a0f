#include "server/actions/actions.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "control/contract/calibration.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/param_set.hpp"
#include "control/contract/params.hpp"
#include "db/store/session_reader.hpp"
#include "server/record/reason.hpp"

namespace hoist::server {

using contract::Command;
using contract::CommandKind;
using nlohmann::json;

namespace {
Command command_of(CommandKind kind, const Asker& asker) {
  Command command;
  command.kind = kind;
  command.client = asker.client;
  command.lease_epoch = asker.epoch;
  return command;
}

Outcome outcome_of(const CoreAnswer& answer) {
  Outcome outcome;
  switch (answer.kind) {
    case CoreAnswer::Kind::done:
      outcome.stored = answer.stored;
      return outcome;
    case CoreAnswer::Kind::refused: {
      outcome.kind = Outcome::Kind::refused;
      outcome.refusals = refusal_names(answer.bits);
      for (const contract::RefusalInfo& r : contract::kRefusals)
        if (r.bit == answer.code) outcome.detail = r.text_en;
      constexpr std::uint32_t kBadValue = contract::refusal_bit(contract::Refusal::out_of_range) |
                                          contract::refusal_bit(contract::Refusal::not_finite) |
                                          contract::refusal_bit(contract::Refusal::inconsistent_set);
      if ((answer.bits & kBadValue) != 0) outcome.kind = Outcome::Kind::invalid;
      return outcome;
    }
    case CoreAnswer::Kind::unanswered:
      outcome.detail = "The core does not answer.";
      break;
    case CoreAnswer::Kind::no_core:
      outcome.detail = "The control core is not connected.";
      break;
    case CoreAnswer::Kind::busy:
      outcome.detail = "The control core has not taken the last commands yet.";
      outcome.reason = Reason::busy;
      break;
  }
  outcome.kind = Outcome::Kind::unreachable;
  return outcome;
}

Outcome invalid(std::vector<FieldError> errors, std::string detail, std::optional<Reason> reason = {}) {
  Outcome outcome;
  outcome.reason = reason;
  outcome.kind = Outcome::Kind::invalid;
  outcome.errors = std::move(errors);
  outcome.detail = std::move(detail);
  return outcome;
}

// The one place that enforces roles, for every protocol. A protocol's own table (api.def, messages.def) describes the role and refuses early.
// False: `done` has been told.
bool may(Services& services, const Asker& asker, contract::Role least, const OutcomeDone& done) {
  if (asker.role >= least) return true;
  services.counters.add(Count::commands_refused);
  Outcome outcome;
  outcome.kind = Outcome::Kind::refused;
  outcome.detail = "Your role may not do this.";
  outcome.reason = Reason::role;
  outcome.refusals = refusal_names(contract::refusal_bit(contract::Refusal::not_allowed));
  done(outcome);
  return false;
}

void ask(Services& services, const Command& command, OutcomeDone done) {
  services.core.ask(command, [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); });
}

FieldError range_error(const contract::ParamInfo& p, std::string message, std::optional<double> value) {
  return {std::string{p.name}, std::move(message), value, p.min, p.max};
}

void set_values(Services& services, const Asker& asker, std::vector<std::pair<std::uint32_t, double>> rows, double revert_after_s,
                std::uint32_t version, OutcomeDone done) {
  Command commit = command_of(CommandKind::commit_parameters, asker);
  commit.v0 = revert_after_s;
  commit.b = static_cast<std::uint32_t>(asker.role);
  services.core.ask_parameters(rows, version, commit, [done = std::move(done), rows](const CoreAnswer& answer) {
    Outcome outcome = outcome_of(answer);
    if (answer.kind == CoreAnswer::Kind::refused) {
      // Name the row. A set that contradicts itself has no single row: the sentence tells.
      if (const auto index = contract::find_param_id(answer.item)) {
        std::optional<double> value;
        for (const auto& [id, v] : rows)
          if (id == answer.item) value = v;
        outcome.errors.push_back(range_error(contract::kParams[*index], outcome.detail, value));
      }
    }
    done(outcome);
  });
}
}  // namespace

Reason reason_of(const Outcome& outcome) {
  if (outcome.reason) return *outcome.reason;
  switch (outcome.kind) {
    case Outcome::Kind::invalid:
      return Reason::invalid;
    case Outcome::Kind::unknown:
      return Reason::unknown;
    case Outcome::Kind::unreachable:
      return Reason::no_core;
    default:
      return Reason::refused;
  }
}

std::vector<std::string> refusal_names(std::uint32_t bits) {
  std::vector<std::string> names;
  for (const contract::RefusalInfo& r : contract::kRefusals)
    if ((bits >> r.bit & 1U) != 0) names.emplace_back(r.name);
  return names;
}

void act_take_lease(Services& services, const Asker& asker, bool take_over, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  Command command = command_of(CommandKind::take_lease, asker);
  command.a = take_over ? 1 : 0;
  services.core.ask(command, [done = std::move(done), take_over, &services](const CoreAnswer& answer) {
    Outcome outcome = outcome_of(answer);
    // The table's sentence tells others to take control, which is what was asked here.
    if (!take_over && (answer.bits & contract::refusal_bit(contract::Refusal::no_lease)) != 0)
      outcome.detail = "Somebody else is in control: ask again with take_over while the hoist stands still.";
    outcome.epoch = services.core.lease_epoch();
    done(outcome);
  });
}

void act_release_lease(Services& services, const Asker& asker, OutcomeDone done) {
  ask(services, command_of(CommandKind::release_lease, asker), std::move(done));
}

namespace {
bool holds_lease(const Services& services, const Asker& asker) { return asker.client != 0 && services.core.lease_holder() == asker.client; }

bool is_share(const std::optional<double>& value) { return value && std::fabs(*value) <= 1.0; }

std::optional<contract::Refusal> pass_on(Services& services, const Asker& asker, const DriveWish& wish, std::uint64_t& last_sequence) {
  using contract::Refusal;
  if (!wish.sequence || !wish.echo_time_ns || !is_share(wish.speed_norm) || !is_share(wish.yaw_norm) || !wish.held)
    return Refusal::out_of_range;
  if (asker.role < contract::Role::therapist) return Refusal::not_allowed;
  if (!holds_lease(services, asker)) return Refusal::no_lease;
  if (*wish.sequence <= last_sequence) return Refusal::out_of_order;
  const contract::DriveCommand command{.lease_epoch = services.core.lease_epoch(),
                                       .client = asker.client,
                                       .sequence = *wish.sequence,
                                       .echo_time_ns = *wish.echo_time_ns,
                                       .speed_norm = *wish.speed_norm,
                                       .yaw_norm = *wish.yaw_norm,
                                       .held = *wish.held ? 1U : 0U};
  if (!services.core.drive(command)) return Refusal::stale_command;
  last_sequence = command.sequence;
  return std::nullopt;
}
}  // namespace

std::optional<contract::Refusal> act_drive(Services& services, const Asker& asker, const DriveWish& wish, std::uint64_t& last_sequence) {
  const std::optional<contract::Refusal> refused = pass_on(services, asker, wish, last_sequence);
  if (refused && wish.held == false && holds_lease(services, asker)) {
    // With the next free number, since the core takes only those that rise.
    const contract::DriveCommand let_go{.lease_epoch = services.core.lease_epoch(),
                                        .client = asker.client,
                                        .sequence = last_sequence + 1,
                                        .echo_time_ns = wish.echo_time_ns.value_or(0)};
    if (services.core.drive(let_go)) last_sequence = let_go.sequence;
  }
  return refused;
}

void act_stop(Services& services, std::uint32_t client, OutcomeDone done) {
  CoreDesk::Done answered;
  if (done) answered = [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); };
  services.core.stop(client, std::move(answered));
}

void act_acknowledge(Services& services, const Asker& asker, const json& seen, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  Command command = command_of(CommandKind::acknowledge, asker);
  bool usable = seen.is_null() || (seen.is_array() && !seen.empty());
  if (seen.is_array())
    for (const json& name : seen) {
      const contract::FaultInfo* fault = name.is_string() ? contract::find_fault(name.get_ref<const std::string&>()) : nullptr;
      usable = usable && fault != nullptr;
      if (fault != nullptr) command.bits |= contract::fault_bit(*fault);
    }
  if (!usable) {
    done(invalid({{"seen", "must name at least one fault, and only faults of the table"}}, "There is no such fault to acknowledge."));
    return;
  }
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

void act_neutral(Services& services, const Asker& asker, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  ask(services, command_of(CommandKind::set_neutral, asker), std::move(done));
}

void act_calibrate(Services& services, const Asker& asker, const json& wish, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  const auto step = wish.find("step");
  const contract::CalibrationStepInfo* info = step != wish.end() && step->is_string()
                                                  ? contract::find_calibration_step(std::string_view{step->get_ref<const std::string&>()})
                                                  : nullptr;
  if (info == nullptr) {
    done(invalid({{"step", "must be a step of the calibration table"}}, "There is no such calibration step."));
    return;
  }
  const auto empty = wish.find("harness_empty");
  if (empty != wish.end() && !empty->is_boolean()) {
    done(invalid({{"harness_empty", "must be true or false"}}, "There is no such confirmation."));
    return;
  }
  Command command = command_of(CommandKind::begin_calibration, asker);
  command.a = static_cast<std::uint32_t>(info->step);
  command.b = static_cast<std::uint32_t>(asker.role);
  command.v0 = empty != wish.end() && empty->get<bool>() ? 1.0 : 0.0;
  services.core.ask(command, [done = std::move(done)](const CoreAnswer& answer) {
    Outcome outcome = outcome_of(answer);
    if ((answer.bits & contract::refusal_bit(contract::Refusal::harness_unconfirmed)) != 0)
      outcome.errors.push_back({"harness_empty", "must be true: nobody is strapped in"});
    done(outcome);
  });
}

void act_measure(Services& services, const Asker& asker, const json& measured, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  // Wider than any step allows; the core knows the range of the step under way.
  constexpr double kFigure = 1000.0;
  Command command = command_of(CommandKind::measure_calibration, asker);
  std::vector<FieldError> errors;
  const auto read = [&](const char* name, bool required, double& out) {
    const auto at = measured.find(name);
    if (at == measured.end() && !required) return;
    if (at == measured.end() || !at->is_number() || !(std::fabs(at->get<double>()) <= kFigure))
      errors.push_back({name, "must be a number", {}, -kFigure, kFigure});
    else
      out = at->get<double>();
  };
  const auto turning = measured.find("turning");
  const bool square = turning != measured.end();
  read("figure", true, command.v0);
  read("x_m", square, command.v1);
  read("y_m", square, command.v2);
  if (square) {
    const bool left = *turning == "left";
    if (!left && *turning != "right") errors.push_back({"turning", "must be left or right"});
    command.a = static_cast<std::uint32_t>(left ? contract::CalibrationPart::left_square : contract::CalibrationPart::right_square);
  }
  if (!errors.empty()) {
    done(invalid(std::move(errors), "The measurement cannot be used.", Reason::measurement));
    return;
  }
  // The step under way names its range when the figure lies outside.
  const std::uint32_t step = services.core.newest() ? services.core.newest()->calibration_step : 0U;
  services.core.ask(command,
                    [done = std::move(done), info = contract::find_calibration_step(step), figure = command.v0](const CoreAnswer& answer) {
                      Outcome outcome = outcome_of(answer);
                      if ((answer.bits & contract::refusal_bit(contract::Refusal::out_of_range)) != 0 && info != nullptr)
                        outcome.errors.push_back({"figure", "its size is outside the range of this step", figure, info->least, info->most});
                      done(outcome);
                    });
}

void act_use_calibration(Services& services, const Asker& asker, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  Command command = command_of(CommandKind::use_calibration, asker);
  // Whole seconds: a day is all that anybody looks at.
  const auto utc_s = services.utc_ns() / 1'000'000'000;
  command.v0 = static_cast<double>(utc_s);
  ask(services, command, std::move(done));
}

void act_cancel_calibration(Services& services, const Asker& asker, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  ask(services, command_of(CommandKind::cancel_calibration, asker), std::move(done));
}

namespace {
// The limits of exercises by the parameters in force; nothing fits before they are known.
contract::GuidedLimits guided_limits(const Services& services) {
  if (!services.core.has_parameters()) return {};
  contract::Params params;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) contract::set_param_unchecked(params, i, services.core.parameters().values[i]);
  return contract::guided_limits(params);
}

// Tells one exercise from another: whose lead, which way, how many laps. Never 0.
std::uint32_t exercise_key(contract::Mode mode, const Exercise& exercise, std::uint32_t laps) {
  const std::uint64_t hash = contract::hash_number(contract::hash_bytes(contract::kHashStart, exercise_json(exercise).dump()),
                                                   laps * contract::kModes.size() + static_cast<std::uint64_t>(mode));
  const auto key = static_cast<std::uint32_t>(hash ^ (hash >> 32U));
  return key == 0 ? 1 : key;
}

std::uint32_t blocked_bits(const Services& services) { return services.core.newest() ? services.core.newest()->blocked_bits : 0; }

// What the newest step says against a start in this mode, so that a refused one changes nothing. Whether the asker holds the lease is judged
// by itself, and driving may leave a bumper: only the core knows which one was acknowledged.
std::uint32_t start_refusals(const Services& services, contract::Mode mode) {
  const auto& newest = services.core.newest();
  if (!newest) return 0;
  std::uint32_t bits = newest->blocked_bits & ~contract::refusal_bit(contract::Refusal::no_lease);
  if (mode == contract::Mode::remote) bits &= ~contract::refusal_bit(contract::Refusal::bumper_start);
  if (newest->mode != static_cast<std::uint8_t>(contract::Mode::standby)) bits |= contract::refusal_bit(contract::Refusal::not_standby);
  // An exercise asks besides that hold-to-run is pressed for it; the core's rule with the core's limit.
  const double stop_age_s = services.core.parameters().values[contract::param_index(contract::ParamName::remote_stop_age_s)];
  if (mode == contract::Mode::guided && services.core.hand_holds(static_cast<std::uint64_t>(stop_age_s * 1e9)))
    bits |= contract::refusal_bit(contract::Refusal::release_first);
  return bits;
}

// Asks for a motion. What it begins with goes into the recording, and to every screen when it has begun.
void begin_motion(Services& services, const Command& request, const Exercise& exercise, json told, OutcomeDone done) {
  services.recorder.set_exercise(stored_exercise(exercise));
  ask(services, request, [&services, told = std::move(told), done = std::move(done)](const Outcome& outcome) {
    if (outcome.done()) services.state.motion_begins(told);
    done(outcome);
  });
}
}  // namespace

void act_mode(Services& services, const Asker& asker, const ModeWish& wish, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  std::optional<contract::Mode> mode;
  if (wish.mode.is_string())
    for (contract::Mode m : {contract::Mode::standby, contract::Mode::user, contract::Mode::remote, contract::Mode::guided})
      if (contract::kModes[static_cast<std::size_t>(m)].name == wish.mode.get_ref<const std::string&>()) mode = m;
  if (!mode) {
    done(invalid({{"mode", "must be user, remote, guided or standby"}}, "There is no such mode to ask for."));
    return;
  }
  Command request = command_of(CommandKind::request_mode, asker);
  request.a = static_cast<std::uint32_t>(*mode);
  if (*mode == contract::Mode::standby) {
    // Before anything else is looked at: ending motion is never refused for the form of what does not matter to it.
    ++services.ends_asked;
    ask(services, request, std::move(done));
    return;
  }
  if (*mode == contract::Mode::guided && !services.core.has_parameters()) {
    // Without the parameters in force there are no limits to hold the exercise against.
    done(outcome_of({.kind = CoreAnswer::Kind::no_core}));
    return;
  }
  std::vector<FieldError> errors;
  auto exercise = read_exercise(wish.exercise, errors);
  std::uint32_t laps = 0;
  if (!wish.start_again.is_null() && !wish.start_again.is_boolean()) errors.push_back({"start_again", "must be true or false"});
  if (*mode == contract::Mode::guided) {
    if (!wish.exercise.is_null()) errors.push_back({"exercise", "is the path itself; leave it out"});
    if (const auto path = read_guided(wish.path, guided_limits(services), errors)) {
      contract::put_guided(request, *path);
      exercise = *path;
      laps = path->laps;
    }
  } else if (!wish.path.is_null()) {
    errors.push_back({"path", "belongs to the mode guided only"});
  }
  if (!exercise || !errors.empty()) {
    Outcome outcome = invalid(std::move(errors), "The exercise cannot be used.", Reason::exercise);
    // Whoever wants to start is told everything that is in the way.
    if (*mode == contract::Mode::guided)
      outcome.refusals = refusal_names(blocked_bits(services) | contract::refusal_bit(contract::Refusal::exercise_limits));
    done(outcome);
    return;
  }
  if (asker.client == 0 || services.core.lease_holder() != asker.client || services.core.lease_epoch() != asker.epoch) {
    // Said here, so that somebody who may not start does not move the pose either; with everything else that is in the way.
    Outcome outcome;
    outcome.kind = services.core.connected() ? Outcome::Kind::refused : Outcome::Kind::unreachable;
    outcome.detail =
        services.core.connected() ? "Someone else is in control, or nobody is: take control first." : "The control core is not connected.";
    if (services.core.connected())
      outcome.refusals = refusal_names(blocked_bits(services) | contract::refusal_bit(contract::Refusal::no_lease));
    services.counters.add(Count::commands_refused);
    done(outcome);
    return;
  }
  if (!services.core.connected()) {
    done(outcome_of({.kind = CoreAnswer::Kind::no_core}));
    return;
  }
  if (const std::uint32_t bits = start_refusals(services, *mode); bits != 0) {
    services.counters.add(Count::commands_refused);
    done(outcome_of({.kind = CoreAnswer::Kind::refused, .code = static_cast<std::uint32_t>(std::countr_zero(bits)), .bits = bits}));
    return;
  }
  if (*mode == contract::Mode::remote && wish.exercise.is_null()) {
    // The hoist is only moved: the exercise stays where it lies on the floor.
    begin_motion(services, request, *exercise, exercise_json(*exercise), std::move(done));
    return;
  }
  // The pose first: the exercise's figure and the odometry must share their origin before the first step. The core keeps the pose when this
  // exercise goes on. Pose and exercise are set for a start that nothing is known to stand against; the core judges both once more and sets
  // no pose outside standby.
  const StartPose pose = start_pose(*exercise);
  const bool guided = *mode == contract::Mode::guided;
  Command set_pose = command_of(CommandKind::set_pose, asker);
  set_pose.v0 = pose.x_m;
  set_pose.v1 = pose.y_m;
  set_pose.v2 = pose.psi_rad;
  set_pose.a = exercise_key(*mode, *exercise, laps);
  set_pose.b = wish.start_again == true || services.start_anew ? contract::kStartAgain : 0;
  services.core.ask(set_pose, [&services, request, exercise = *exercise, told = guided ? wish.path : exercise_json(*exercise),
                               ends_asked = services.ends_asked, done = std::move(done)](const CoreAnswer& answer) mutable {
    if (!answer.done()) {
      Outcome outcome = outcome_of(answer);
      // Whoever wants to start is told everything that is in the way, not only what stopped the first step.
      if (answer.kind == CoreAnswer::Kind::refused && services.core.newest()) {
        outcome.kind = Outcome::Kind::refused;
        outcome.refusals = refusal_names(answer.bits | blocked_bits(services));
      }
      done(outcome);
      return;
    }
    // A request to end that came after the start must not be overtaken by it while the pose was being set.
    if (services.ends_asked != ends_asked) {
      services.counters.add(Count::commands_refused);
      Outcome outcome;
      outcome.kind = Outcome::Kind::refused;
      outcome.detail = "It was ended before it began.";
      outcome.refusals = refusal_names(contract::refusal_bit(contract::Refusal::out_of_order));
      done(outcome);
      return;
    }
    services.start_anew = false;
    begin_motion(services, request, exercise, std::move(told), std::move(done));
  });
}

void act_choose(Services& services, const Asker& asker, const json& exercise, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  std::vector<FieldError> errors;
  const auto chosen = read_exercise(exercise, errors);
  if (!chosen) {
    done(invalid(std::move(errors), "The exercise cannot be used.", Reason::exercise));
    return;
  }
  const auto& newest = services.core.newest();
  if (newest && newest->mode < contract::kModes.size() && contract::kModes[newest->mode].moving) {
    done(outcome_of({.kind = CoreAnswer::Kind::refused, .bits = contract::refusal_bit(contract::Refusal::not_standby)}));
    return;
  }
  services.state.choose(*chosen);
  done({});
}

void act_pose(Services& services, const Asker& asker, const json& pose, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  // Larger than any hall; further out the odometry's single precision would show.
  constexpr double kPlace_m = 1000.0, kHeading_rad = 1000.0;
  Command command = command_of(CommandKind::set_pose, asker);
  std::vector<FieldError> errors;
  const auto read = [&](const char* name, double limit, double& out) {
    const auto at = pose.find(name);
    if (at == pose.end() || !at->is_number()) {
      errors.push_back({name, "must be a number", {}, -limit, limit});
      return;
    }
    out = at->get<double>();
    if (!std::isfinite(out) || std::fabs(out) > limit) errors.push_back({name, "is outside its range", out, -limit, limit});
  };
  read("x_m", kPlace_m, command.v0);
  read("y_m", kPlace_m, command.v1);
  read("psi_rad", kHeading_rad, command.v2);
  if (!errors.empty()) {
    done(invalid(std::move(errors), "The pose cannot be used."));
    return;
  }
  ask(services, command, std::move(done));
}

std::optional<std::uint32_t> read_version(const json& version, std::vector<FieldError>& errors) {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (version.is_null()) return 0;
  if (version.is_number_unsigned() && version.get<std::uint64_t>() > 0 && version.get<std::uint64_t>() <= kMost)
    return version.get<std::uint32_t>();
  errors.push_back({"version", "must be the version of the parameters that was looked at", {}, 1.0, static_cast<double>(kMost)});
  return std::nullopt;
}

void act_keep_trial(Services& services, const Asker& asker, const json& version, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  std::vector<FieldError> errors;
  const auto looked_at = read_version(version, errors);
  if (!looked_at) {
    done(invalid(std::move(errors), "The version cannot be used; nothing was kept."));
    return;
  }
  Command command = command_of(CommandKind::confirm_parameters, asker);
  command.a = *looked_at;
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

void act_undo_trial(Services& services, const Asker& asker, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  Command command = command_of(CommandKind::revert_parameters, asker);
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

void act_set(Services& services, const Asker& asker, const json& values, const json& revert_after_s, std::uint32_t version,
             OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  if (!values.is_object() || values.empty()) {
    done(invalid({{"values", "must name at least one parameter"}}, "There is nothing to change."));
    return;
  }
  std::vector<std::pair<std::uint32_t, double>> rows;
  std::vector<FieldError> errors;
  bool unknown = false;
  bool role = false;
  bool no_number = false;
  double trial_s = 0;
  if (!revert_after_s.is_null()) {
    trial_s = revert_after_s.is_number() ? revert_after_s.get<double>() : 0.0;
    if (!(trial_s >= contract::kTrial_s_min && trial_s <= contract::kTrial_s_max))
      errors.push_back({"revert_after_s", "must be a number of seconds", std::nullopt, contract::kTrial_s_min, contract::kTrial_s_max});
  }
  for (const auto& [name, value] : values.items()) {
    const auto index = contract::find_param(name);
    if (!index) {
      unknown = true;
      errors.push_back({name, "There is no such parameter."});
      continue;
    }
    const contract::ParamInfo& p = contract::kParams[*index];
    if (!value.is_number()) {
      no_number = true;
      errors.push_back(range_error(p, "must be a number", std::nullopt));
      continue;
    }
    const double number = value.get<double>();
    if (contract::check_param(*index, number) != contract::ParamCheck::ok) {
      errors.push_back(range_error(p, "is outside its range", std::isfinite(number) ? std::optional{number} : std::nullopt));
      continue;
    }
    if (asker.role < p.role) {
      role = true;
      errors.push_back(range_error(p, "only an engineer may change this", number));
      continue;
    }
    if (trial_s > 0 && p.edit == contract::EditRule::stopped) {
      errors.push_back(range_error(p, "cannot be tried: it may not go back while the hoist moves", number));
      continue;
    }
    rows.emplace_back(p.id, number);
  }
  if (!errors.empty()) {
    Outcome outcome = invalid(std::move(errors), unknown     ? "There is no such parameter."
                                                 : role      ? "Your role may not change this."
                                                 : no_number ? "A value is not a number; nothing was changed."
                                                             : "A value is outside its range; nothing was changed.");
    if (unknown) outcome.kind = Outcome::Kind::unknown;
    if (role && !unknown) outcome.kind = Outcome::Kind::refused;
    outcome.refusals = {unknown ? "unknown_item" : role ? "not_allowed" : "out_of_range"};
    services.counters.add(Count::commands_refused);
    done(outcome);
    return;
  }
  set_values(services, asker, std::move(rows), trial_s, version, std::move(done));
}

void act_update_firmware(Services& services, const Asker& asker, std::vector<std::uint8_t> image, contract::Node node, bool force,
                         OutcomeDone done) {
  if (!may(services, asker, contract::Role::engineer, done)) return;
  Command command = command_of(CommandKind::begin_service, asker);
  command.b = static_cast<std::uint32_t>(asker.role);
  services.firmware.begin(std::move(image), node, force, command,
                          [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); });
}

void act_preset(Services& services, const Asker& asker, const std::string& name, std::uint32_t version, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  std::vector<std::pair<std::uint32_t, double>> rows;
  for (const contract::PresetValue& v : contract::kPresetValues)
    if (v.preset == name) rows.emplace_back(contract::kParams[contract::param_index(v.param)].id, v.value);
  if (rows.empty()) {
    Outcome outcome = invalid({{"name", "There is no such preset."}}, "There is no such preset.");
    outcome.kind = Outcome::Kind::unknown;
    outcome.refusals = {"unknown_item"};
    done(outcome);
    return;
  }
  set_values(services, asker, std::move(rows), 0, version, std::move(done));
}

namespace {
Outcome recorder_busy() {
  Outcome outcome;
  outcome.kind = Outcome::Kind::unreachable;
  outcome.reason = Reason::busy;
  outcome.detail = "The recorder is busy. Try again in a moment.";
  return outcome;
}

Outcome outcome_of(const db::Error& error) {
  Outcome outcome;
  outcome.detail = error.message;
  outcome.reason = reason_of(error.kind);
  switch (error.kind) {
    case db::ErrorKind::not_found:
      outcome.kind = Outcome::Kind::unknown;
      break;
    case db::ErrorKind::bad_value:
      outcome.kind = Outcome::Kind::invalid;
      outcome.errors.push_back({error.field, error.message});
      break;
    case db::ErrorKind::wrong_state:
      outcome.kind = Outcome::Kind::refused;
      break;
    default:
      outcome.kind = Outcome::Kind::unreachable;
      break;
  }
  return outcome;
}

// On the recorder's thread; `work` is given a database that is open.
using StoreWork = std::function<db::Status(Records&, db::Database&)>;
void ask_store(Services& services, StoreWork work, OutcomeDone done) {
  const auto run = [work = std::move(work)](Records& records) -> Outcome {
    if (records.late()) return recorder_busy();
    db::Database* database = records.database();
    if (database == nullptr) return outcome_of(db::Error{db::ErrorKind::io, records.why(), {}});
    const db::Status status = work(records, *database);
    // Told before the answer, so that the next question sees it.
    (void)records.status();
    return status ? Outcome{} : outcome_of(status.error());
  };
  if (!services.records.ask<Outcome>(run, done)) done(recorder_busy());
}
}  // namespace

void act_mark(Services& services, const Asker& asker, std::optional<db::SessionId> session, const json& text, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  if (!text.is_string() || text.get_ref<const std::string&>().size() > db::kMaxMarker_bytes) {
    constexpr auto kMost = static_cast<double>(db::kMaxMarker_bytes);
    done(invalid({{"text", "must be text of at most 500 bytes", std::nullopt, std::nullopt, kMost}}, "The marker cannot be used."));
    return;
  }
  const auto work = [session, words = text.get<std::string>(), actor = services.actors.find(asker.client)](
                        Records& records, db::Database& database) -> db::Status {
    if (session)
      if (const auto stored = db::SessionReader(database).get(*session); !stored) return stored.error();
    const auto now = records.status().session;
    if (!now || (session && *session != *now)) return db::Error{db::ErrorKind::wrong_state, "This session is not being recorded.", {}};
    return records.marker(*now, words, actor);
  };
  ask_store(services, work, [done = std::move(done)](Outcome outcome) {
    if (outcome.kind == Outcome::Kind::refused) outcome.reason = Reason::not_recording;
    done(outcome);
  });
}

void act_record(Services& services, const Asker& asker, RecordWish wish, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  const bool starts = wish.starts;
  const auto work = [wish = std::move(wish)](Records& records, db::Database&) {
    return wish.starts ? records.begin_manual(wish.subject, wish.note) : records.end_manual();
  };
  ask_store(services, work, [&services, starts, done = std::move(done)](const Outcome& outcome) {
    if (outcome.done() && starts) services.start_anew = true;
    done(outcome);
  });
}

namespace {
// Piece by piece: between two, the recorder stores what has come and others get their answers. The session is gone already; what cannot be
// overwritten now is at the next start.
void erase_deleted(Services& services, std::shared_ptr<void> held, OutcomeDone done) {
  const std::function<bool(Records&)> piece = [](Records& records) {
    db::Database* database = records.database();
    const auto more = database == nullptr ? db::Result<bool>(false) : db::SessionEditor(*database).erase_piece();
    return more && *more;
  };
  const std::function<void(bool)> then = [&services, held, done](bool more) {
    if (more)
      erase_deleted(services, held, done);
    else
      done({});
  };
  if (!services.records.ask<bool>(piece, then)) done({});
}
}  // namespace

void act_delete_session(Services& services, const Asker& asker, db::SessionId session, OutcomeDone done) {
  if (!may(services, asker, contract::Role::therapist, done)) return;
  const auto work = [session](Records&, db::Database& database) { return db::SessionEditor(database).take_out(session); };
  ask_store(services, work, [&services, held = services.jobs.hold(), done = std::move(done)](const Outcome& outcome) {
    if (outcome.done())
      erase_deleted(services, held, done);
    else
      done(outcome);
  });
}

void act_set_retention(Services& services, const Asker& asker, const db::Retention& wish, OutcomeDone done) {
  if (!may(services, asker, contract::Role::engineer, done)) return;
  ask_store(
      services, [wish](Records&, db::Database& database) { return db::set_retention(database, wish); }, std::move(done));
}

void act_start_job(Services& services, const Asker& asker, JobKind kind, JobArguments arguments, OutcomeDone done) {
  if (!may(services, asker, job_kind_info(kind).role, done)) return;
  Outcome outcome;
  if (const auto id = services.jobs.add(kind, std::move(arguments), services.actors.find(asker.client))) {
    outcome.job = *id;
  } else {
    outcome.kind = Outcome::Kind::unreachable;
    outcome.reason = Reason::busy;
    outcome.detail = "At most " + std::to_string(kJobsWaiting) + " jobs may wait: try again when one has ended.";
  }
  done(outcome);
}

void act_cancel_job(Services& services, const Asker& asker, JobId job, OutcomeDone done) {
  const auto info = services.jobs.find(job);
  if (!may(services, asker, info ? job_kind_info(info->kind).role : contract::Role::therapist, done)) return;
  Outcome outcome;
  outcome.job = job;
  if (!info) {
    outcome.kind = Outcome::Kind::unknown;
    outcome.detail = "GET /api/v1/jobs lists them.";
  } else if (!services.jobs.cancel(job)) {
    outcome.kind = Outcome::Kind::refused;
    outcome.reason = Reason::job_ended;
    outcome.detail = "This job has already ended.";
  }
  done(outcome);
}

}  // namespace hoist::server
