// /status: what runs, what is wrong, what was refused.
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "control/contract/program_version.hpp"
#include "server/actions/actions.hpp"
#include "server/api/alarms.hpp"
#include "server/api/handlers.hpp"
#include "server/state/notices.hpp"
#include "server/state/views.hpp"
#include "server/text/json_writer.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
constexpr std::size_t kExpected_bytes = 2048;

std::string iso_utc(std::int64_t utc_ns) {
  const std::time_t seconds = utc_ns / 1'000'000'000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  char text[32];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts)};
}
}  // namespace

namespace {
void write_names(JsonWriter& out, std::string_view name, const std::vector<std::string>& names) {
  out.key(name).begin('[');
  for (const std::string& one : names) out.value(one);
  out.end(']');
}

void write_core(JsonWriter& out, const Services& s, const contract::TickRecord* newest) {
  const std::string_view problem = s.core.problem();
  const std::string& version = s.core.link().program();
  out.key("core").begin('{').field("connected", s.core.connected());
  if (version.empty())
    out.field("version", nullptr);
  else
    out.field("version", version);
  if (problem.empty())
    out.field("problem", nullptr);
  else
    out.field("problem", problem);
  if (newest == nullptr || newest->mode >= contract::kModes.size())
    out.field("mode", nullptr);
  else
    out.field("mode", contract::kModes[newest->mode].name);
  write_names(out, "faults", newest != nullptr ? fault_names(newest->fault_bits) : std::vector<std::string>{});
  out.key("alarms");
  if (newest != nullptr)
    write_alarms(out, *newest);
  else
    out.begin('[').end(']');
  write_names(out, "blocked", newest != nullptr ? refusal_names(newest->blocked_bits) : std::vector<std::string>{});
  if (newest == nullptr) {
    out.field("standing_still", nullptr).field("tick", nullptr).field("bus", nullptr);
  } else {
    out.field("standing_still", newest->standing_still != 0).field("tick", newest->tick).key("bus").begin('{');
    out.field("frames", newest->bus_frames).field("refused", newest->bus_refused).end('}');
  }
  out.end('}');
}

void write_counters(JsonWriter& out, const Counters& counters) {
  out.key("counters").begin('{');
  for (std::size_t i = 0; i < kCounterNames.size(); ++i) out.field(kCounterNames[i], counters.get(i));
  out.end('}');
}
}  // namespace

void get_status(const CallPtr& call) {
  const Services& s = call->services;
  const auto& step = s.core.newest();
  const contract::TickRecord* newest = step && s.core.connected() ? &*step : nullptr;
  JsonWriter out(kExpected_bytes);
  out.begin('{');
  if (const std::string& id = s.state.device().hoist_id; id.empty())
    out.field("hoist_id", nullptr);
  else
    out.field("hoist_id", id);
  out.field("version", contract::program_version()).field("started", iso_utc(s.started_utc_ns));
  out.field("simulated", newest != nullptr ? newest->simulated != 0 : s.settings.scenario.has_value());
  if (s.settings.scenario)
    out.field("scenario", *s.settings.scenario);
  else
    out.field("scenario", nullptr);
  write_core(out, s, newest);
  out.field("recording", recording_json(s.recorder.status()))
      .field("notices", notices_json(standing_notices(s.core, s.recorder, s.jobs, s.people)));
  out.field("lease", lease_json(s.core, s.state.asks(), s.actors));
  out.field("clients", s.live_clients);
  write_counters(out, s.counters);
  out.key("server").begin('{').field("uptime_s", static_cast<double>(s.now_ns() - s.started_ns) * 1e-9);
  out.field("layout_hash", layout_hash_hex()).end('}').end('}');
  Response response;
  response.content_type = "application/json";
  response.body = out.take();
  call->respond(std::move(response));
}

}  // namespace hoist::server::api
