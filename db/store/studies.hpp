// Studies of virtual subjects beside the recordings of people: their sessions, report and drawings (db/schema, table `studies`).
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

using StudyId = std::int64_t;

struct StudyDrawing {
  std::string name, svg;
};
struct StudySession {
  SessionId session = 0;
  std::string subject;
  int run = 0;
};
struct StudyRow {
  StudyId id = 0;
  std::int64_t made_utc_ns = 0;
  std::string report;  ///< JSON as `hoist study --json` writes it
  std::vector<std::string> drawings;
  std::vector<StudySession> sessions;  ///< that are still there, oldest first
};

/// Begins a study: no list tells it before `finish_study`. Errors: busy, disk_full, io.
Result<StudyId> begin_study(Database& database, std::int64_t made_utc_ns);
/// Says that a session of this file, which has ended, is a run of a study of this file. Errors: not_found, busy, disk_full, io.
Status mark_run(Database& database, SessionId session, const StudyRun& run);
/// Copies one session of another file into `database`, in one transaction: without patient and visit, as subject and run of `study`. The other
/// file must have this program's schema and be written by nobody; its rows of actors are not taken. Errors: not_found, wrong_state (another
/// schema), busy, disk_full, io.
Result<SessionId> take_run(Database& database, const std::filesystem::path& from, SessionId session, const StudyRun& run);
/// From here on lists tell the study. Errors: not_found, busy, disk_full, io.
Status finish_study(Database& database, StudyId study, std::string_view report, const std::vector<StudyDrawing>& drawings);

/// Finished studies, newest first, those with numbers below `before`.
Result<std::vector<StudyRow>> list_studies(Database& database, std::optional<StudyId> before, std::size_t limit);
/// Errors: not_found (also: not finished).
Result<StudyRow> read_study(Database& database, StudyId study);
/// Errors: not_found.
Result<std::string> study_drawing(Database& database, StudyId study, std::string_view name);
/// Those that a process which ended has left unfinished.
Result<std::vector<StudyId>> unfinished_studies(Database& database);
/// Sessions of a study, finished or not, oldest first.
Result<std::vector<SessionId>> study_sessions(Database& database, StudyId study);
/// The study's own rows; what is left of its sessions becomes plain sessions of the simulator. Errors: not_found, busy.
Status remove_study(Database& database, StudyId study);

}  // namespace hoist::db
