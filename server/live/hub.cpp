#include "server/live/hub.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "control/contract/calibration.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/program_version.hpp"
#include "db/summary/provenance.hpp"
#include "server/actions/actions.hpp"
#include "server/record/reason.hpp"
#include "server/state/notices.hpp"
#include "server/state/views.hpp"
#include "server/text/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
// A batch is sent at the latest this many samples after it began, whatever was lost in between.
constexpr std::size_t kBatchLimit = 64;
constexpr std::uint64_t kProgressEvery_ns = 250'000'000;
constexpr std::string_view kEnds = "the server ends";
constexpr std::string_view kSignedOut = "signed out";

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}

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
          {"reason_code", reason ? json(reason_name(*reason)) : json(nullptr)}};
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

SharedFrame TelemetryFrames::encode(std::span<const contract::TickRecord> records) {
  const auto free = std::ranges::find_if(kept_, [](const auto& kept) { return kept.use_count() <= 1; });
  auto frame = free != kept_.end() && *free ? *free : std::make_shared<std::string>();
  if (free != kept_.end()) *free = frame;
  frame->clear();
  begin_frame(*frame, Opcode::binary, 16 + records.size_bytes());
  put(*frame, 1, 1);  // kind: tick records
  put(*frame, 1, 1);  // version
  put(*frame, records.size(), 2);
  put(*frame, sizeof(contract::TickRecord), 4);
  put(*frame, contract::layout_hash(), 8);
  // Little endian in memory as on the wire: every machine this runs on is.
  static_assert(std::endian::native == std::endian::little);
  frame->append(reinterpret_cast<const char*>(records.data()), records.size_bytes());
  return frame;
}

Hub::Hub() { batch_.reserve(kBatchLimit); }
Hub::~Hub() = default;

void Hub::set_services(Services& services, Auth& auth) {
  services_ = &services;
  auth_ = &auth;
  services.state.set_on_walk([this] { tell_walk(); });
  services.state.set_on_patient([this] { broadcast(text_frame(patient_message(services_->state))); });
}

void Hub::open(std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session) {
  services_->counters.add(Count::ws_opened);
  const std::uint32_t number =
      services_->actors.enter({session->user, std::string{access_role(session->role)}, "hoist.v1", client_name(*session)});
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

void Hub::close_ended() {
  const auto utc_s = static_cast<std::uint64_t>(services_->utc_ns() / 1'000'000'000);
  const auto& newest = services_->core.newest();
  const bool moving = newest && newest->standing_still == 0;
  // A sign-in that runs out must not stop a hoist that a hand drives: its socket is closed as soon as the hoist stands.
  const auto clients = clients_;
  for (const auto& client : clients) {
    const Session& session = *client->session();
    if (Auth::over(session, utc_s) && (session.ended || !moving || !client->holds_lease())) client->close(CloseCode::policy, kSignedOut);
  }
}

void Hub::use(Session& session) { auth_->use(session, static_cast<std::uint64_t>(services_->utc_ns() / 1'000'000'000)); }

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
  client->send(json{{"type", "notices"}, {"items", notices_json(standing_notices(s.core, s.recorder, s.jobs))}});
  ++client->session()->sockets;
  clients_.push_back(std::move(client));
  services_->live_clients = clients_.size();
}

void Hub::remove(const Client* client) {
  const auto at = std::find_if(clients_.begin(), clients_.end(), [client](const auto& c) { return c.get() == client; });
  if (at == clients_.end()) return;
  const std::shared_ptr<Client> held = *at;
  clients_.erase(at);
  --held->session()->sockets;
  services_->live_clients = clients_.size();
  services_->actors.leave(held->number());
  services_->state.asks().remove(held->number());
  // A client that is gone no longer drives: the core is told, stops remote motion and frees the lease.
  if (held->holds_lease())
    act_release_lease(*services_, {held->number(), services_->core.lease_epoch(), held->session()->role}, [](const Outcome&) {});
}

void Hub::broadcast(const SharedFrame& frame) {
  // A client that is closed for being slow leaves the list while we go through it.
  const auto all = clients_;
  for (const auto& client : all) client->send(frame);
}

void Hub::send_batch() {
  if (batch_.empty()) return;
  const SharedFrame frame = frames_.encode(batch_);
  batch_.clear();
  for (const auto& client : clients_)
    if (!client->every_tick()) client->send_telemetry(frame);
}

void Hub::set_every_tick(Client& client, bool on) {
  if (client.every_tick() == on) return;
  send_batch();
  client.set_every_tick(on);
}

void Hub::tell_walk() {
  if (!clients_.empty()) broadcast(text_frame(walk_json(services_->state.walk())));
}

void Hub::on_ticks(std::span<const contract::TickRecord> records, std::uint64_t) {
  if (clients_.empty()) {
    batch_.clear();
    return;
  }
  if (std::any_of(clients_.begin(), clients_.end(), [](const auto& c) { return c->every_tick(); })) {
    const SharedFrame frame = frames_.encode(records);
    for (const auto& client : clients_)
      if (client->every_tick()) client->send_telemetry(frame);
  }
  for (const contract::TickRecord& record : records) {
    batch_.push_back(record);
    if (batch_.size() >= kBatchSamples) send_batch();
  }
}

void Hub::on_core(bool connected) {
  if (!connected) batch_.clear();
  broadcast(text_frame(core_json(services_->core)));
}

void Hub::on_parameters(const contract::ParamsInForce& parameters) { broadcast(text_frame(parameters_message(parameters))); }

void Hub::on_lease(std::uint32_t, std::uint32_t) {
  // Every step is for whoever drives; the next driver asks for it again.
  for (const auto& client : clients_)
    if (!client->holds_lease()) set_every_tick(*client, false);
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
  if (event.client != 0) message["actor"] = db::actor_json(services_->actors.find(event.client));
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
  const auto slow_percent = services_->core.slow_time_percent();
  if (changes != recording_changes_ || store_problem != store_problem_ || slow_percent != slow_percent_) {
    recording_changes_ = changes;
    store_problem_ = store_problem;
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
  if (std::vector<StandingNotice> notices = standing_notices(services_->core, services_->recorder, services_->jobs);
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
