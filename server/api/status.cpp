// /status: what runs, what is wrong, what was refused.
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "server/api/actions.hpp"
#include "server/api/alarms.hpp"
#include "server/api/handlers.hpp"
#include "server/live/hub.hpp"
#include "server/live/notices.hpp"
#include "server/live/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
std::string iso_utc(std::int64_t utc_ns) {
  const std::time_t seconds = utc_ns / 1'000'000'000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts)};
}
}  // namespace

void get_status(const CallPtr& call) {
  const Services& s = call->services;
  const std::string_view problem = s.core.problem();
  json core{{"connected", s.core.connected()},
            {"problem", problem.empty() ? json(nullptr) : json(problem)},
            {"mode", nullptr},
            {"faults", json::array()},
            {"alarms", json::array()},
            {"blocked", json::array()},
            {"standing_still", nullptr},
            {"tick", nullptr},
            {"bus", nullptr}};
  bool simulated = s.settings.scenario.has_value();
  if (const auto& newest = s.core.newest(); newest && s.core.connected()) {
    simulated = newest->simulated != 0;
    core["mode"] = newest->mode < contract::kModes.size() ? json(contract::kModes[newest->mode].name) : json(nullptr);
    core["faults"] = fault_names(newest->fault_bits);
    core["alarms"] = alarms_json(*newest);
    core["blocked"] = refusal_names(newest->blocked_bits);
    core["standing_still"] = newest->standing_still != 0;
    core["tick"] = newest->tick;
    core["bus"] = {{"frames", newest->bus_frames}, {"refused", newest->bus_refused}};
  }
  json counters = json::object();
  for (std::size_t i = 0; i < kCounterNames.size(); ++i) counters[std::string{kCounterNames[i]}] = s.counters.get(i);
  call->respond(
      json{{"version", kVersion},
           {"started", iso_utc(s.started_utc_ns)},
           {"simulated", simulated},
           {"scenario", s.settings.scenario ? json(*s.settings.scenario) : json(nullptr)},
           {"core", std::move(core)},
           {"recording", recording_json(s.recorder.status())},
           {"notices", notices_json(standing_notices(s))},
           {"lease", {{"holder", s.core.lease_holder()}, {"epoch", s.core.lease_epoch()}}},
           {"clients", s.hub.clients()},
           {"counters", std::move(counters)},
           {"server", {{"uptime_s", static_cast<double>(s.now_ns() - s.started_ns) * 1e-9}, {"layout_hash", layout_hash_hex()}}}});
}

}  // namespace hoist::server::api
