#include "db/store/visits.hpp"

#include <limits>

#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr const char* kVisits =
    "SELECT visits.id, patient_id, code, day, sessions.id FROM sessions JOIN visits ON visits.id = visit_id "
    "JOIN patients ON patients.id = patient_id WHERE sessions.id = ?1";

Visit visit_at(const Statement& row) { return {row.integer_at(0), row.integer_at(1), row.text_at(2), row.text_at(3)}; }

// Reads one row more than asked, which tells whether a next page exists. `read(row)` makes an item, `id(item)` is its number.
template <typename Item, typename Read, typename Id>
VisitPage<Item> page_of(Statement& rows, const VisitQuery& query, Read read, Id id) {
  rows.integer(1, query.before.value_or(std::numeric_limits<std::int64_t>::max())).unsigned_integer(2, query.limit + 1);
  VisitPage<Item> page;
  while (rows.step()) {
    if (page.items.size() == query.limit) {
      page.next = id(page.items.back());
      break;
    }
    page.items.push_back(read(rows));
  }
  return page;
}

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

Result<VisitPage<VisitInfo>> VisitReader::visits(const VisitQuery& query) const {
  if (Status checked = check_limit(query); !checked) return checked.error();
  return guarded([&]() -> Result<VisitPage<VisitInfo>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    Statement rows(database_->handle(), std::string("SELECT visits.id, patient_id, code, day FROM visits "
                                                    "JOIN patients ON patients.id = patient_id WHERE visits.id < ?1 ") +
                                            (query.patient_id ? "AND patient_id = ?3 " : "") + "ORDER BY visits.id DESC LIMIT ?2");
    if (query.patient_id) rows.integer(3, *query.patient_id);
    auto page = page_of<VisitInfo>(
        rows, query,
        [](const Statement& row) {
          return VisitInfo{visit_at(row), {}};
        },
        [](const VisitInfo& v) { return v.visit.id; });
    Statement session(database_->handle(), "SELECT id FROM sessions WHERE visit_id = ?1 ORDER BY id");
    for (VisitInfo& one : page.items) {
      session.integer(1, one.visit.id);
      while (session.step()) one.sessions.push_back(session.integer_at(0));
      session.reset();
    }
    return page;
  });
}

Result<VisitPage<PatientInfo>> VisitReader::patients(const VisitQuery& query) const {
  if (Status checked = check_limit(query); !checked) return checked.error();
  return guarded([&]() -> Result<VisitPage<PatientInfo>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    Statement rows(database_->handle(),
                   "SELECT patients.id, code, count(DISTINCT visits.id), count(sessions.id), min(day), max(day) FROM patients "
                   "JOIN visits ON patient_id = patients.id JOIN sessions ON visit_id = visits.id "
                   "WHERE patients.id < ?1 GROUP BY patients.id ORDER BY patients.id DESC LIMIT ?2");
    return page_of<PatientInfo>(
        rows, query,
        [](const Statement& row) {
          return PatientInfo{row.integer_at(0), row.text_at(1), row.unsigned_at(2), row.unsigned_at(3), row.text_at(4), row.text_at(5)};
        },
        [](const PatientInfo& patient) { return patient.id; });
  });
}

std::int64_t visit_row(sqlite3* handle, const std::string& code, std::int64_t started_utc_ns) {
  Statement(handle, "INSERT OR IGNORE INTO patients (code) VALUES (?1)").text(1, std::string_view(code)).run();
  // The same day as in schema/007_visits.sql.
  const auto with_visit = [&](const char* sql) {
    Statement row(handle, sql);
    row.text(1, std::string_view(code)).integer(2, started_utc_ns / 1'000'000'000);
    return row.step() ? row.integer_at(0) : 0;
  };
  with_visit("INSERT OR IGNORE INTO visits (patient_id, day) SELECT id, date(?2, 'unixepoch', 'localtime') FROM patients WHERE code = ?1");
  return with_visit(
      "SELECT visits.id FROM visits JOIN patients ON patients.id = patient_id "
      "WHERE code = ?1 AND day = date(?2, 'unixepoch', 'localtime')");
}

void drop_empty_visits(sqlite3* handle) {
  execute(handle,
          "DELETE FROM visits WHERE NOT EXISTS (SELECT 1 FROM sessions WHERE visit_id = visits.id);"
          "DELETE FROM patients WHERE NOT EXISTS (SELECT 1 FROM visits WHERE patient_id = patients.id)");
}

}  // namespace hoist::db
