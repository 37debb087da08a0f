#include "db/store/studies.hpp"

#include <sqlite3.h>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

Error no_such_study(StudyId study) { return {ErrorKind::not_found, "there is no study " + std::to_string(study), {}}; }

// The other file as the schema "made", as long as this lives.
class OtherFile {
 public:
  OtherFile(sqlite3* handle, const std::filesystem::path& file) : handle_(handle) {
    const std::string name = file.string();
    Statement(handle, "ATTACH ?1 AS made").text(1, std::string_view(name)).run();
  }
  ~OtherFile() { try_execute(handle_, "DETACH made"); }
  OtherFile(const OtherFile&) = delete;
  OtherFile& operator=(const OtherFile&) = delete;

 private:
  sqlite3* handle_;
};

// Columns of a table but those that only one file knows, separated by commas.
std::string columns_of(sqlite3* handle, const std::string& table) {
  std::string names;
  Statement columns(handle, "SELECT name FROM pragma_table_info(?1) WHERE name NOT IN ('id', 'session_id', 'actor_id', 'visit_id')");
  columns.text(1, std::string_view(table));
  while (columns.step()) names += (names.empty() ? "" : ", ") + ("\"" + columns.text_at(0) + "\"");
  return names;
}

// Everything that is recorded of a session, whichever tables there are.
std::vector<std::string> recorded_tables(sqlite3* handle) {
  std::vector<std::string> names;
  Statement tables(handle,
                   "SELECT DISTINCT m.name FROM sqlite_schema AS m, pragma_foreign_key_list(m.name) AS f "
                   "WHERE m.type = 'table' AND f.\"table\" = 'sessions' AND f.\"from\" = 'session_id' AND m.name <> 'study_runs'");
  while (tables.step()) names.push_back(tables.text_at(0));
  return names;
}

SessionId copy_session(sqlite3* handle, SessionId session) {
  const std::string names = columns_of(handle, "sessions");
  SessionId copied = 0;
  {
    Statement row(handle, "INSERT INTO main.sessions (" + names + ") SELECT " + names + " FROM made.sessions WHERE id = ?1 RETURNING id");
    if (!row.integer(1, session).step())
      throw SqlFailure{Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}}};
    copied = row.integer_at(0);
  }
  Statement(handle,
            "INSERT OR IGNORE INTO main.column_layout SELECT * FROM made.column_layout "
            "WHERE hash = (SELECT columns_hash FROM made.sessions WHERE id = ?1)")
      .integer(1, session)
      .run();
  for (const std::string& table : recorded_tables(handle)) {
    const std::string columns = columns_of(handle, table);
    Statement(handle, "INSERT INTO main." + table + " (session_id, " + columns + ") SELECT ?1, " + columns + " FROM made." + table +
                          " WHERE session_id = ?2")
        .integer(1, copied)
        .integer(2, session)
        .run();
  }
  return copied;
}

void insert_run(sqlite3* handle, SessionId session, const StudyRun& run) {
  Statement(handle, "INSERT INTO study_runs (session_id, study_id, subject, run) VALUES (?1, ?2, ?3, ?4)")
      .integer(1, session)
      .integer(2, run.study)
      .text(3, std::string_view(run.subject))
      .integer(4, run.run)
      .run();
}

StudyRow row_of(sqlite3* handle, const Statement& row) {
  StudyRow out{.id = row.integer_at(0), .made_utc_ns = row.integer_at(1), .report = row.text_at(2), .drawings = {}, .sessions = {}};
  Statement drawings(handle, "SELECT name FROM study_drawings WHERE study_id = ?1 ORDER BY name");
  drawings.integer(1, out.id);
  while (drawings.step()) out.drawings.push_back(drawings.text_at(0));
  Statement runs(handle, "SELECT session_id, subject, run FROM study_runs WHERE study_id = ?1 ORDER BY session_id");
  runs.integer(1, out.id);
  while (runs.step())
    out.sessions.push_back({.session = runs.integer_at(0), .subject = runs.text_at(1), .run = static_cast<int>(runs.integer_at(2))});
  return out;
}

}  // namespace

Result<StudyId> begin_study(Database& database, std::int64_t made_utc_ns) {
  return guarded([&]() -> Result<StudyId> {
    Statement row(database.handle(), "INSERT INTO studies (made_utc_ns) VALUES (?1) RETURNING id");
    row.integer(1, made_utc_ns).step();
    const StudyId study = row.integer_at(0);
    row.step();
    return study;
  });
}

Status mark_run(Database& database, SessionId session, const StudyRun& run) {
  return guarded([&]() -> Status {
    insert_run(database.handle(), session, run);
    return {};
  });
}

Result<SessionId> take_run(Database& database, const std::filesystem::path& from, SessionId session, const StudyRun& run) {
  return guarded([&]() -> Result<SessionId> {
    sqlite3* handle = database.handle();
    const OtherFile other(handle, from);
    {
      Statement version(handle, "PRAGMA made.user_version");
      if (!version.step() || version.integer_at(0) != schema_version())
        return Error{ErrorKind::wrong_state, from.string() + " is not of this program's schema", {}};
    }
    SessionId copied = 0;
    {
      Transaction transaction(handle, Transaction::Kind::write);
      copied = copy_session(handle, session);
      insert_run(handle, copied, run);
      transaction.commit();
    }
    return copied;
  });
}

Status finish_study(Database& database, StudyId study, std::string_view report, const std::vector<StudyDrawing>& drawings) {
  return guarded([&]() -> Status {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::write);
    Statement(handle, "UPDATE studies SET report = ?2 WHERE id = ?1").integer(1, study).text(2, report).run();
    if (sqlite3_changes(handle) == 0) return no_such_study(study);
    for (const StudyDrawing& drawing : drawings)
      Statement(handle, "INSERT INTO study_drawings (study_id, name, svg) VALUES (?1, ?2, ?3)")
          .integer(1, study)
          .text(2, std::string_view(drawing.name))
          .text(3, std::string_view(drawing.svg))
          .run();
    transaction.commit();
    return {};
  });
}

Result<std::vector<StudyRow>> list_studies(Database& database, std::optional<StudyId> before, std::size_t limit) {
  return guarded([&]() -> Result<std::vector<StudyRow>> {
    Transaction transaction(database.handle(), Transaction::Kind::read);
    std::vector<StudyRow> all;
    Statement rows(database.handle(),
                   "SELECT id, made_utc_ns, report FROM studies WHERE report IS NOT NULL AND id < ?1 ORDER BY id DESC LIMIT ?2");
    rows.integer(1, before.value_or(INT64_MAX)).unsigned_integer(2, limit);
    while (rows.step()) all.push_back(row_of(database.handle(), rows));
    return all;
  });
}

Result<StudyRow> read_study(Database& database, StudyId study) {
  return guarded([&]() -> Result<StudyRow> {
    Transaction transaction(database.handle(), Transaction::Kind::read);
    Statement row(database.handle(), "SELECT id, made_utc_ns, report FROM studies WHERE id = ?1 AND report IS NOT NULL");
    if (!row.integer(1, study).step()) return no_such_study(study);
    return row_of(database.handle(), row);
  });
}

Result<std::string> study_drawing(Database& database, StudyId study, std::string_view name) {
  return guarded([&]() -> Result<std::string> {
    Statement row(database.handle(), "SELECT svg FROM study_drawings WHERE study_id = ?1 AND name = ?2");
    if (!row.integer(1, study).text(2, name).step())
      return Error{ErrorKind::not_found, "study " + std::to_string(study) + " has no such drawing", {}};
    return row.text_at(0);
  });
}

Result<std::vector<StudyId>> unfinished_studies(Database& database) {
  return guarded([&]() -> Result<std::vector<StudyId>> {
    std::vector<StudyId> ids;
    Statement rows(database.handle(), "SELECT id FROM studies WHERE report IS NULL ORDER BY id");
    while (rows.step()) ids.push_back(rows.integer_at(0));
    return ids;
  });
}

Result<std::vector<SessionId>> study_sessions(Database& database, StudyId study) {
  return guarded([&]() -> Result<std::vector<SessionId>> {
    std::vector<SessionId> ids;
    Statement rows(database.handle(), "SELECT session_id FROM study_runs WHERE study_id = ?1 ORDER BY session_id");
    rows.integer(1, study);
    while (rows.step()) ids.push_back(rows.integer_at(0));
    return ids;
  });
}

Status remove_study(Database& database, StudyId study) {
  return guarded([&]() -> Status {
    Statement(database.handle(), "DELETE FROM studies WHERE id = ?1").integer(1, study).run();
    if (sqlite3_changes(database.handle()) == 0) return no_such_study(study);
    return {};
  });
}

}  // namespace hoist::db
