#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "db/store/deletion.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/patient_code.hpp"
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
  if (subject->empty() || !is_plain_line(*subject, kMaxSubject_bytes))
    return Error{ErrorKind::bad_value, "subject must be a code of 1 to 64 bytes in one line", "subject"};
  return {};
}

Status check_note(std::string_view note) {
  if (note.size() > kMaxNote_bytes || !plain_text(note))
    return Error{ErrorKind::bad_value, "note must be plain text of at most 4000 bytes", "note"};
  return {};
}

Status check_marker(std::string_view text) {
  if (text.size() > kMaxMarker_bytes || !plain_text(text))
    return Error{ErrorKind::bad_value, "text must be plain text of at most 500 bytes", "text"};
  return {};
}

Status check_marker_kind(std::string_view kind) {
  if (std::ranges::find(kMarkerKinds, kind) != kMarkerKinds.end()) return {};
  std::string names;
  for (const std::string_view name : kMarkerKinds) names.append(names.empty() ? "" : ", ").append(name);
  return Error{ErrorKind::bad_value, "kind must be one of " + names, "kind"};
}

bool is_plain_line(std::string_view text, std::size_t most_bytes) {
  return text.size() <= most_bytes && plain_text(text) && text.find('\n') == std::string_view::npos;
}

std::string session_tag(const std::string& note, const std::optional<std::string>& subject,
                        const std::optional<std::string>& exercise_json) {
  // Absent is another than empty.
  return edit_tag({note, subject ? "1" + *subject : "", exercise_json ? "1" + *exercise_json : ""});
}

Status SessionEditor::patch(SessionId session, const SessionPatch& change, const std::string& expected) {
  if (change.note)
    if (Status checked = check_note(*change.note); !checked) return checked;
  if (change.exercise_json && *change.exercise_json)
    if (Status checked = check_exercise(**change.exercise_json); !checked) return checked;
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    std::optional<std::string> code;
    if (change.subject && *change.subject) {
      auto found = code_to_record(handle, **change.subject, "subject");
      if (!found) return found.error();
      code = std::move(*found);
    }
    std::int64_t started_utc_ns = 0;
    {
      Statement row(handle,
                    "SELECT started_utc_ns, note, code, exercise FROM sessions LEFT JOIN visits ON visits.id = visit_id "
                    "LEFT JOIN patients ON patients.id = patient_id WHERE sessions.id = ?1");
      if (!row.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
      started_utc_ns = row.integer_at(0);
      const std::string tag = session_tag(row.text_at(1), row.optional_text_at(2), row.optional_text_at(3));
      if (const Status same = check_tag(expected, tag); !same) return same;
    }
    if (change.note) {
      Statement update(handle, "UPDATE sessions SET note = ?2 WHERE id = ?1");
      update.integer(1, session).text(2, std::string_view(*change.note)).run();
    }
    if (change.subject) {
      Statement update(handle, "UPDATE sessions SET visit_id = ?2 WHERE id = ?1");
      update.integer(1, session);
      if (code)
        update.integer(2, visit_row(handle, *code, started_utc_ns));
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

Status SessionEditor::remove(SessionId session) {
  if (Status taken = take_out(*database_, session); !taken) return taken;
  for (;;) {
    const auto more = erase_piece(*database_);
    if (!more) return more.error();
    if (!*more) return {};
  }
}

}  // namespace hoist::db
