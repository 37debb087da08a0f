#include "db/store/patients.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "db/store/identity_key.hpp"
#include "db/store/overwriting.hpp"
#include "db/store/patient_code.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

Error no_such_patient(std::int64_t patient) { return {ErrorKind::not_found, "there is no patient " + std::to_string(patient), {}}; }
Error code_taken() { return {ErrorKind::taken, "another patient has this code already", "code"}; }

bool code_used(sqlite3* handle, const std::string& code, std::int64_t but_of) {
  Statement row(handle, "SELECT 1 FROM patients WHERE code_same(code, ?1) AND id <> ?2");
  return row.text(1, std::string_view(code)).integer(2, but_of).step();
}

// The row that a change is made for, or why it is not made.
Result<PatientInfo> row_to_change(sqlite3* handle, std::int64_t patient, const std::string& expected) {
  const auto found = patient_row(handle, patient);
  if (!found) return no_such_patient(patient);
  if (Status same = check_tag(expected, found->tag); !same) return same.error();
  return *found;
}

// One write transaction over one patient, who is registered from then on. `change(handle, before)` writes.
template <typename Change>
Result<PatientInfo> changed(sqlite3* handle, std::int64_t patient, const std::string& expected, Change change) {
  return guarded([&]() -> Result<PatientInfo> {
    Transaction transaction(handle, Transaction::Kind::write);
    const auto before = row_to_change(handle, patient, expected);
    if (!before) return before.error();
    if (Status done = change(*before); !done) return done.error();
    Statement(handle, "UPDATE patients SET registered = 1 WHERE id = ?1").integer(1, patient).run();
    PatientInfo after = patient_row(handle, patient).value();
    transaction.commit();
    return after;
  });
}

bool is_digits(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}
// A day of the calendar, YYYY-MM-DD.
bool is_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  if (!is_digits(text.substr(0, 4)) || !is_digits(text.substr(5, 2)) || !is_digits(text.substr(8))) return false;
  const auto two = [&](std::size_t at) { return (text[at] - '0') * 10 + (text[at + 1] - '0'); };
  const int year = two(0) * 100 + two(2), month = two(5), day = two(8);
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  const int days = month == 2 ? (leap ? 29 : 28) : month == 4 || month == 6 || month == 9 || month == 11 ? 30 : 31;
  return year >= 1850 && month >= 1 && month <= 12 && day >= 1 && day <= days;
}

// The sentences name the limits and never what was written.
Status check_identity(const Identity& identity) {
  if (identity.name.size() > kMaxPersonName_bytes || identity.name.find('\n') != std::string::npos || !check_note(identity.name))
    return Error{ErrorKind::bad_value, "name must be one line of at most 200 bytes", "name"};
  if (identity.birth_date && !is_day(*identity.birth_date))
    return Error{ErrorKind::bad_value, "birth_date must be a day as YYYY-MM-DD", "birth_date"};
  if (identity.note.size() > kMaxPersonNote_bytes || !check_note(identity.note))
    return Error{ErrorKind::bad_value, "note must be plain text of at most 1000 bytes", "note"};
  return {};
}

std::string packed(const Identity& identity) {
  return json{
      {"name", identity.name}, {"birth_date", identity.birth_date ? json(*identity.birth_date) : json(nullptr)}, {"note", identity.note}}
      .dump();
}
std::optional<Identity> unpacked(const std::string& text) {
  const json value = json::parse(text, nullptr, false);
  if (!value.is_object()) return std::nullopt;
  Identity identity{value.value("name", ""), std::nullopt, value.value("note", "")};
  if (const auto at = value.find("birth_date"); at != value.end() && at->is_string()) identity.birth_date = at->get<std::string>();
  return identity;
}

bool same_key(const IdentityKey& key, ByteView id) { return std::ranges::equal(key.id(), id); }

// The key for one more identity. Made with the first one only: a second key would hide that the first is lost.
Result<IdentityKey> key_for_sealing(sqlite3* handle, const std::filesystem::path& file) {
  const auto key = IdentityKey::read(file);
  Statement row(handle, "SELECT key_id FROM patient_identities LIMIT 1");
  const bool first = !row.step();
  if (first) return key ? Result<IdentityKey>(*key) : IdentityKey::make(file);
  if (key && same_key(*key, row.blob_at(0))) return *key;
  return Error{ErrorKind::wrong_state,
               (key ? "the key of the identities is another one: put the right " : "the key of the identities is missing: put ") +
                   IdentityKey::beside(file).filename().string() + " back beside the database",
               "key"};
}

}  // namespace

Result<PatientInfo> PatientStore::get(std::int64_t patient) const {
  return guarded([&]() -> Result<PatientInfo> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    const auto found = patient_row(database_->handle(), patient);
    return found ? Result<PatientInfo>(*found) : no_such_patient(patient);
  });
}

Result<PatientInfo> PatientStore::create(const std::string& typed) {
  const std::string code = trimmed_code(typed);
  if (Status checked = check_code(code, "code"); !checked) return checked.error();
  return guarded([&]() -> Result<PatientInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    if (code_used(handle, code, 0)) return code_taken();
    std::int64_t id = 0;
    {
      Statement row(handle, "INSERT INTO patients (code, registered) VALUES (?1, 1) RETURNING id");
      row.text(1, std::string_view(code)).step();
      id = row.integer_at(0);
    }
    PatientInfo made = patient_row(handle, id).value();
    transaction.commit();
    return made;
  });
}

Result<PatientInfo> PatientStore::change(std::int64_t patient, const PatientPatch& patch, const std::string& expected) {
  sqlite3* handle = database_->handle();
  return changed(handle, patient, expected, [&](const PatientInfo& before) -> Status {
    const std::string code = patch.code ? trimmed_code(*patch.code) : before.code;
    if (code != before.code)
      if (Status checked = check_code(code, "code"); !checked) return checked;
    if (code_used(handle, code, patient)) return code_taken();
    Statement(handle, "UPDATE patients SET code = ?2, archived = ?3 WHERE id = ?1")
        .integer(1, patient)
        .text(2, std::string_view(code))
        .integer(3, patch.archived.value_or(before.archived) ? 1 : 0)
        .run();
    return {};
  });
}

Result<std::string> PatientStore::choose(std::int64_t patient) {
  const auto chosen = changed(database_->handle(), patient, {}, [](const PatientInfo& before) -> Status {
    if (before.archived)
      return Error{ErrorKind::wrong_state, "this patient is archived: take the patient out of the archive first", "archived"};
    return {};
  });
  if (!chosen) return chosen.error();
  return chosen->code;
}

Result<std::optional<SessionId>> PatientStore::newest_session(std::int64_t patient) const {
  return guarded([&]() -> Result<std::optional<SessionId>> {
    Statement row(database_->handle(), "SELECT max(sessions.id) FROM sessions JOIN visits ON visits.id = visit_id WHERE patient_id = ?1");
    row.integer(1, patient).step();
    return row.is_null(0) ? std::optional<SessionId>() : row.integer_at(0);
  });
}

Status PatientStore::remove(std::int64_t patient, const std::string& expected) {
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    const auto before = row_to_change(handle, patient, expected);
    if (!before) return before.error();
    Statement session(handle, "SELECT 1 FROM sessions JOIN visits ON visits.id = visit_id WHERE patient_id = ?1");
    if (session.integer(1, patient).step())
      return Error{ErrorKind::wrong_state, "patient " + std::to_string(patient) + " still has sessions", {}};
    session.reset();
    Statement(handle, "DELETE FROM visits WHERE patient_id = ?1").integer(1, patient).run();
    Statement(handle, "DELETE FROM patients WHERE id = ?1").integer(1, patient).run();
    transaction.commit();
    return {};
  });
}

Result<VisitInfo> PatientStore::note_visit(std::int64_t visit, const std::string& note, const std::string& expected) {
  if (Status checked = check_note(note); !checked) return checked.error();
  const Status written = guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    {
      Statement row(handle, "SELECT visit_note FROM visits WHERE id = ?1");
      if (!row.integer(1, visit).step()) return Error{ErrorKind::not_found, "there is no visit " + std::to_string(visit), {}};
      if (Status same = check_tag(expected, edit_tag({row.text_at(0)})); !same) return same;
    }
    Statement(handle, "UPDATE visits SET visit_note = ?2 WHERE id = ?1").integer(1, visit).text(2, std::string_view(note)).run();
    transaction.commit();
    return {};
  });
  if (!written) return written.error();
  return VisitReader(*database_).visit(visit);
}

Result<IdentityTold> PatientStore::identity(std::int64_t patient) const {
  return guarded([&]() -> Result<IdentityTold> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    const auto found = patient_row(handle, patient);
    if (!found) return no_such_patient(patient);
    IdentityTold told{.state = IdentityState::none, .identity = {}, .tag = found->tag};
    Statement row(handle, "SELECT key_id, sealed FROM patient_identities WHERE patient_id = ?1");
    if (!row.integer(1, patient).step()) return told;
    const auto key = IdentityKey::read(database_->file());
    if (!key) {
      told.state = IdentityState::key_missing;
    } else if (!same_key(*key, row.blob_at(0))) {
      told.state = IdentityState::key_foreign;
    } else {
      auto text = key->open(patient, row.blob_at(1));
      if (text) told.identity = unpacked(*text);
      if (text) sodium_memzero(text->data(), text->size());
      told.state = told.identity ? IdentityState::readable : IdentityState::damaged;
    }
    return told;
  });
}

Result<PatientInfo> PatientStore::set_identity(std::int64_t patient, const Identity& identity, const std::string& expected) {
  if (Status checked = check_identity(identity); !checked) return checked.error();
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return changed(handle, patient, expected, [&](const PatientInfo&) -> Status {
    const auto key = key_for_sealing(handle, database_->file());
    if (!key) return key.error();
    std::string text = packed(identity);
    const std::vector<std::uint8_t> sealed = key->seal(patient, text);
    sodium_memzero(text.data(), text.size());
    const IdentityKey::Id id = key->id();
    Statement(handle, "INSERT OR REPLACE INTO patient_identities (patient_id, key_id, sealed) VALUES (?1, ?2, ?3)")
        .integer(1, patient)
        .blob(2, id)
        .blob(3, sealed)
        .run();
    return {};
  });
}

Result<PatientInfo> PatientStore::clear_identity(std::int64_t patient, const std::string& expected) {
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return changed(handle, patient, expected, [&](const PatientInfo&) -> Status {
    Statement(handle, "DELETE FROM patient_identities WHERE patient_id = ?1").integer(1, patient).run();
    return {};
  });
}

}  // namespace hoist::db
