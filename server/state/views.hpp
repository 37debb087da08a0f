// How states look as JSON, the same in WebSocket messages and REST answers.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "control/contract/params.hpp"
#include "db/store/lines.hpp"
#include "db/store/markers.hpp"
#include "db/store/profiles.hpp"
#include "db/store/visits.hpp"
#include "server/jobs/jobs.hpp"
#include "server/record/recorder.hpp"

namespace hoist::server {

class ActorList;
class CoreDesk;
class FirmwareDesk;
class HoistState;
class LeaseAsks;

// The running or the last update; null before the first.
[[nodiscard]] nlohmann::json firmware_update_json(const FirmwareDesk& desk);
[[nodiscard]] std::string version_text(std::uint32_t version);
// Without its result.
[[nodiscard]] nlohmann::json job_json(const JobInfo& info);
[[nodiscard]] nlohmann::json file_health_json(const FileHealth& file);
[[nodiscard]] nlohmann::json recording_json(const RecordingStatus& status);
// Who drives and who asks for it, by number and actor.
// Who is behind a number: the actor, with the name that screens show while the client is known; null = not known.
[[nodiscard]] nlohmann::json client_json(const ActorList& actors, std::uint32_t client);
[[nodiscard]] nlohmann::json lease_json(const CoreDesk& core, const LeaseAsks& asks, const ActorList& actors);
[[nodiscard]] nlohmann::json chosen_patient_json(const HoistState& state);
// Rows that people edit; `etag` is what a change of them is made for.
[[nodiscard]] nlohmann::json patient_json(const db::PatientInfo& patient);
[[nodiscard]] nlohmann::json visit_json(const db::VisitInfo& visit);
[[nodiscard]] nlohmann::json line_json(const db::LineInfo& line);
[[nodiscard]] nlohmann::json profile_json(const db::ProfileInfo& profile);
[[nodiscard]] nlohmann::json marker_json(db::SessionId session, const db::MarkerInfo& marker);
[[nodiscard]] std::string layout_hash_hex();
[[nodiscard]] constexpr std::string_view access_role(contract::Role role) {
  return role == contract::Role::viewer ? "viewer" : role == contract::Role::therapist ? "therapist" : "engineer";
}

}  // namespace hoist::server
