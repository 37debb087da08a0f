// What each incoming message does. One function per HOIST_IN row of messages.def; an unlisted type is refused.
#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "control/contract/faults.hpp"
#include "server/actions/actions.hpp"
#include "server/actions/patients.hpp"
#include "server/contract/fields.hpp"
#include "server/contract/schemas.hpp"
#include "server/live/client.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
constexpr std::uint64_t kNoticeEvery_ns = 1'000'000'000;

Asker asker_of(const Client& client) {
  const Session& session = *client.session();
  return {.client = client.number(),
          .epoch = client.hub().services().core.lease_epoch(),
          .role = session.role,
          .over = client.hub().over(session),
          .gone = client.has_ended()};
}
// For what begins motion or leaves a stop.
Asker asker_who_saw(const Client& client, const json& message) {
  Asker asker = asker_of(client);
  asker.echo_time_ns = echo_wish(message);
  return asker;
}

json reply_json(const json& request, const Outcome& outcome) {
  json reply{{"type", "reply"}, {"request", request.is_number_integer() ? request : json(0)}, {"ok", outcome.done()}};
  if (outcome.done()) {
    if (outcome.epoch != 0) reply["epoch"] = outcome.epoch;
    if (outcome.stored) reply["stored"] = *outcome.stored;
    return reply;
  }
  reply["refusals"] = outcome.refusals;
  reply["errors"] = to_json(outcome.errors);
  reply["detail"] = outcome.detail;
  reply["reason_code"] = reason_name(reason_of(outcome));
  return reply;
}

// The answer finds its client by a weak pointer: one that has left gets none.
OutcomeDone reply_to(Client& client, const json& message) {
  return [weak = std::weak_ptr(std::static_pointer_cast<Client>(client.shared_from_this())),
          request = message.value("request", json())](const Outcome& outcome) {
    if (const auto held = weak.lock()) held->send(reply_json(request, outcome));
  };
}

// For a person: the exercise or value is at fault, or else the page that sent it.
Reason reason_for(const std::vector<FieldError>& errors) {
  const auto about = [](const FieldError& e, std::string_view name) { return e.field.starts_with(name); };
  if (std::ranges::all_of(errors, [&](const FieldError& e) { return about(e, "exercise.") || about(e, "path."); })) return Reason::exercise;
  return std::ranges::any_of(errors, [](const FieldError& e) { return e.min || e.max; }) ? Reason::invalid : Reason::message;
}

void refuse_fields(Client& client, const json& message, std::vector<FieldError> errors) {
  Outcome outcome;
  outcome.kind = Outcome::Kind::invalid;
  outcome.reason = reason_for(errors);
  outcome.errors = std::move(errors);
  outcome.detail = "The message cannot be used.";
  client.hub().services().counters.add(Count::ws_refused);
  reply_to(client, message)(outcome);
}

const json& field(const json& message, const char* name) {
  static const json kNull;
  const auto at = message.find(name);
  return at == message.end() ? kNull : *at;
}

namespace on {
void lease_take(Client& client, const json& message) {
  const json& over = field(message, "take_over");
  act_take_lease(client.hub().services(), asker_of(client), over == true, reply_to(client, message));
}
void lease_release(Client& client, const json& message) {
  act_release_lease(client.hub().services(), asker_of(client), reply_to(client, message));
}
void lease_ask(Client& client, const json& message) {
  act_ask_lease(client.hub().services(), asker_of(client), field(message, "withdraw") == true, reply_to(client, message));
}
void lease_keep(Client& client, const json& message) {
  act_keep_lease(client.hub().services(), asker_of(client), reply_to(client, message));
}
void lease_hand_over(Client& client, const json& message) {
  act_hand_over(client.hub().services(), asker_of(client), hand_over_wish(message), reply_to(client, message));
}
void mode(Client& client, const json& message) {
  act_mode(client.hub().services(), asker_who_saw(client, message),
           {field(message, "mode"), field(message, "exercise"), field(message, "path"), field(message, "start_again")},
           reply_to(client, message));
}
void stop(Client& client, const json&) { act_stop(client.hub().services(), asker_of(client), nullptr); }
void acknowledge(Client& client, const json& message) {
  act_acknowledge(client.hub().services(), asker_who_saw(client, message), field(message, "seen"), reply_to(client, message));
}
void pause_alarm(Client& client, const json& message) {
  act_pause_alarm(client.hub().services(), asker_of(client), field(message, "paused") == true, reply_to(client, message));
}

std::optional<double> number(const json& value) { return value.is_number() ? std::optional{value.get<double>()} : std::nullopt; }

void drive(Client& client, const json& message) {
  Services& services = client.hub().services();
  const json& held = field(message, "held");
  const DriveWish wish{.sequence = whole_wish(field(message, "sequence")),
                       .echo_time_ns = whole_wish(field(message, "echo")),
                       .speed_norm = number(field(message, "speed")),
                       .yaw_norm = number(field(message, "yaw")),
                       .held = held.is_boolean() ? std::optional{held.get<bool>()} : std::nullopt};
  const auto refused = act_drive(services, asker_of(client), wish, client.hand);
  if (!refused) return;
  services.counters.add(Count::ws_refused);
  services.counters.add(Count::ws_refused_drive);
  const std::uint64_t now = services.now_ns();
  if (client.drive_notice_ns != 0 && now - client.drive_notice_ns < kNoticeEvery_ns) return;
  client.drive_notice_ns = now;
  client.send(json{{"type", "notice"},
                   {"level", "warning"},
                   {"text_key", refused->reason ? reason_name(*refused->reason) : "drive_refused"},
                   {"refusals", refused->reason ? std::vector<std::string>{} : refusal_names(contract::refusal_bit(refused->refusal))}});
}

void set(Client& client, const json& message) {
  act_set(client.hub().services(), asker_of(client), numbers_wish(message["values"]), number_wish(message, "revert_after_s"),
          version_wish(message), reply_to(client, message));
}
void keep_settings(Client& client, const json& message) {
  act_keep_trial(client.hub().services(), asker_of(client), version_wish(message), reply_to(client, message));
}
void undo_settings(Client& client, const json& message) {
  act_undo_trial(client.hub().services(), asker_of(client), reply_to(client, message));
}
void preset(Client& client, const json& message) {
  act_preset(client.hub().services(), asker_of(client), message["name"].get<std::string>(), version_wish(message),
             reply_to(client, message));
}
void choose(Client& client, const json& message) {
  act_choose(client.hub().services(), asker_of(client), field(message, "exercise"), reply_to(client, message));
}
void choose_patient(Client& client, const json& message) {
  act_choose_patient(client.hub().services(), asker_of(client), field(message, "patient"), reply_to(client, message));
}
void neutral(Client& client, const json& message) { act_neutral(client.hub().services(), asker_of(client), reply_to(client, message)); }
void calibrate(Client& client, const json& message) {
  act_calibrate(client.hub().services(), asker_of(client), calibrate_wish(message), reply_to(client, message));
}
void calibrate_measure(Client& client, const json& message) {
  act_measure(client.hub().services(), asker_of(client), measure_wish(message), reply_to(client, message));
}
void calibrate_use(Client& client, const json& message) {
  act_use_calibration(client.hub().services(), asker_of(client), reply_to(client, message));
}
void calibrate_cancel(Client& client, const json& message) {
  act_cancel_calibration(client.hub().services(), asker_of(client), reply_to(client, message));
}
void pose(Client& client, const json& message) {
  act_pose(client.hub().services(), asker_of(client), pose_wish(message), reply_to(client, message));
}

void marker(Client& client, const json& message) {
  act_mark(client.hub().services(), asker_of(client), std::nullopt, marker_wish(message), reply_to(client, message));
}

// What is left out is as for a client that has chosen nothing.
StreamChoice stream_choice(const json& message) {
  StreamChoice choice;
  if (const json& topics = field(message, "topics"); topics.is_array()) {
    choice.topics = topic_bit(Topic::state);
    for (const json& name : topics) choice.topics |= topic_bit(*find_topic(name.get_ref<const std::string&>()));
    if ((choice.topics & topic_bit(Topic::all)) != 0) choice.topics = topic_bit(Topic::all);
  }
  if (const json& rate = field(message, "rate_hz"); rate.is_number())
    choice.every_ticks = kStreamRates_hz.back() / rate.get<std::uint32_t>();
  choice.every_step = field(message, "every_tick") == true;
  return choice;
}

void stream(Client& client, const json& message) {
  StreamChoice choice = stream_choice(message);
  std::optional<Resume> resume;
  if (const json& last = field(message, "last_tick"); !last.is_null()) {
    const json& run = field(message, "run");
    if (!run.is_string()) return refuse_fields(client, message, {{"run", "is missing; it must be text, as in the message core"}});
    resume = Resume{.last_tick = last.get<std::uint64_t>(), .run = run.get<std::string>()};
  }
  if (choice.every_step && !client.holds_lease()) {
    client.send(json{{"type", "notice"}, {"level", "info"}, {"text_key", "every_tick_refused"}, {"refusals", {"no_lease"}}});
    choice.every_step = false;
  }
  client.hub().choose(client, choice, resume);
}

void ping(Client& client, const json& message) {
  const json& t = field(message, "t");
  client.send(json{{"type", "pong"}, {"t", t}, {"time_ns", client.hub().services().now_ns()}});
}
}  // namespace on

struct Row {
  const char* type;
  bool answered;
  std::string_view schema;
  void (*handler)(Client&, const json&);
};
constexpr std::array kRows{
#define HOIST_IN(type, answered, role, schema, doc) Row{#type, answered != 0, #schema, &on::type},
#define HOIST_OUT(...)
#define HOIST_FIELD(...)
#include "server/contract/messages.def"
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD
};

// Without what belongs to the message itself. null in place of an optional field is the same as leaving it out; a required one may mean it:
// nobody is chosen.
json fields_of(const json& message, std::string_view schema) {
  const json& required = field(schemas().at(std::string{schema}), "required");
  const auto is_required = [&](const std::string& name) { return std::find(required.begin(), required.end(), name) != required.end(); };
  json fields = json::object();
  for (const auto& [name, value] : message.items())
    if (name != "type" && name != "request" && (!value.is_null() || is_required(name))) fields[name] = value;
  return fields;
}

// What stops or ends motion is never refused for its form.
bool ends_motion(const Row& row, const json& message) {
  return row.handler == &on::stop || (row.handler == &on::mode && field(message, "mode") == "standby");
}
}  // namespace

void handle_message(Client& client, const json& message, const std::optional<std::string>& repeated) {
  Counters& counters = client.hub().services().counters;
  const json& type = field(message, "type");
  const std::string name = type.is_string() ? type.get<std::string>() : std::string{};
  for (const Row& row : kRows) {
    if (name != row.type) continue;
    if (row.answered && !field(message, "request").is_number_integer()) {
      refuse_fields(client, message, {{"request", "must be a whole number"}});
      return;
    }
    // A field that is given twice says two things. For a hand on the joystick that means letting go.
    if (repeated && row.handler == &on::drive) {
      json let_go = message;
      let_go["held"] = false;
      let_go["speed"] = nullptr;
      on::drive(client, let_go);
      return;
    }
    if (repeated && !ends_motion(row, message)) {
      refuse_fields(client, message, {{*repeated, "is given twice"}});
      return;
    }
    // Driving judges itself, field by field: letting go counts whatever else is wrong.
    if (row.handler != &on::drive) {
      if (auto errors = wrong_fields(row.schema, fields_of(message, row.schema)); !errors.empty() && !ends_motion(row, message)) {
        refuse_fields(client, message, std::move(errors));
        return;
      }
    }
    row.handler(client, message);
    return;
  }
  counters.add(Count::ws_refused);
  counters.add(Count::ws_refused_type);
  refuse_fields(client, message, {{"type", "There is no such message."}});
}

}  // namespace hoist::server
