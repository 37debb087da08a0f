// /health: nodes and bus, in one answer for scripts and for a console that was just opened.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/emergencies.hpp"
#include "server/api/handlers.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {

constexpr unsigned kOldestTicks = 255, kNmtUnknown = 255, kNmtOperational = 5;
constexpr std::uint16_t kNoCanId = 0xFFFF;
constexpr double kTick_s = 0.01;
// As the core judges: process data older than 50 ms come from a lost node.
constexpr unsigned kLostTicks = 5;

// A live value of one node, whose name begins with the node's; 0 for a row that the table has lost.
unsigned value_of(const contract::TickRecord& record, const contract::NodeInfo& node, std::string_view what) {
  const auto index = contract::find_signal(std::string(node.name) + std::string(what));
  return index ? static_cast<unsigned>(contract::signal_value(record, *index)) : 0U;
}

json words(std::string_view en, std::string_view de) { return {{"en", en}, {"de", de}}; }

json emergency_json(std::uint16_t code) {
  const contract::EmergencyInfo& info = contract::emergency_info(code);
  return {
      {"code", code}, {"name", info.name}, {"text", words(info.text_en, info.text_de)}, {"detail", words(info.detail_en, info.detail_de)}};
}

json node_json(const contract::TickRecord& record, const contract::NodeInfo& node) {
  const auto value = [&](std::string_view what) { return value_of(record, node, what); };
  const unsigned age = value("_age_ticks"), state = value("_nmt_state"), lately = value("_lost_10s"), code = value("_emcy_code");
  const bool answers = age < kLostTicks;
  const bool lives = state != kNmtUnknown && value("_heartbeats_missed") == 0;
  const char* word = "silent";
  if (answers) {
    word = lately > 0 ? "losing" : "working";
  } else if (lives && state != kNmtOperational) {
    word = "waiting";
  }
  return {{"name", node.name},
          {"id", node.id},
          {"state", word},
          {"age_s", age < kOldestTicks ? json(static_cast<double>(age) * kTick_s) : json(nullptr)},
          {"heartbeats_missed", value("_heartbeats_missed")},
          {"nmt_state", state == kNmtUnknown ? json(nullptr) : json(state)},
          {"lost_frames", value("_lost_frames")},
          {"lost_10s", lately},
          {"error_register", value("_error_register")},
          {"emergencies", value("_emcy_count")},
          {"latest_emergency", code == 0 ? json(nullptr) : emergency_json(static_cast<std::uint16_t>(code))}};
}

json bus_json(const contract::TickRecord& record) {
  constexpr std::array kStates = {"active", "warning", "passive", "off"};
  return {{"up", record.bus_up != 0},
          {"state", kStates[std::min<std::size_t>(record.bus_state, kStates.size() - 1)]},
          {"load_norm", record.bus_load_norm},
          {"frames_per_s", record.bus_frames_per_s},
          {"received", record.bus_frames},
          {"refused", record.bus_refused},
          {"send_refused", record.bus_send_refused},
          {"reopened", record.bus_reopened},
          {"overflows", record.bus_overflows},
          {"errors", record.bus_errors},
          {"tx_errors", record.bus_tx_errors},
          {"rx_errors", record.bus_rx_errors},
          {"syncs_lost", record.syncs_lost},
          {"duplicate_id", record.duplicate_id == 0 ? json(nullptr) : json(record.duplicate_id)},
          {"babbling_id", record.babbling_id == kNoCanId ? json(nullptr) : json(record.babbling_id)}};
}

}  // namespace

void get_health(const CallPtr& call) {
  const Services& s = call->services;
  json nodes = json::array(), emergencies = json::array();
  json bus = nullptr;
  const auto& newest = s.core.newest();
  if (newest && s.core.connected()) {
    for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) nodes.push_back(node_json(*newest, contract::kNodes[n]));
    bus = bus_json(*newest);
  }
  const std::uint64_t now_ns = newest ? newest->time_ns : 0;
  const auto& kept = s.state.emergencies();
  for (auto event = kept.rbegin(); event != kept.rend(); ++event) {
    const bool known = event->item < contract::kNodes.size();
    emergencies.push_back({{"node", known ? contract::kNodes[event->item].name : std::string_view{}},
                           {"time_ns", event->time_ns},
                           {"age_s", now_ns > event->time_ns ? static_cast<double>(now_ns - event->time_ns) * 1e-9 : 0.0},
                           {"error_register", event->bits & 0xFFU},
                           {"emergency", emergency_json(static_cast<std::uint16_t>(event->code & 0xFFFFU))}});
  }
  call->respond(json{{"connected", s.core.connected()},
                     {"nodes", std::move(nodes)},
                     {"bus", std::move(bus)},
                     {"emergencies", std::move(emergencies)},
                     {"recordings", file_health_json(s.jobs.file_health())}});
}

}  // namespace hoist::server::api
