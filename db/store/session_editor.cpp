#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/codec/exercise_json.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {
namespace {

// Whole UTF-8 sequences and nothing below a space but tab and line end: what people type, not what breaks a terminal or a file.
bool plain_text(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < 0x20 && c != '\n' && c != '\t') return false;
    if (c == 0x7F) return false;
    const std::size_t length = c < 0x80 ? 1 : (c >> 5) == 6 ? 2 : (c >> 4) == 14 ? 3 : (c >> 3) == 30 ? 4 : 0;
    if (length == 0 || i + length > text.size()) return false;
    for (std::size_t k = 1; k < length; ++k)
      if ((static_cast<unsigned char>(text[i + k]) >> 6) != 2) return false;
    i += length;
  }
  return true;
}

}  // namespace

Status check_subject(const std::optional<std::string>& subject) {
  if (!subject) return {};
  if (subject->empty() || subject->size() > kMaxSubject_bytes || !plain_text(*subject) || subject->find('\n') != std::string::npos)
    return Error{ErrorKind::bad_value, "subject must be a code of 1 to 64 bytes in one line", "subject"};
  return {};
}

Status check_note(std::string_view note) {
  if (note.size() > kMaxNote_bytes || !plain_text(note))
    return Error{ErrorKind::bad_value, "note must be plain text of at most 4000 bytes", "note"};
  return {};
}

Status SessionEditor::patch(SessionId session, const SessionPatch& change) {
  if (change.note)
    if (Status checked = check_note(*change.note); !checked) return checked;
  if (change.subject)
    if (Status checked = check_subject(*change.subject); !checked) return checked;
  if (change.exercise_json && *change.exercise_json)
    if (Status checked = check_exercise(**change.exercise_json); !checked) return checked;
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    std::int64_t started_utc_ns = 0;
    {
      Statement row(handle, "SELECT started_utc_ns FROM sessions WHERE id = ?1");
      if (!row.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
      started_utc_ns = row.integer_at(0);
    }
    if (change.note) {
      Statement update(handle, "UPDATE sessions SET note = ?2 WHERE id = ?1");
      update.integer(1, session).text(2, std::string_view(*change.note)).run();
    }
    if (change.subject) {
      Statement update(handle, "UPDATE sessions SET visit_id = ?2 WHERE id = ?1");
      update.integer(1, session);
      if (*change.subject)
        update.integer(2, visit_row(handle, **change.subject, started_utc_ns));
      else
        update.null(2);
      update.run();
      drop_empty_visits(handle);
    }
    if (change.exercise_json) {
      Statement update(handle, "UPDATE sessions SET exercise = ?2 WHERE id = ?1");
      update.integer(1, session).text(2, *change.exercise_json).run();
    }
    transaction.commit();
    return {};
  });
}

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

constexpr std::array<std::string_view, 4> kBlobTables{"chunks", "bus_chunks", "journal_chunks", "core_images"};

// Rows of all tables that belong to a session but the large ones, whichever tables there are.
void delete_small_rows(sqlite3* handle, SessionId session) {
  std::vector<std::string> deletions;
  Statement tables(handle,
                   "SELECT m.name, f.\"from\" FROM sqlite_schema AS m, pragma_foreign_key_list(m.name) AS f "
                   "WHERE m.type = 'table' AND f.\"table\" = 'sessions'");
  while (tables.step())
    if (const std::string name = tables.text_at(0); std::ranges::find(kBlobTables, name) == kBlobTables.end())
      deletions.push_back("DELETE FROM " + name + " WHERE " + tables.text_at(1) + " = ?1");
  for (const std::string& sql : deletions) Statement(handle, sql).integer(1, session).run();
}
}  // namespace

Status SessionEditor::take_out(SessionId session) {
  sqlite3* handle = database_->handle();
  const SecureDelete secure(handle);
  // Without them the session's row goes, and its blobs stay for erase_piece.
  try_execute(handle, "PRAGMA foreign_keys = OFF");
  return guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    {
      Statement row(handle, "SELECT ended_utc_ns FROM sessions WHERE id = ?1");
      if (!row.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
      if (row.is_null(0))
        return Error{ErrorKind::wrong_state, "session " + std::to_string(session) + " is being recorded: end it first", {}};
    }
    Statement(handle, "INSERT INTO deletions (session_id) VALUES (?1)").integer(1, session).run();
    delete_small_rows(handle, session);
    Statement(handle, "DELETE FROM sessions WHERE id = ?1").integer(1, session).run();
    transaction.commit();
    return {};
  });
}

Result<bool> SessionEditor::erase_piece() {
  sqlite3* handle = database_->handle();
  const SecureDelete secure(handle);
  auto more = guarded([&]() -> Result<bool> {
    Statement first(handle, "SELECT session_id FROM deletions ORDER BY session_id LIMIT 1");
    if (!first.step()) return false;
    const SessionId session = first.integer_at(0);
    first.reset();
    Transaction transaction(handle, Transaction::Kind::write);
    // Here and not in take_out: what belongs to a patient goes by its foreign keys.
    drop_empty_visits(handle);
    std::size_t room = kErasedRows;
    for (const std::string_view table : kBlobTables) {
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

Status SessionEditor::remove(SessionId session) {
  if (Status taken = take_out(session); !taken) return taken;
  for (;;) {
    const auto more = erase_piece();
    if (!more) return more.error();
    if (!*more) return {};
  }
}

}  // namespace hoist::db
