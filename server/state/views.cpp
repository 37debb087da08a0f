#include "server/state/views.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "control/contract/signals.hpp"
#include "db/summary/provenance.hpp"
#include "server/link/core_desk.hpp"
#include "server/link/firmware_desk.hpp"
#include "server/record/actor_list.hpp"
#include "server/record/reason.hpp"
#include "server/state/hoist_state.hpp"
#include "server/state/lease_asks.hpp"
#include "server/state/rehearsal.hpp"

namespace hoist::server {

using nlohmann::json;

std::string layout_hash_hex() { return db::layout_text(contract::layout_hash()); }

json recording_json(const RecordingStatus& status) {
  json out{{"state", recording_state_name(status.state)},
           {"session", nullptr},
           {"standby", status.standby},
           {"started_utc_ms", nullptr},
           {"samples", status.samples},
           {"durable_tick", nullptr},
           {"detail", status.detail},
           {"reason_code", status.error ? json(reason_name(reason_of(*status.error))) : json(nullptr)}};
  if (status.session) out["session"] = *status.session;
  if (status.started_utc_ms) out["started_utc_ms"] = *status.started_utc_ms;
  if (status.durable_tick) out["durable_tick"] = *status.durable_tick;
  return out;
}

json client_json(const ActorList& actors, std::uint32_t client) {
  const auto known = actors.known(client);
  if (!known) return nullptr;
  json actor = db::actor_json(known->actor);
  if (!known->display_name.empty()) actor["name"] = known->display_name;
  return actor;
}

json lease_json(const CoreDesk& core, const LeaseAsks& asks, const ActorList& actors) {
  json asking = json::array();
  for (const LeaseAsks::Ask& ask : asks.list()) asking.push_back({{"client", ask.client}, {"actor", client_json(actors, ask.client)}});
  const std::uint32_t holder = core.lease_holder();
  return {{"epoch", core.lease_epoch()}, {"holder", holder}, {"actor", client_json(actors, holder)}, {"asking", std::move(asking)}};
}

json chosen_patient_json(const HoistState& state) {
  const auto& patient = state.patient();
  return {{"id", patient ? json(patient->id) : json(nullptr)}, {"code", patient ? json(patient->code) : json(nullptr)}};
}

json patient_json(const db::PatientInfo& p) {
  return {{"id", p.id},
          {"code", p.code},
          {"archived", p.archived},
          {"has_identity", p.has_identity},
          {"visits", p.visits},
          {"sessions", p.sessions},
          {"first_day", p.first_day ? json(*p.first_day) : json(nullptr)},
          {"last_day", p.last_day ? json(*p.last_day) : json(nullptr)},
          {"etag", p.tag}};
}

json visit_json(const db::VisitInfo& v) {
  return {{"id", v.visit.id}, {"patient", v.visit.patient_id}, {"code", v.visit.patient}, {"day", v.visit.day},
          {"note", v.note},   {"sessions", v.sessions},        {"standby", v.standby},    {"etag", v.tag}};
}

json line_json(const db::LineInfo& line) {
  return {{"id", line.id},
          {"name", line.name},
          {"version", line.version},
          {"saved_utc_ms", line.saved_utc_ns / 1'000'000},
          {"exercise", exercise_json(line.exercise)},
          {"length_m", contract::figure_of(line.exercise).length_m()},
          {"etag", line.tag}};
}
json profile_json(const db::ProfileInfo& p) {
  return {{"id", p.id},
          {"patient", p.patient_id},
          {"name", p.name},
          {"version", p.version},
          {"saved_utc_ms", p.utc_ns / 1'000'000},
          {"actor", db::actor_json(p.actor)},
          {"settings", p.settings},
          {"etag", p.tag}};
}

json marker_json(db::SessionId session, const db::MarkerInfo& m) {
  const auto rehearsal = read_rehearsal(m.marker.text);
  return {{"session", session},
          {"number", m.number},
          {"tick", m.marker.tick},
          {"utc_ms", m.marker.utc_ns / 1'000'000},
          {"time_s", m.time_s},
          {"kind", m.marker.kind},
          {"text", m.marker.text},
          {"actor", db::actor_json(m.marker.actor)},
          {"rehearsal", rehearsal ? rehearsal_json(*rehearsal) : json(nullptr)},
          {"etag", m.tag}};
}

json job_json(const JobInfo& info) {
  return {{"id", info.id},
          {"kind", job_kind_info(info.kind).name},
          {"state", job_state_name(info.state)},
          {"progress", info.progress},
          {"actor", db::actor_json(info.actor)},
          {"asked_utc_ms", info.asked_utc_ms},
          {"ended_utc_ms", info.ended_utc_ms ? json(*info.ended_utc_ms) : json(nullptr)},
          {"detail", info.detail},
          {"reason_code", info.reason ? json(reason_name(*info.reason)) : json(nullptr)}};
}

json file_health_json(const FileHealth& file) {
  return {{"state", file_state_name(file.state)},
          {"progress", file.progress},
          {"checked_utc_ms", file.checked_utc_ms ? json(*file.checked_utc_ms) : json(nullptr)},
          {"damaged_blobs", file.damaged_blobs},
          {"damaged_sessions", file.damaged_sessions},
          {"detail", file.detail}};
}

json firmware_update_json(const FirmwareDesk& desk) {
  constexpr std::array<std::string_view, 9> kPhases{"listening", "asking_drives", "asking_node", "entering_loader", "sending",
                                                    "checking",  "starting",      "done",        "failed"};
  constexpr std::array<std::string_view, 5> kResults{"running", "done", "unchanged", "failed", "interrupted"};
  if (!desk.state()) return nullptr;
  const FirmwareUpdateState& state = *desk.state();
  return {{"node", contract::kNodes[static_cast<std::size_t>(state.node)].name},
          {"version", version_text(state.version)},
          {"phase", kPhases[static_cast<std::size_t>(state.phase)]},
          {"result", kResults[static_cast<std::size_t>(state.result)]},
          {"bytes_sent", state.bytes_sent},
          {"bytes_total", state.bytes_total},
          {"seconds_left", state.seconds_left ? json(*state.seconds_left) : json(nullptr)},
          {"text", state.text}};
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version >> 16) + "." + std::to_string((version >> 8) & 0xFFU) + "." + std::to_string(version & 0xFFU);
}

}  // namespace hoist::server
