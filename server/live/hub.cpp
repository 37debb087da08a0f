#include "server/live/hub.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "control/contract/calibration.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/program_version.hpp"
#include "server/actions/actions.hpp"
#include "server/record/reason.hpp"
#include "server/state/notices.hpp"
#include "server/state/views.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
constexpr std::uint64_t kRefillSamples = 50;  // of one message
constexpr std::uint64_t kProgressEvery_ns = 250'000'000;
constexpr std::string_view kEnds = "the server ends";
constexpr std::string_view kSignedOut = "signed out";

constexpr std::uint32_t kNoCanId = 0xFFFF;  // babbling_id of a bus that is simply full
bool is_about_a_device(std::uint32_t code) {
  return code == static_cast<std::uint32_t>(contract::Fault::node_duplicate) ||
         code == static_cast<std::uint32_t>(contract::Fault::node_babbling);
}

SharedFrame text_frame(const json& message) { return make_frame(Opcode::text, dump_json(message)); }

// The same for all but `mine`.
json lease_message(const Services& s) {
  json message = lease_json(s.core, s.state.asks(), s.actors);
  message["type"] = "lease";
  return message;
}

json core_json(const CoreDesk& core) {
  const std::string_view problem = core.problem();
  const auto reason = core.reason();
  return {{"type", "core"},
          {"connected", core.connected()},
          {"problem", problem.empty() ? json(nullptr) : json(problem)},
          {"reason_code", reason ? json(reason_name(*reason)) : json(nullptr)},
          {"run", core.run() != 0 ? json(std::to_string(core.run())) : json(nullptr)}};
}

json walk_json(const Walk& walk) {
  json message = walk.told();
  message["type"] = "walk";
  return message;
}

json patient_message(const HoistState& state) {
  json message = chosen_patient_json(state);
  message["type"] = "patient";
  return message;
}

json parameters_message(const contract::ParamsInForce& parameters) {
  json values = json::object();
  for (std::size_t i = 0; i < contract::kParamCount; ++i) values[std::string{contract::kParams[i].name}] = parameters.values[i];
  return {{"type", "parameters"}, {"version", parameters.version}, {"values", std::move(values)}};
}
}  // namespace

json event_json(const contract::Event& event) {
  using contract::EventKind;
  json out{{"kind", contract::event_name(event.kind)}, {"tick", event.tick}, {"time_ns", event.time_ns}};
  switch (event.kind) {
    case EventKind::fault_raised:
    case EventKind::fault_cleared:
      out["code"] = event.code;
      for (const contract::FaultInfo& f : contract::kFaults)
        if (f.bit == event.code) out["name"] = f.name;
      // What a fault is about, where that has words of its own.
      if (event.kind == EventKind::fault_raised && event.code < contract::kFaultPlaces && event.item != 0 &&
          (contract::faults_with_details() & contract::fault_bit(static_cast<contract::Fault>(event.code))) != 0)
        out["item"] = event.item;
      // A fault that may be about any device names the one it is about.
      if (event.kind == EventKind::fault_raised && is_about_a_device(event.code)) {
        out["item"] = event.item;
        if (const auto node = contract::find_node(static_cast<std::uint8_t>(event.item & 0x7FU)); node && event.item != kNoCanId)
          out["node"] = contract::kNodes[static_cast<std::size_t>(*node)].name;
      }
      break;
    case EventKind::emergency:
      out["code"] = event.code;
      out["item"] = event.item;
      out["bits"] = event.bits;
      out["value"] = event.value;
      if (event.item < contract::kNodes.size()) out["name"] = contract::kNodes[event.item].name;
      break;
    case EventKind::mode_changed:
      out["code"] = event.code;
      out["item"] = event.item;
      if (event.code < contract::kModes.size()) out["name"] = contract::kModes[event.code].name;
      break;
    case EventKind::parameter_changed:
    case EventKind::parameter_settled:
      out["item"] = event.item;
      out["value"] = event.value;
      out["before"] = event.before;
      if (const auto index = contract::find_param_id(event.item)) out["name"] = contract::kParams[*index].name;
      break;
    case EventKind::calibration_sample:
    case EventKind::calibration_result:
    case EventKind::calibration_ended:
      out["code"] = event.code;
      out["item"] = event.item;
      out["bits"] = event.bits;
      out["value"] = event.value;
      out["before"] = event.before;
      if (const auto index = contract::find_param_id(event.item); index && event.kind == EventKind::calibration_result)
        out["name"] = contract::kParams[*index].name;
      if (const auto* reason = contract::find_calibration_reason(event.item);
          reason != nullptr && event.kind == EventKind::calibration_ended)
        out["name"] = reason->name;
      break;
    case EventKind::node_changed:
      out["code"] = event.code;
      out["item"] = event.item;
      if (event.item < contract::kNodes.size()) out["name"] = contract::kNodes[event.item].name;
      break;
    case EventKind::command_refused:
      out["code"] = event.code;
      out["refusals"] = refusal_names(event.bits != 0 ? event.bits : 1U << (event.code & 31U));
      if (const auto index = contract::find_param_id(event.item)) out["name"] = contract::kParams[*index].name;
      break;
    case EventKind::sync_input:
      out["code"] = event.code;
      out["name"] = event.code != 0 ? "on" : "off";
      break;
    case EventKind::alarm_paused:
      out["code"] = event.code;
      out["name"] = event.code != 0 ? "on" : "off";
      out["value"] = event.value;
      break;
    case EventKind::guided_ended:
      out["code"] = event.code;
      out["name"] = contract::guided_end_name(event.code);
      out["value"] = event.value;
      break;
    case EventKind::lease_changed:
      out["code"] = event.code;
      break;
    default:
      break;
  }
  return out;
}

Hub::Hub() = default;
Hub::~Hub() = default;

void Hub::set_services(Services& services, Auth& auth) {
  services_ = &services;
  auth_ = &auth;
  services.state.set_on_walk([this] { tell_walk(); });
  services.state.set_on_patient([this] { broadcast(text_frame(patient_message(services_->state))); });
}

void Hub::open(std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session, const std::string& address) {
  if (session == cut_ && services_->now_ns() < cut_until_ns_) return;
  services_->counters.add(Count::ws_opened);
  const std::uint32_t number = services_->actors.enter(
      {{session->user, std::string{access_role(session->role)}, "hoist.v1", client_name(*session)}, session->display_name, address});
  auto client = std::make_shared<Client>(*this, std::move(stream), std::move(session), number, std::move(seat));
  client->start();
  add(std::move(client));
}

void Hub::close_sockets(const std::function<bool(const Session&)>& of, std::string_view reason) {
  // A closing client may leave the list at once.
  const auto clients = clients_;
  for (const auto& client : clients)
    if (of(*client->session())) client->close(CloseCode::policy, reason);
}

bool Hub::cut(std::uint32_t client, std::uint64_t until_ns) {
  const auto at = std::ranges::find(clients_, client, [](const auto& one) { return one->number(); });
  if (at == clients_.end()) return false;
  const std::shared_ptr<Client> held = *at;
  cut_ = held->session();
  cut_until_ns_ = until_ns;
  held->close(CloseCode::policy, "A rehearsal of a lost link.");
  return true;
}

void Hub::close_ended() {
  // A sign-in that runs out must not stop a hoist that a hand drives: its socket is closed as soon as the hoist stands.
  const auto clients = clients_;
  for (const auto& client : clients) {
    const Session& session = *client->session();
    if (over(session) && (session.ended || may_close(*services_, client->number()))) client->close(CloseCode::policy, kSignedOut);
  }
}

bool Hub::over(const Session& session) const { return Auth::over(session, clocks_of(services_->utc_ns(), services_->now_ns())); }

void Hub::use(Session& session) { auth_->use(session, clocks_of(services_->utc_ns(), services_->now_ns())); }

void Hub::add(std::shared_ptr<Client> client) {
  // Its handshake was under way when the server began to end.
  if (ending_) {
    client->close(CloseCode::going_away, kEnds);
    return;
  }
  const Services& s = *services_;
  json welcome{{"type", "welcome"},
               {"client", client->number()},
               {"role", access_role(client->session()->role)},
               {"version", contract::program_version()},
               {"layout_hash", layout_hash_hex()},
               {"record_bytes", sizeof(contract::TickRecord)},
               {"simulated", s.core.newest() ? s.core.newest()->simulated != 0 : s.settings.scenario.has_value()},
               {"scenario", nullptr}};
  if (s.settings.scenario) welcome["scenario"] = *s.settings.scenario;
  client->send(welcome);
  client->send(core_json(s.core));
  client->send(walk_json(services_->state.walk()));
  client->send(patient_message(services_->state));
  if (s.core.has_parameters()) client->send(parameters_message(s.core.parameters()));
  tell_lease(*client, lease_message(s));
  json recording = recording_json(s.recorder.status());
  recording["type"] = "recording";
  client->send(recording);
  client->send(json{{"type", "notices"}, {"items", notices_json(standing_notices(s.core, s.recorder, s.jobs, s.people))}});
  ++client->session()->sockets;
  assign(*client);
  clients_.push_back(std::move(client));
  services_->live_clients = clients_.size();
}

void Hub::remove(const Client* client) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [client](const auto& c) { return c.get() == client; });
  if (at == clients_.end()) return;
  const std::shared_ptr<Client> held = *at;
  clients_.erase(at);
  held->follow(nullptr, 0);
  std::erase_if(feeds_, [](const auto& feed) { return feed.use_count() == 1; });
  --held->session()->sockets;
  services_->live_clients = clients_.size();
  services_->actors.leave(held->number());
  services_->state.asks().remove(held->number());
  // A client that is gone no longer drives: the core is told, stops remote motion and frees the lease.
  if (held->holds_lease())
    act_release_lease(
        *services_, {held->number(), services_->core.lease_epoch(), held->session()->role}, [](const Outcome&) {}, true);
}

void Hub::broadcast(const SharedFrame& frame) {
  // A client that is closed for being slow leaves the list while we go through it.
  const auto all = clients_;
  for (const auto& client : all) client->send(frame);
}

void Hub::send_batches(bool urgent) {
  if (urgent) batched_ = 0;
  for (const auto& feed : feeds_) {
    if (!urgent && !feed->choice().every_step) continue;
    const Feed::Batch batch = feed->flush();
    if (!batch.frame) continue;
    for (const auto& client : clients_)
      if (client->feed() == feed) client->show(batch);
  }
}

void Hub::tell_lost(std::uint64_t to) {
  send_batches(true);
  for (const auto& client : clients_) client->show_lost(to);
}

void Hub::assign(Client& client) {
  StreamChoice may = client.asked;
  if (client.holds_lease())
    may.every_ticks = std::min(may.every_ticks, kDriverEvery_ticks);
  else
    may.every_step = false;
  const auto at = std::ranges::find_if(feeds_, [&may](const auto& feed) { return feed->choice() == may; });
  if (at != feeds_.end() && client.feed() == *at) return;
  send_batches(true);
  const std::shared_ptr<Feed> feed = at != feeds_.end() ? *at : feeds_.emplace_back(std::make_shared<Feed>(may));
  client.follow(feed, last_ ? last_->tick : 0);
  std::erase_if(feeds_, [&feed](const auto& one) { return one.use_count() == 1 && one != feed; });
}

void Hub::choose(Client& client, const StreamChoice& choice, const std::optional<Resume>& resume) {
  constexpr TopicMask kPlaces = topic_bit(Topic::pose) | topic_bit(Topic::all);
  const bool follows = (client.asked.topics & kPlaces) != 0;
  client.asked = choice;
  assign(client);
  const bool goes_on = resume && last_ && resume->run == std::to_string(services_->core.run());
  if (goes_on) {
    send_batches(true);
    client.begin_anew();
  }
  const StreamChoice& now = client.feed()->choice();
  json topics = json::array();
  for (std::size_t i = 0; i < kTopics.size(); ++i)
    if ((now.topics & topic_bit(static_cast<Topic>(i))) != 0) topics.push_back(kTopics[i].name);
  client.send(json{{"type", "streaming"},
                   {"topics", topics},
                   {"rate_hz", kStreamRates_hz.back() / now.every_ticks},
                   {"every_tick", now.every_step},
                   {"sample_bytes", client.feed()->sample_bytes()}});
  // Its path goes on from here with what it is shown.
  if (!follows && (choice.topics & kPlaces) != 0) client.send(walk_json(services_->state.walk()));
  if (goes_on) refill(client, resume->last_tick);
  if (resume && !goes_on) client.send(gap_json(resume->last_tick + 1, std::nullopt, std::nullopt, GapReason::core_restarted));
}

void Hub::refill(Client& client, std::uint64_t last_tick) {
  Feed past(client.feed()->choice());
  const std::uint64_t most_steps = kRefill_bytes / past.sample_bytes() * past.choice().every_ticks;
  const std::uint64_t oldest = last_->tick >= most_steps ? last_->tick - most_steps + 1 : 0;
  std::uint64_t next = last_tick + 1;
  std::optional<contract::TickRecord> before;
  const auto send = [&client](const Feed::Batch& batch) {
    if (batch.frame) client.send(batch.frame);
  };
  const auto name_missing = [&](std::uint64_t end) {
    send(past.flush());
    past.restart();
    if (const std::uint64_t count = past.due(next, end - 1); count != 0) client.send(gap_json(next, end - 1, count, GapReason::too_old));
  };
  // The step before shows whether the first one changes the state.
  const std::uint64_t first = std::max(next, oldest);
  services_->core.past(first - 1, [&](const contract::TickRecord& record) {
    const bool at_once = !before || changes_at_once(*before, record);
    before = record;
    if (record.tick < first) return;
    if (record.tick > next) name_missing(record.tick);
    past.take(record, at_once);
    if (record.tick % (kRefillSamples * past.choice().every_ticks) == 0) send(past.flush());
    next = record.tick + 1;
  });
  send(past.flush());
  if (next <= last_->tick) name_missing(last_->tick + 1);
}

void Hub::tell_walk() {
  if (!clients_.empty()) broadcast(text_frame(walk_json(services_->state.walk())));
}

void Hub::on_ticks(std::span<const contract::TickRecord> records, std::uint64_t) {
  const std::uint64_t run = services_->core.run();
  const bool anew = run != run_ || (last_ && records.front().tick <= last_->tick);
  run_ = run;
  if (clients_.empty()) {
    batched_ = 0;
    last_ = records.back();
    return;
  }
  if (anew) begin_anew();
  bool changed = false;
  for (const contract::TickRecord& record : records) {
    if (last_ && record.tick > last_->tick + 1) tell_lost(record.tick - 1);
    const bool at_once = !last_ || changes_at_once(*last_, record);
    changed = changed || at_once;
    for (const auto& feed : feeds_) feed->take(record, at_once);
    last_ = record;
    if (++batched_ >= kBatchSamples) send_batches(true);
  }
  // A change of state waits for no batch.
  send_batches(changed);
}

// Another core counts its own steps.
void Hub::begin_anew() {
  send_batches(true);
  last_.reset();
  for (const auto& feed : feeds_) feed->restart();
  for (const auto& client : clients_) client->follow(client->feed(), 0);
}

void Hub::on_core(bool connected) {
  if (!connected) send_batches(true);
  broadcast(text_frame(core_json(services_->core)));
}

void Hub::on_parameters(const contract::ParamsInForce& parameters) { broadcast(text_frame(parameters_message(parameters))); }

void Hub::on_lease(std::uint32_t, std::uint32_t) {
  // Every step is for whoever drives; the next driver asks for it again.
  for (const auto& client : clients_) {
    if (!client->holds_lease()) client->asked.every_step = false;
    assign(*client);
  }
  tell_lease();
}

void Hub::tell_lease(Client& client, json message) {
  message["mine"] = client.holds_lease();
  client.send(message);
}

void Hub::tell_lease() {
  told_asks_ = services_->state.asks().changes();
  const json message = lease_message(*services_);
  const auto all = clients_;
  for (const auto& client : all) tell_lease(*client, message);
}

void Hub::poll_asks(std::uint64_t now_ns) {
  LeaseAsks& asks = services_->state.asks();
  asks.expire(now_ns);
  for (const std::uint32_t refused : asks.take_refused())
    if (const auto at = std::ranges::find_if(clients_, [refused](const auto& client) { return client->number() == refused; });
        at != clients_.end())
      (*at)->send(json{{"type", "notice"}, {"level", "info"}, {"text_key", "lease_kept"}});
  if (asks.changes() != told_asks_) tell_lease();
}

void Hub::on_event(const contract::Event& event) {
  // An answer goes only to the client that asked.
  if (event.kind == contract::EventKind::command_done || event.kind == contract::EventKind::none) return;
  json message = event_json(event);
  message["type"] = "event";
  if (event.client != 0) message["actor"] = client_json(services_->actors, event.client);
  broadcast(text_frame(message));
}

void Hub::poll(std::uint64_t now_ns) {
  if (now_ns - visited_ns_ >= kPing_ns) {
    visited_ns_ = now_ns;
    const auto all = clients_;
    visits_ += all.size();
    for (const auto& client : all) client->visit(now_ns);
    close_ended();
  }
  poll_asks(now_ns);
  if (const std::string_view problem = services_->core.problem(); problem != told_problem_) {
    told_problem_ = problem;
    broadcast(text_frame(core_json(services_->core)));
  }
  const std::uint64_t changes = services_->recorder.changes();
  const auto store_problem = services_->core.store_problem();
  const auto stops_problem = services_->core.stops_problem();
  const auto slow_percent = services_->core.slow_time_percent();
  const std::uint64_t people_changes = services_->people.changes();
  if (changes != recording_changes_ || people_changes != people_changes_ || store_problem != store_problem_ ||
      stops_problem != stops_problem_ || slow_percent != slow_percent_) {
    recording_changes_ = changes;
    people_changes_ = people_changes;
    store_problem_ = store_problem;
    stops_problem_ = stops_problem;
    slow_percent_ = slow_percent;
    tell_recording();
  }
  if (services_->jobs.changes() != told_jobs_ && now_ns - told_jobs_ns_ >= kProgressEvery_ns) tell_jobs(now_ns);
  const FirmwareDesk& firmware = services_->firmware;
  if (firmware.changes() != told_update_ && (!firmware.busy() || now_ns - told_update_ns_ >= kProgressEvery_ns)) {
    told_update_ = firmware.changes();
    told_update_ns_ = now_ns;
    json message = firmware_update_json(firmware);
    message["type"] = "firmware_progress";
    broadcast(text_frame(message));
  }
}

void Hub::tell_jobs(std::uint64_t now_ns) {
  told_jobs_ns_ = now_ns;
  const std::uint64_t changes = services_->jobs.changes();
  for (const JobInfo& info : services_->jobs.list()) {
    if (info.change <= told_jobs_) continue;
    json message = job_json(info);
    message["type"] = "job";
    broadcast(text_frame(message));
  }
  told_jobs_ = changes;
  // A check of the file may have begun or ended a notice.
  tell_recording();
}

void Hub::tell_recording() {
  RecordingStatus status = services_->recorder.status();
  if (status != told_) {
    told_ = std::move(status);
    json message = recording_json(told_);
    message["type"] = "recording";
    broadcast(text_frame(message));
  }
  if (std::vector<StandingNotice> notices = standing_notices(services_->core, services_->recorder, services_->jobs, services_->people);
      notices != told_notices_) {
    told_notices_ = std::move(notices);
    broadcast(text_frame({{"type", "notices"}, {"items", notices_json(told_notices_)}}));
  }
}

void Hub::close_all() {
  ending_ = true;
  const auto all = clients_;
  for (const auto& client : all) client->close(CloseCode::going_away, kEnds);
}

}  // namespace hoist::server
