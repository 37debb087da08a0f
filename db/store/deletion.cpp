#include "db/store/deletion.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/edit_tag.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {
namespace {

// Health data: freed pages are overwritten, also those the log still holds (truncate_log).
class SecureDelete {
 public:
  explicit SecureDelete(sqlite3* handle) : handle_(handle) { try_execute(handle, "PRAGMA secure_delete = ON"); }
  ~SecureDelete() {
    try_execute(handle_, "PRAGMA secure_delete = OFF");
    try_execute(handle_, "PRAGMA foreign_keys = ON");
  }
  SecureDelete(const SecureDelete&) = delete;
  SecureDelete& operator=(const SecureDelete&) = delete;

 private:
  sqlite3* handle_;
};

constexpr std::array<std::string_view, 4> kErasedTables{"chunks", "bus_chunks", "journal_chunks", "core_images"};

// Rows of all tables that belong to a session but the large ones, whichever tables there are.
void delete_small_rows(sqlite3* handle, SessionId session) {
  std::vector<std::string> deletions;
  Statement tables(handle,
                   "SELECT m.name, f.\"from\" FROM sqlite_schema AS m, pragma_foreign_key_list(m.name) AS f "
                   "WHERE m.type = 'table' AND f.\"table\" = 'sessions'");
  while (tables.step())
    if (const std::string name = tables.text_at(0); std::ranges::find(kErasedTables, name) == kErasedTables.end())
      deletions.push_back("DELETE FROM " + name + " WHERE " + tables.text_at(1) + " = ?1");
  for (const std::string& sql : deletions) Statement(handle, sql).integer(1, session).run();
}

}  // namespace

Status take_out(Database& database, SessionId session, const std::string& expected) {
  sqlite3* handle = database.handle();
  const SecureDelete secure(handle);
  // Without them the session's row goes, and its blobs stay for erase_piece.
  try_execute(handle, "PRAGMA foreign_keys = OFF");
  return guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    {
      Statement row(handle,
                    "SELECT ended_utc_ns, note, code, exercise FROM sessions LEFT JOIN visits ON visits.id = visit_id "
                    "LEFT JOIN patients ON patients.id = patient_id WHERE sessions.id = ?1");
      if (!row.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
      if (row.is_null(0))
        return Error{ErrorKind::wrong_state, "session " + std::to_string(session) + " is being recorded: end it first", {}};
      const std::string tag = session_tag(row.text_at(1), row.optional_text_at(2), row.optional_text_at(3));
      if (Status same = check_tag(expected, tag); !same) return same;
    }
    Statement(handle, "INSERT INTO deletions (session_id) VALUES (?1)").integer(1, session).run();
    delete_small_rows(handle, session);
    Statement(handle, "DELETE FROM sessions WHERE id = ?1").integer(1, session).run();
    transaction.commit();
    return {};
  });
}

Result<bool> erase_piece(Database& database) {
  sqlite3* handle = database.handle();
  const SecureDelete secure(handle);
  auto more = guarded([&]() -> Result<bool> {
    SessionId session = 0;
    {
      Statement first(handle, "SELECT session_id FROM deletions ORDER BY session_id LIMIT 1");
      if (!first.step()) return false;
      session = first.integer_at(0);
    }
    Transaction transaction(handle, Transaction::Kind::write);
    // Here and not in take_out: what belongs to a patient goes by its foreign keys.
    drop_empty_visits(handle);
    std::size_t room = kErasedRows;
    for (const std::string_view table : kErasedTables) {
      const std::string name(table);
      Statement(handle, "DELETE FROM " + name + " WHERE id IN (SELECT id FROM " + name + " WHERE session_id = ?1 LIMIT ?2)")
          .integer(1, session)
          .unsigned_integer(2, room)
          .run();
      room -= static_cast<std::size_t>(sqlite3_changes(handle));
      if (room == 0) break;
    }
    if (room > 0) Statement(handle, "DELETE FROM deletions WHERE session_id = ?1").integer(1, session).run();
    transaction.commit();
    return true;
  });
  if (more && !*more) truncate_log(handle);
  return more;
}

void truncate_log(sqlite3* handle) noexcept {
  constexpr int kTruncateWait_ms = 200;
  sqlite3_busy_timeout(handle, kTruncateWait_ms);
  try_execute(handle, "PRAGMA wal_checkpoint(TRUNCATE)");
  sqlite3_busy_timeout(handle, kBusyTimeout_ms);
}

}  // namespace hoist::db
