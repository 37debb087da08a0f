#include <nlohmann/json.hpp>

#include <array>
#include <cmath>

#include "db/store/session_checks.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {
namespace {

constexpr double kSmallest_m = 0.2, kLargest_m = 100.0;

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

Error bad_exercise(std::string message) { return {ErrorKind::bad_value, std::move(message), "exercise"}; }

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

Status check_exercise(std::string_view json) {
  static constexpr const char* kShapesText = "exercise.shape must be square, eight, circle or straight";
  if (json.size() > kMaxExercise_bytes) return bad_exercise("exercise must be at most 1000 bytes");
  const nlohmann::json value = nlohmann::json::parse(json, nullptr, false);
  if (!value.is_object()) return bad_exercise("exercise must be a JSON object");
  const auto shape = value.find("shape");
  if (shape == value.end() || !shape->is_string()) return bad_exercise(kShapesText);
  struct Shape {
    std::string_view name;
    std::array<std::string_view, 2> sizes;
    std::string_view option;  // a size that may be left out
    bool turned;              // may be walked to the other side
  };
  static constexpr std::array kShapes{Shape{"square", {"side_m", ""}, "corner_radius_m", true},
                                      Shape{"eight", {"centre_m", "radius_m"}, "", true}, Shape{"circle", {"radius_m", ""}, "", true},
                                      Shape{"straight", {"length_m", ""}, "", false}};
  const auto in_range = [&value](std::string_view size) {
    const auto given = value.find(size);
    return given != value.end() && given->is_number() && given->get<double>() >= kSmallest_m && given->get<double>() <= kLargest_m;
  };
  for (const Shape& known : kShapes) {
    if (shape->get_ref<const std::string&>() != known.name) continue;
    std::size_t expected = 1;
    for (const std::string_view size : known.sizes) {
      if (size.empty()) continue;
      ++expected;
      if (!in_range(size)) return bad_exercise("exercise." + std::string(size) + " must be a number from 0.2 to 100");
    }
    if (!known.option.empty() && value.contains(known.option)) {
      ++expected;
      if (!in_range(known.option)) return bad_exercise("exercise." + std::string(known.option) + " must be a number from 0.2 to 100");
    }
    if (const auto side = value.find("clockwise"); known.turned && side != value.end()) {
      ++expected;
      if (!side->is_boolean()) return bad_exercise("exercise.clockwise must be true or false");
    }
    if (value.size() != expected) return bad_exercise("exercise has a field that " + std::string(known.name) + " does not know");
    if (known.name == "eight" && value["radius_m"].get<double>() > value["centre_m"].get<double>())
      return bad_exercise("exercise.radius_m must not exceed centre_m");
    if (known.name == "square" && 2 * value.value("corner_radius_m", 0.0) > value["side_m"].get<double>())
      return bad_exercise("exercise.corner_radius_m must not exceed half of side_m");
    return {};
  }
  return bad_exercise(kShapesText);
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

Status SessionEditor::remove(SessionId session) {
  sqlite3* handle = database_->handle();
  // Health data: freed pages are overwritten, also those the log still holds (the checkpoint below).
  try_execute(handle, "PRAGMA secure_delete = ON");
  Status removed = guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    {
      Statement row(handle, "SELECT ended_utc_ns FROM sessions WHERE id = ?1");
      if (!row.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
      if (row.is_null(0))
        return Error{ErrorKind::wrong_state, "session " + std::to_string(session) + " is being recorded: end it first", {}};
    }
    Statement(handle, "DELETE FROM sessions WHERE id = ?1").integer(1, session).run();
    drop_empty_visits(handle);
    transaction.commit();
    return {};
  });
  try_execute(handle, "PRAGMA secure_delete = OFF");
  if (removed) try_execute(handle, "PRAGMA wal_checkpoint(TRUNCATE)");
  return removed;
}

}  // namespace hoist::db
