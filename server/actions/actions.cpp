#include "server/actions/actions.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <utility>

#include "control/contract/calibration.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/param_set.hpp"
#include "control/contract/params.hpp"
#include "db/store/deletion.hpp"
#include "db/store/session_reader.hpp"
#include "server/actions/common.hpp"
#include "server/record/reason.hpp"
#include "server/text/json_text.hpp"

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
  contract::put_echo(command, asker.echo_time_ns);
  return command;
}
// What the core stores with today's date. Whole seconds: a day is all that anybody looks at.
Command dated(const Services& services, CommandKind kind, const Asker& asker) {
  Command command = command_of(kind, asker);
  const auto utc_s = services.utc_ns() / 1'000'000'000;
  command.v0 = static_cast<double>(utc_s);
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
      if ((answer.bits & contract::refusal_bit(contract::Refusal::stale_command)) != 0)
        outcome.detail =
            "It may be at most 1 s old, counted from the newest step that its sender had seen or from the first byte of its request.";
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

// How the history of parameters tells what a command changes; those that set values tell it themselves.
ChangeOrigin origin_of(CommandKind kind) {
  switch (kind) {
    case CommandKind::revert_parameters:
      return {"undo"};
    case CommandKind::set_neutral:
      return {"neutral"};
    case CommandKind::use_calibration:
      return {"calibration"};
    default:
      return {};
  }
}

void ask(Services& services, const Command& command, OutcomeDone done) {
  const auto id = services.core.ask(command, [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); });
  services.history.expect(id, origin_of(command.kind));
}

FieldError range_error(const contract::ParamInfo& p, std::string message, std::optional<double> value) {
  return {std::string{p.name}, std::move(message), value, p.min, p.max};
}

}  // namespace

namespace {
// Of one text in the audit log.
constexpr std::size_t kAuditText_bytes = 500;

std::string result_of(const Outcome& outcome) {
  if (outcome.done()) return "done";
  if (!outcome.refusals.empty()) return outcome.refusals.front();
  return std::string{reason_name(reason_of(outcome))};
}

// The row of the audit log, without its result. Who asks is known by the number.
db::AuditEntry audit_entry(const Services& services, const Asker& asker, Action action, AuditDetails details) {
  const std::optional<KnownClient> client = services.actors.known(asker.client);
  const db::Actor actor = client ? client->actor : db::Actor{};
  for (auto* text : {&details.before, &details.after})
    if (*text) (*text)->resize(std::min((*text)->size(), kAuditText_bytes));
  return {.utc_ms = services.utc_ns() / 1'000'000,
          .steady_ns = services.now_ns(),
          .user = actor.user,
          .role = actor.role,
          .address = client ? client->address : std::string{},
          .action = std::string{kActions[static_cast<std::size_t>(action)].name},
          .target = actor.origin + (details.target.empty() ? "" : " ") + details.target,
          .before = std::move(details.before),
          .after = std::move(details.after),
          .result = {}};
}

void log_action(Services& services, const Asker& asker, db::AuditEntry entry, std::string result) {
  services.rehearsals.did(asker.client, entry.action, result);
  entry.result = std::move(result);
  services.people.log(std::move(entry));
  if (asker.logged) *asker.logged = true;
}

void refuse_asker(Services& services, Reason reason, std::string detail, const OutcomeDone& done) {
  services.counters.add(Count::commands_refused);
  Outcome outcome;
  outcome.kind = Outcome::Kind::refused;
  outcome.detail = std::move(detail);
  outcome.reason = reason;
  if (reason == Reason::role) outcome.refusals = refusal_names(contract::refusal_bit(contract::Refusal::not_allowed));
  done(outcome);
}
}  // namespace

// The one place that enforces roles, for every protocol. A protocol's own table (api.def, messages.def) describes the role.
bool begin_action(Services& services, const Asker& asker, Action action, AuditDetails details, OutcomeDone& done) {
  const ActionInfo& info = kActions[static_cast<std::size_t>(action)];
  done = [&services, asker, entry = audit_entry(services, asker, action, std::move(details)),
          done = std::move(done)](const Outcome& outcome) {
    log_action(services, asker, entry, result_of(outcome));
    done(outcome);
  };
  if (asker.over && !info.ends) {
    refuse_asker(services, Reason::sign_in_over, "The sign-in has run out: sign in again.", done);
    return false;
  }
  return may(services, asker, info.role, done);
}

bool may(Services& services, const Asker& asker, contract::Role least, const OutcomeDone& done) {
  if (asker.role >= least) return true;
  refuse_asker(services, Reason::role, "Your role may not do this.", done);
  return false;
}

void set_values(Services& services, const Asker& asker, ValueSet set, OutcomeDone done) {
  Command commit = command_of(CommandKind::commit_parameters, asker);
  commit.v0 = set.revert_after_s;
  commit.b = static_cast<std::uint32_t>(asker.role);
  const auto answered = [done = std::move(done), rows = set.rows](const CoreAnswer& answer) {
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
  };
  services.history.expect(services.core.ask_parameters(set.rows, set.version, commit, answered), std::move(set.origin));
}

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
  if (!begin_action(services, asker, Action::take_lease, {take_over ? "take over" : ""}, done)) return;
  Command command = command_of(CommandKind::take_lease, asker);
  command.a = take_over ? contract::kTakeOver : 0;
  services.core.ask(command, [done = std::move(done), take_over, &services](const CoreAnswer& answer) {
    Outcome outcome = outcome_of(answer);
    // The table's sentence tells others to take control, which is what was asked here.
    if (!take_over && (answer.bits & contract::refusal_bit(contract::Refusal::no_lease)) != 0)
      outcome.detail = "Somebody else is in control: ask again with take_over while the hoist stands still.";
    outcome.epoch = services.core.lease_epoch();
    done(outcome);
  });
}

void act_release_lease(Services& services, const Asker& asker, OutcomeDone done, bool gone) {
  if (!begin_action(services, asker, Action::release_lease, {}, done)) return;
  Command command = command_of(CommandKind::release_lease, asker);
  if (gone) command.a = contract::kConsoleGone;
  ask(services, command, std::move(done));
}

void act_pause_alarm(Services& services, const Asker& asker, bool paused, OutcomeDone done) {
  if (!begin_action(services, asker, Action::pause_alarm, {paused ? "paused" : "sounds again"}, done)) return;
  Command command = command_of(CommandKind::pause_alarm, asker);
  command.a = paused ? 1 : 0;
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

namespace {
bool holds_lease(const Services& services, const Asker& asker) { return asker.client != 0 && services.core.lease_holder() == asker.client; }

// For actions of the lease holder that the core is not asked about. False: `done` has been called.
bool must_hold(Services& services, const Asker& asker, const OutcomeDone& done) {
  if (holds_lease(services, asker) && services.core.lease_epoch() == asker.epoch) return true;
  services.counters.add(Count::commands_refused);
  done(outcome_of({.kind = services.core.connected() ? CoreAnswer::Kind::refused : CoreAnswer::Kind::no_core,
                   .code = static_cast<std::uint32_t>(contract::Refusal::no_lease),
                   .bits = contract::refusal_bit(contract::Refusal::no_lease)}));
  return false;
}

// The client that a hand-over is to; nothing when there is none that may drive.
std::optional<std::uint32_t> receiver_of(const Services& services, const HandOverWish& wish) {
  std::optional<std::uint32_t> client = wish.client;
  if (wish.user) {
    for (const LeaseAsks::Ask& ask : services.state.asks().list())
      if (const auto actor = services.actors.find(ask.client); !client && actor && actor->user == *wish.user) client = ask.client;
    if (!client) client = services.actors.client_of(*wish.user);
  }
  const auto actor = client ? services.actors.find(*client) : std::nullopt;
  if (!actor || actor->role == "viewer" || !services.actors.is_here(*client)) return std::nullopt;
  return client;
}
}  // namespace

void act_ask_lease(Services& services, const Asker& asker, bool withdraw, OutcomeDone done) {
  if (!begin_action(services, asker, withdraw ? Action::withdraw_lease : Action::ask_lease, {}, done)) return;
  Outcome outcome;
  if (withdraw) {
    services.state.asks().remove(asker.client);
  } else if (services.core.lease_holder() == 0 || holds_lease(services, asker)) {
    outcome.kind = services.core.connected() ? Outcome::Kind::refused : Outcome::Kind::unreachable;
    outcome.reason = services.core.connected() ? std::optional{Reason::lease_free} : std::nullopt;
    outcome.detail = services.core.connected() ? "There is nobody to ask: take control." : "The control core is not connected.";
  } else if (!services.state.asks().add(asker.client, services.now_ns())) {
    outcome.kind = Outcome::Kind::unreachable;
    outcome.reason = Reason::busy;
    outcome.detail = "At most " + std::to_string(LeaseAsks::kMost) + " clients may ask at once.";
  }
  done(outcome);
}

void act_hand_over(Services& services, const Asker& asker, const HandOverWish& wish, OutcomeDone done) {
  const std::string target = wish.user ? *wish.user : wish.client ? "client " + std::to_string(*wish.client) : "";
  if (!begin_action(services, asker, Action::hand_over, {target}, done) || !must_hold(services, asker, done)) return;
  const auto receiver = receiver_of(services, wish);
  if (!receiver) {
    Outcome outcome;
    outcome.kind = Outcome::Kind::unknown;
    outcome.detail = "No such client is connected that may drive.";
    done(outcome);
    return;
  }
  Command command = command_of(CommandKind::take_lease, asker);
  command.client = *receiver;
  command.a = contract::kHandOver;
  ask(services, command, std::move(done));
}

void act_keep_lease(Services& services, const Asker& asker, OutcomeDone done) {
  if (!begin_action(services, asker, Action::keep_lease, {}, done) || !must_hold(services, asker, done)) return;
  services.state.asks().refuse();
  done({});
}

namespace {

bool is_share(const std::optional<double>& value) { return value && std::fabs(*value) <= 1.0; }

// Filled in place: GCC 12 warns of a copied one.
std::optional<DriveRefusal> refuse_drive(contract::Refusal refusal) {
  std::optional<DriveRefusal> refused(std::in_place);
  refused->refusal = refusal;
  return refused;
}

std::optional<DriveRefusal> pass_on(Services& services, const Asker& asker, const DriveWish& wish, Hand& hand) {
  using contract::Refusal;
  if (!wish.sequence || !wish.echo_time_ns || !is_share(wish.speed_norm) || !is_share(wish.yaw_norm) || !wish.held)
    return refuse_drive(Refusal::out_of_range);
  if (asker.role < contract::Role::therapist) return refuse_drive(Refusal::not_allowed);
  if (!holds_lease(services, asker)) return refuse_drive(Refusal::no_lease);
  if (*wish.sequence <= hand.sequence) return refuse_drive(Refusal::out_of_order);
  if (asker.over && *wish.held && !hand.held) {
    auto refused = refuse_drive(Refusal::not_allowed);
    refused->reason = Reason::sign_in_over;
    return refused;
  }
  const contract::DriveCommand command{.lease_epoch = services.core.lease_epoch(),
                                       .client = asker.client,
                                       .sequence = *wish.sequence,
                                       .echo_time_ns = *wish.echo_time_ns,
                                       .speed_norm = *wish.speed_norm,
                                       .yaw_norm = *wish.yaw_norm,
                                       .held = *wish.held ? 1U : 0U};
  if (!services.core.drive(command)) return refuse_drive(Refusal::stale_command);
  hand = {.sequence = command.sequence, .held = *wish.held};
  return std::nullopt;
}
}  // namespace

std::string_view DriveRefusal::text_en() const {
  if (reason) return kReasons[static_cast<std::size_t>(*reason)].text_en;
  for (const contract::RefusalInfo& r : contract::kRefusals)
    if (static_cast<contract::Refusal>(r.bit) == refusal) return r.text_en;
  return {};
}

std::optional<DriveRefusal> act_drive(Services& services, const Asker& asker, const DriveWish& wish, Hand& hand) {
  const std::optional<DriveRefusal> refused = pass_on(services, asker, wish, hand);
  if (refused && wish.held == false && holds_lease(services, asker)) {
    // With the next free number, since the core takes only those that rise.
    const contract::DriveCommand let_go{.lease_epoch = services.core.lease_epoch(),
                                        .client = asker.client,
                                        .sequence = hand.sequence + 1,
                                        .echo_time_ns = wish.echo_time_ns.value_or(0)};
    if (services.core.drive(let_go)) hand = {.sequence = let_go.sequence, .held = false};
  }
  return refused;
}

bool may_close(const Services& services, std::uint32_t client) {
  const auto& newest = services.core.newest();
  return !newest || newest->standing_still != 0 || services.core.lease_holder() != client;
}

void act_stop(Services& services, const Asker& asker, OutcomeDone done) {
  CoreDesk::Done answered;
  if (done) answered = [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); };
  // Before STOP is asked for, since the answer may come within the call; the entry's disk and digest are another thread's work.
  log_action(services, asker, audit_entry(services, asker, Action::stop, {}), services.core.link().attached() ? "done" : "no_core");
  services.core.stop(asker.client, std::move(answered));
}

namespace {
// What a client that is gone asked for moves nothing. False: `done` has been told.
bool is_there(Services& services, const Asker& asker, const OutcomeDone& done) {
  if (!asker.gone) return true;
  services.counters.add(Count::commands_refused);
  Outcome outcome;
  outcome.kind = Outcome::Kind::refused;
  outcome.refusals = refusal_names(contract::refusal_bit(contract::Refusal::stale_command));
  outcome.detail = "The connection of its sender had ended.";
  done(outcome);
  return false;
}
}  // namespace

void act_acknowledge(Services& services, const Asker& asker, const json& seen, OutcomeDone done) {
  if (!begin_action(services, asker, Action::acknowledge, {{}, {}, seen.is_null() ? std::nullopt : std::optional(dump_json(seen))}, done))
    return;
  if (!is_there(services, asker, done)) return;
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
  if (!begin_action(services, asker, Action::set_neutral, {}, done)) return;
  ask(services, dated(services, CommandKind::set_neutral, asker), std::move(done));
}

void act_calibrate(Services& services, const Asker& asker, const CalibrateWish& wish, OutcomeDone done) {
  if (!begin_action(services, asker, Action::begin_calibration, {wish.step}, done)) return;
  const contract::CalibrationStepInfo* info = contract::find_calibration_step(std::string_view{wish.step});
  if (info == nullptr) {
    done(invalid({{"step", "must be a step of the calibration table"}}, "There is no such calibration step."));
    return;
  }
  Command command = command_of(CommandKind::begin_calibration, asker);
  command.a = static_cast<std::uint32_t>(info->step);
  command.b = static_cast<std::uint32_t>(asker.role);
  command.v0 = wish.harness_empty ? 1.0 : 0.0;
  services.core.ask(command, [done = std::move(done)](const CoreAnswer& answer) {
    Outcome outcome = outcome_of(answer);
    if ((answer.bits & contract::refusal_bit(contract::Refusal::harness_unconfirmed)) != 0)
      outcome.errors.push_back({"harness_empty", "must be true: nobody is strapped in"});
    done(outcome);
  });
}

void act_measure(Services& services, const Asker& asker, const MeasureWish& measured, OutcomeDone done) {
  if (!begin_action(services, asker, Action::measure_calibration, {std::to_string(measured.figure)}, done)) return;
  if (measured.turning && (!measured.x_m || !measured.y_m)) {
    done(invalid({{measured.x_m ? "y_m" : "x_m", "is missing; a driven square has both"}}, "The measurement cannot be used.",
                 Reason::measurement));
    return;
  }
  Command command = command_of(CommandKind::measure_calibration, asker);
  command.v0 = measured.figure;
  command.v1 = measured.x_m.value_or(0);
  command.v2 = measured.y_m.value_or(0);
  if (measured.turning)
    command.a = static_cast<std::uint32_t>(*measured.turning == "left" ? contract::CalibrationPart::left_square
                                                                       : contract::CalibrationPart::right_square);
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
  if (!begin_action(services, asker, Action::use_calibration, {}, done)) return;
  ask(services, dated(services, CommandKind::use_calibration, asker), std::move(done));
}

void act_cancel_calibration(Services& services, const Asker& asker, OutcomeDone done) {
  if (!begin_action(services, asker, Action::cancel_calibration, {}, done)) return;
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

// A key that tells one exercise from another: mode, figure, direction, laps. Never 0.
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

// What a motion begins with.
struct Begin {
  Exercise exercise;
  json told;  // as it was asked for
  std::optional<db::TaskRecord> task = {};
};
// Asks for a motion. What it begins with goes into the recording, and to every screen when it has begun.
void begin_motion(Services& services, const Command& request, Begin begin, OutcomeDone done) {
  services.recorder.set_exercise(stored_exercise(begin.exercise, begin.task));
  ask(services, request, [&services, begin = std::move(begin), done = std::move(done)](const Outcome& outcome) {
    if (outcome.done()) services.state.motion_begins(begin.told, begin.task);
    done(outcome);
  });
}
}  // namespace

void act_mode(Services& services, const Asker& asker, const ModeWish& wish, OutcomeDone done) {
  const Action action = wish.mode == "standby" ? Action::end_motion : Action::start_motion;
  if (!begin_action(services, asker, action, {wish.mode.is_string() ? wish.mode.get<std::string>() : ""}, done)) return;
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
  if (!is_there(services, asker, done)) return;
  if (*mode == contract::Mode::guided && !services.core.has_parameters()) {
    // Without the parameters in force there are no limits to hold the exercise against.
    done(outcome_of({.kind = CoreAnswer::Kind::no_core}));
    return;
  }
  std::vector<FieldError> errors;
  auto exercise = read_exercise(wish.exercise, errors);
  std::uint32_t laps = 0;
  if (*mode == contract::Mode::guided) {
    if (!wish.exercise.is_null()) errors.push_back({"exercise", "is the path itself; leave it out"});
    if (const auto path = read_guided(wish.path, guided_limits(services), errors)) {
      contract::put_guided(request, *path);
      exercise = Exercise{*path, {}};
      laps = path->laps;
    }
  } else if (!wish.path.is_null()) {
    errors.push_back({"path", "belongs to the mode guided only"});
  }
  if (!exercise || !errors.empty()) {
    Outcome outcome = invalid(std::move(errors), "The exercise cannot be used.", Reason::exercise);
    // A refused start names every reason.
    if (*mode == contract::Mode::guided)
      outcome.refusals = refusal_names(blocked_bits(services) | contract::refusal_bit(contract::Refusal::exercise_limits));
    done(outcome);
    return;
  }
  if (asker.client == 0 || services.core.lease_holder() != asker.client || services.core.lease_epoch() != asker.epoch) {
    // Here, so that a client that may not start does not set the pose either; together with the other reasons.
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
  const Walk& walk = services.state.walk();
  const bool only_moved = *mode == contract::Mode::remote && wish.exercise.is_null();
  if (only_moved && !walk.starts_anew()) {
    // The exercise stays where it lies on the floor.
    begin_motion(services, request, {*exercise, exercise_json(*exercise)}, std::move(done));
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
  // Where the hoist is only moved, no exercise has this mark: the next one begins at its own.
  set_pose.a = only_moved ? 0 : exercise_key(*mode, *exercise, laps);
  const bool again = wish.start_again == true || walk.starts_anew() || (walk.task().over() && walk.task().next(*exercise, *mode));
  set_pose.b = again ? contract::kStartAgain : 0;
  services.core.ask(set_pose, [&services, request, again, only_moved, mode = *mode, exercise = *exercise,
                               told = guided ? wish.path : exercise_json(*exercise), ends_asked = services.ends_asked,
                               done = std::move(done)](const CoreAnswer& answer) mutable {
    if (!answer.done()) {
      Outcome outcome = outcome_of(answer);
      // A refused start names every reason, not only the one that stopped its first step.
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
    const auto task = only_moved ? std::nullopt : services.state.walk().task().next(exercise, mode, again);
    begin_motion(services, request, {exercise, std::move(told), task}, std::move(done));
  });
}

namespace {
std::string shape_of(const json& exercise) {
  const auto shape = exercise.is_object() ? exercise.find("shape") : exercise.end();
  return shape != exercise.end() && shape->is_string() ? shape->get<std::string>() : std::string{};
}
}  // namespace

void act_choose(Services& services, const Asker& asker, const json& exercise, OutcomeDone done) {
  if (!begin_action(services, asker, Action::choose_exercise, {shape_of(exercise)}, done)) return;
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

void act_choose_task(Services& services, const Asker& asker, const json& wish, OutcomeDone done) {
  const auto name = wish.is_object() ? wish.find("task") : wish.end();
  const bool none = wish.is_object() && name != wish.end() && name->is_null();
  const std::string target = wish.is_object() && name != wish.end() && name->is_string() ? name->get<std::string>() : "";
  if (!begin_action(services, asker, Action::choose_task, {target}, done)) return;
  std::vector<db::ExerciseProblem> problems;
  const auto choice = none ? std::nullopt : db::read_task_choice(wish, problems);
  if (!none && !choice) {
    std::vector<FieldError> errors;
    errors.reserve(problems.size());
    for (db::ExerciseProblem& p : problems) errors.push_back({p.field, std::move(p.message), p.value, p.min, p.max});
    done(invalid(std::move(errors), "The task cannot be done so.", Reason::exercise));
    return;
  }
  const auto& newest = services.core.newest();
  if (newest && newest->mode < contract::kModes.size() && contract::kModes[newest->mode].moving) {
    done(outcome_of({.kind = CoreAnswer::Kind::refused, .bits = contract::refusal_bit(contract::Refusal::not_standby)}));
    return;
  }
  if (choice)
    services.state.choose(*choice);
  else
    services.state.choose(services.state.walk().chosen());
  done({});
}

void act_choose_rehearsal(Services& services, const Asker& asker, const json& wish, OutcomeDone done) {
  const json& name = wish.at("rehearsal");
  const auto kind = name.is_string() ? find_rehearsal(name.get_ref<const std::string&>()) : std::nullopt;
  if (!begin_action(services, asker, Action::choose_rehearsal, {kind ? name.get<std::string>() : ""}, done)) return;
  Outcome outcome;
  if (kind) {
    const json seed = wish.value("seed", json());
    outcome.reason = services.rehearsals.choose(*kind, seed.is_number() ? seed.get<std::uint64_t>() : std::random_device{}(), asker.client);
  } else {
    services.rehearsals.cancel();
  }
  if (outcome.reason) {
    outcome.kind = Outcome::Kind::refused;
    outcome.detail = "There is no rehearsal here now.";
  }
  done(outcome);
}

void end_task(Services& services) {
  ++services.ends_asked;
  Command request = command_of(CommandKind::request_mode, {});
  request.a = static_cast<std::uint32_t>(contract::Mode::standby);
  ask(services, request, [](const Outcome&) {});
}

void act_pose(Services& services, const Asker& asker, const StartPose& pose, OutcomeDone done) {
  if (!begin_action(services, asker, Action::set_pose, {}, done)) return;
  Command command = command_of(CommandKind::set_pose, asker);
  command.v0 = pose.x_m;
  command.v1 = pose.y_m;
  command.v2 = pose.psi_rad;
  ask(services, command, std::move(done));
}

void act_keep_trial(Services& services, const Asker& asker, std::uint32_t version, OutcomeDone done) {
  if (!begin_action(services, asker, Action::keep_parameters, {}, done)) return;
  Command command = command_of(CommandKind::confirm_parameters, asker);
  command.a = version;
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

void act_undo_trial(Services& services, const Asker& asker, OutcomeDone done) {
  if (!begin_action(services, asker, Action::undo_parameters, {}, done)) return;
  Command command = command_of(CommandKind::revert_parameters, asker);
  command.b = static_cast<std::uint32_t>(asker.role);
  ask(services, command, std::move(done));
}

namespace {
// With the values that are in force until then.
AuditDetails changed_values(const Services& services, const NumbersByName& values) {
  json before = json::object(), after = json::object();
  for (const auto& [name, number] : values) {
    after[name] = number;
    if (const auto index = contract::find_param(name); index && services.core.has_parameters())
      before[name] = services.core.parameters().values[*index];
  }
  return {{}, dump_json(before), dump_json(after)};
}
}  // namespace

void act_set(Services& services, const Asker& asker, const NumbersByName& values, std::optional<double> revert_after_s,
             std::uint32_t version, OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_parameters, changed_values(services, values), done)) return;
  if (values.empty()) {
    done(invalid({{"values", "must name at least one parameter"}}, "There is nothing to change."));
    return;
  }
  std::vector<std::pair<std::uint32_t, double>> rows;
  std::vector<FieldError> errors;
  bool unknown = false;
  bool role = false;
  for (const auto& [name, number] : values) {
    const auto index = contract::find_param(name);
    if (!index) {
      unknown = true;
      errors.push_back({name, "There is no such parameter."});
      continue;
    }
    const contract::ParamInfo& p = contract::kParams[*index];
    if (contract::check_param(*index, number) != contract::ParamCheck::ok) {
      errors.push_back(range_error(p, "is outside its range", std::isfinite(number) ? std::optional{number} : std::nullopt));
    } else if (asker.role < p.role) {
      role = true;
      errors.push_back(range_error(p, "only an engineer may change this", number));
    } else if (revert_after_s && p.edit == contract::EditRule::stopped) {
      errors.push_back(range_error(p, "cannot be tried: it may not go back while the hoist moves", number));
    } else {
      rows.emplace_back(p.id, number);
    }
  }
  if (!errors.empty()) {
    Outcome outcome = invalid(std::move(errors), unknown ? "There is no such parameter."
                                                 : role  ? "Your role may not change this."
                                                         : "A value is outside its range; nothing was changed.");
    if (unknown) outcome.kind = Outcome::Kind::unknown;
    if (role && !unknown) outcome.kind = Outcome::Kind::refused;
    outcome.refusals = {unknown ? "unknown_item" : role ? "not_allowed" : "out_of_range"};
    services.counters.add(Count::commands_refused);
    done(outcome);
    return;
  }
  set_values(services, asker,
             {.rows = std::move(rows),
              .version = version,
              .origin = {revert_after_s ? "trial" : "set"},
              .revert_after_s = revert_after_s.value_or(0)},
             std::move(done));
}

void act_update_firmware(Services& services, const Asker& asker, std::vector<std::uint8_t> image, contract::Node node, bool force,
                         OutcomeDone done) {
  if (!begin_action(services, asker, Action::update_firmware, {std::string{contract::kNodes[static_cast<std::size_t>(node)].name}}, done))
    return;
  Command command = command_of(CommandKind::begin_service, asker);
  command.b = static_cast<std::uint32_t>(asker.role);
  services.firmware.begin(std::move(image), node, force, command,
                          [done = std::move(done)](const CoreAnswer& answer) { done(outcome_of(answer)); });
}

void act_preset(Services& services, const Asker& asker, const std::string& name, std::uint32_t version, OutcomeDone done) {
  if (!begin_action(services, asker, Action::apply_preset, {name}, done)) return;
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
  set_values(services, asker, {.rows = std::move(rows), .version = version, .origin = {"preset", name}}, std::move(done));
}

namespace {
Outcome recorder_is_busy() {
  Outcome outcome;
  outcome.kind = Outcome::Kind::unreachable;
  outcome.reason = Reason::busy;
  outcome.detail = "The recorder is busy. Try again in a moment.";
  return outcome;
}
}  // namespace

Outcome store_outcome(const db::Error& error) {
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
    case db::ErrorKind::changed:
      outcome.kind = Outcome::Kind::outdated;
      break;
    case db::ErrorKind::taken:
      outcome.kind = Outcome::Kind::refused;
      outcome.errors.push_back({error.field, error.message});
      break;
    default:
      outcome.kind = Outcome::Kind::unreachable;
      break;
  }
  return outcome;
}

void ask_store_for(Services& services, StoreQuestion work, OutcomeDone done) {
  const auto run = [work = std::move(work)](Records& records) -> Outcome {
    if (records.late()) return recorder_is_busy();
    db::Database* database = records.database();
    if (database == nullptr) return store_outcome(db::Error{db::ErrorKind::io, records.why(), {}});
    Outcome outcome = work(records, *database);
    // Told before the answer, so that the next question sees it.
    (void)records.status();
    return outcome;
  };
  if (!services.records.ask<Outcome>(run, done)) done(recorder_is_busy());
}

void ask_store(Services& services, StoreWork work, OutcomeDone done) {
  ask_store_for(
      services,
      [work = std::move(work)](Records& records, db::Database& database) {
        const db::Status status = work(records, database);
        return status ? Outcome{} : store_outcome(status.error());
      },
      std::move(done));
}

void act_mark(Services& services, const Asker& asker, std::optional<db::SessionId> session, MarkerWish wish, OutcomeDone done) {
  if (!begin_action(services, asker, Action::add_marker, {session ? "session " + std::to_string(*session) : ""}, done)) return;
  if (wish.text.size() > db::kMaxMarker_bytes) {
    constexpr auto kMost = static_cast<double>(db::kMaxMarker_bytes);
    done(invalid({{"text", "must be text of at most 500 bytes", std::nullopt, std::nullopt, kMost}}, "The marker cannot be used."));
    return;
  }
  const auto work = [session, wish = std::move(wish), actor = services.actors.find(asker.client)](Records& records,
                                                                                                  db::Database& database) -> db::Status {
    if (session)
      if (const auto stored = db::SessionReader(database).get(*session); !stored) return stored.error();
    const auto now = records.status().session;
    if (!now || (session && *session != *now)) return db::Error{db::ErrorKind::wrong_state, "This session is not being recorded.", {}};
    return records.marker(*now, wish, actor);
  };
  ask_store(services, work, [done = std::move(done)](Outcome outcome) {
    if (outcome.kind == Outcome::Kind::refused) outcome.reason = Reason::not_recording;
    done(outcome);
  });
}

void act_record(Services& services, const Asker& asker, RecordWish wish, OutcomeDone done) {
  if (!begin_action(services, asker, wish.starts ? Action::begin_recording : Action::end_recording, {}, done)) return;
  const bool starts = wish.starts;
  const auto work = [wish = std::move(wish)](Records& records, db::Database&) {
    return wish.starts ? records.begin_manual(wish.subject, wish.note) : records.end_manual();
  };
  ask_store(services, work, [&services, starts, done = std::move(done)](const Outcome& outcome) {
    if (outcome.done() && starts) services.state.start_anew();
    done(outcome);
  });
}

namespace {
// Piece by piece: between two, the recorder stores what has come and others get their answers. The session is gone already; what cannot be
// overwritten now is at the next start.
void erase_deleted(Services& services, std::shared_ptr<void> held, OutcomeDone done) {
  const std::function<bool(Records&)> piece = [](Records& records) {
    db::Database* database = records.database();
    const auto more = database == nullptr ? db::Result<bool>(false) : db::erase_piece(*database);
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

void act_delete_session(Services& services, const Asker& asker, db::SessionId session, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::delete_session, {"session " + std::to_string(session)}, done)) return;
  const auto work = [session, tag = std::move(tag)](Records&, db::Database& database) { return db::take_out(database, session, tag); };
  ask_store(services, work, [&services, held = services.jobs.hold(), done = std::move(done)](const Outcome& outcome) {
    if (!outcome.done()) return done(outcome);
    services.jobs.forget_recordings();
    erase_deleted(services, held, done);
  });
}

void act_set_retention(Services& services, const Asker& asker, const db::RetentionRule& rule, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::set_retention, {{}, {}, dump_json(db::rule_json(rule))}, done)) return;
  ask_store(
      services, [rule, tag = std::move(tag)](Records&, db::Database& database) { return db::set_retention_rule(database, rule, tag); },
      std::move(done));
}

namespace {
// Why this job may not begin now: a study takes a processor for a minute.
std::optional<Reason> against_job(const Services& services, JobKind kind) {
  if (kind != JobKind::study && kind != JobKind::study_recorded) return {};
  const auto all = services.jobs.list();
  if (std::ranges::any_of(all, [](const JobInfo& job) {
        return (job.kind == JobKind::study || job.kind == JobKind::study_recorded) && !has_ended(job.state);
      }))
    return Reason::study_runs;
  const auto& newest = services.core.newest();
  if (newest && newest->mode < contract::kModes.size() && contract::kModes[newest->mode].moving) return Reason::moving;
  return {};
}
}  // namespace

void act_start_job(Services& services, const Asker& asker, JobKind kind, JobArguments arguments, OutcomeDone done) {
  const JobKindInfo& info = job_kind_info(kind);
  if (!begin_action(services, asker, Action::start_job, {std::string{info.name}}, done) || !may(services, asker, info.role, done)) return;
  if (const auto against = against_job(services, kind)) {
    Outcome refused;
    refused.kind = Outcome::Kind::refused;
    refused.reason = *against;
    refused.detail = std::string(kReasons[static_cast<std::size_t>(*against)].text_en);
    done(refused);
    return;
  }
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
  if (!begin_action(services, asker, Action::cancel_job, {"job " + std::to_string(job)}, done) ||
      (info && !may(services, asker, job_kind_info(info->kind).role, done)))
    return;
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

void act_set_tools(Services& services, const Asker& asker, bool on, const std::string& expected, OutcomeDone done) {
  if (!begin_action(services, asker, Action::set_tools, {on ? "on" : "off"}, done)) return;
  if (!db::check_tag(expected, services.tools.tag())) {
    Outcome outdated;
    outdated.kind = Outcome::Kind::outdated;
    done(outdated);
    return;
  }
  // Closed at once; open only once that is stored.
  if (!on) services.tools.set(false);
  const auto work = [file = services.tools.file(), on](Records&) { return ToolSwitch::store(file, on); };
  const auto then = [&services, on, done](bool stored) {
    Outcome outcome;
    if (!stored) {
      outcome.kind = Outcome::Kind::unreachable;
      outcome.reason = Reason::storage;
      outcome.detail = "The setting cannot be stored beside the database.";
    } else {
      services.tools.set(on);
    }
    done(outcome);
  };
  if (!services.records.ask<bool>(work, then)) done(recorder_is_busy());
}

}  // namespace hoist::server
