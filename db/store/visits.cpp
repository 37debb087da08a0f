#include "db/store/visits.hpp"

#include "db/store/edit_tag.hpp"
#include "db/store/page.hpp"
#include "db/store/patient_code.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/walk_order.hpp"

namespace hoist::db {
namespace {

constexpr const char* kVisits =
    "SELECT visits.id, patient_id, code, day, sessions.id FROM sessions JOIN visits ON visits.id = visit_id "
    "JOIN patients ON patients.id = patient_id WHERE sessions.id = ?1";

Visit visit_at(const Statement& row) { return {row.integer_at(0), row.integer_at(1), row.text_at(2), row.text_at(3)}; }

Status check_limit(const VisitQuery& query) {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return {};
}

}  // namespace

Result<std::map<SessionId, Visit>> VisitReader::of_sessions(std::span<const SessionId> sessions) const {
  return guarded([&]() -> Result<std::map<SessionId, Visit>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    std::map<SessionId, Visit> out;
    Statement row(database_->handle(), kVisits);
    for (const SessionId session : sessions) {
      if (row.integer(1, session).step()) out.emplace(session, visit_at(row));
      row.reset();
    }
    return out;
  });
}

namespace {
void read_sessions(sqlite3* handle, VisitInfo& info) {
  Statement session(handle, "SELECT id, standby, started_utc_ns FROM sessions WHERE visit_id = ?1");
  session.integer(1, info.visit.id);
  std::map<WalkOrder, bool> standby;
  while (session.step()) standby[{info.visit.day, session.integer_at(2), session.integer_at(0)}] = session.integer_at(1) != 0;
  for (const auto& [order, is_standby] : standby) (is_standby ? info.standby : info.sessions).push_back(order.session);
}
constexpr const char* kVisitRows =
    "SELECT visits.id, patient_id, code, day, visit_note FROM visits JOIN patients ON patients.id = patient_id WHERE ";
VisitInfo visit_info(const Statement& row) {
  VisitInfo info{visit_at(row), row.text_at(4), {}, {}, {}};
  info.tag = edit_tag({info.note});
  return info;
}

// The day and the numbers of one patient's visits come by index.
constexpr const char* kPatientRows =
    "SELECT id, code, archived, (SELECT sealed FROM patient_identities WHERE patient_id = patients.id), "
    "(SELECT count(DISTINCT visits.id) FROM visits JOIN sessions ON visit_id = visits.id WHERE patient_id = patients.id AND standby = 0), "
    "(SELECT count(*) FROM visits JOIN sessions ON visit_id = visits.id WHERE patient_id = patients.id AND standby = 0), "
    "(SELECT min(day) FROM visits JOIN sessions ON visit_id = visits.id WHERE patient_id = patients.id AND standby = 0), "
    "(SELECT max(day) FROM visits JOIN sessions ON visit_id = visits.id WHERE patient_id = patients.id AND standby = 0) "
    "FROM patients WHERE ";
PatientInfo patient_at(const Statement& row) {
  PatientInfo info{.id = row.integer_at(0),
                   .code = row.text_at(1),
                   .archived = row.integer_at(2) != 0,
                   .has_identity = !row.is_null(3),
                   .visits = row.unsigned_at(4),
                   .sessions = row.unsigned_at(5),
                   .first_day = row.optional_text_at(6),
                   .last_day = row.optional_text_at(7),
                   .tag = {}};
  const ByteView sealed = row.blob_at(3);
  info.tag = edit_tag({info.code, info.archived ? "1" : "0", {reinterpret_cast<const char*>(sealed.data()), sealed.size()}});
  return info;
}
}  // namespace

Result<VisitPage<VisitInfo>> VisitReader::visits(const VisitQuery& query) const {
  if (Status checked = check_limit(query); !checked) return checked.error();
  return guarded([&]() -> Result<VisitPage<VisitInfo>> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    Statement rows(handle, std::string(kVisitRows) + "visits.id < ?1 " + (query.patient_id ? "AND patient_id = ?3 " : "") +
                               (query.day ? "AND day = ?4 " : "") + "ORDER BY visits.id DESC LIMIT ?2");
    if (query.patient_id) rows.integer(3, *query.patient_id);
    if (query.day) rows.text(4, query.day);
    auto page = page_of<VisitInfo>(rows, query, visit_info, [](const VisitInfo& v) { return v.visit.id; });
    for (VisitInfo& one : page.items) read_sessions(handle, one);
    return page;
  });
}

Result<VisitInfo> VisitReader::visit(std::int64_t visit) const {
  return guarded([&]() -> Result<VisitInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    Statement row(handle, std::string(kVisitRows) + "visits.id = ?1");
    if (!row.integer(1, visit).step()) return Error{ErrorKind::not_found, "there is no visit " + std::to_string(visit), {}};
    VisitInfo info = visit_info(row);
    read_sessions(handle, info);
    return info;
  });
}

Result<VisitPage<PatientInfo>> VisitReader::patients(const VisitQuery& query) const {
  if (Status checked = check_limit(query); !checked) return checked.error();
  return guarded([&]() -> Result<VisitPage<PatientInfo>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    Statement rows(database_->handle(), std::string(kPatientRows) + "id < ?1 " + (query.code_part ? "AND code_has(code, ?3) " : "") +
                                            (query.archived ? "AND archived = ?4 " : "") + "ORDER BY id DESC LIMIT ?2");
    if (query.code_part) rows.text(3, query.code_part);
    if (query.archived) rows.integer(4, *query.archived ? 1 : 0);
    return page_of<PatientInfo>(rows, query, patient_at, [](const PatientInfo& patient) { return patient.id; });
  });
}

std::optional<PatientInfo> patient_row(sqlite3* handle, std::int64_t patient) {
  Statement row(handle, std::string(kPatientRows) + "id = ?1");
  return row.integer(1, patient).step() ? std::optional(patient_at(row)) : std::nullopt;
}

std::int64_t visit_row(sqlite3* handle, const std::string& typed, std::int64_t started_utc_ns) {
  const std::string stored = stored_code(handle, typed), &code = stored.empty() ? typed : stored;
  Statement(handle, "INSERT OR IGNORE INTO patients (code) VALUES (?1)").text(1, std::string_view(code)).run();
  const auto with_visit = [&](const std::string& sql) {
    Statement row(handle, sql);
    row.text(1, std::string_view(code)).integer(2, started_utc_ns);
    return row.step() ? row.integer_at(0) : 0;
  };
  const std::string day = local_day_sql("?2");
  with_visit("INSERT OR IGNORE INTO visits (patient_id, day) SELECT id, " + day + " FROM patients WHERE code = ?1");
  return with_visit("SELECT visits.id FROM visits JOIN patients ON patients.id = patient_id WHERE code = ?1 AND day = " + day);
}

void drop_empty_visits(sqlite3* handle) {
  execute(handle,
          "DELETE FROM visits WHERE NOT EXISTS (SELECT 1 FROM sessions WHERE visit_id = visits.id);"
          "DELETE FROM patients WHERE registered = 0 AND NOT EXISTS (SELECT 1 FROM visits WHERE patient_id = patients.id)");
}

}  // namespace hoist::db
