#include "db/store/parameter_log.hpp"

#include "db/store/actor_rows.hpp"
#include "db/store/page.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// The session that was being recorded at a change: the newest one of the same core that had begun by then and had not ended.
constexpr const char* kSessionThen =
    "(SELECT s.id FROM sessions AS s WHERE s.core_start_time_ns = c.core_start_time_ns AND s.start_time_ns <= c.time_ns AND "
    "(s.last_time_ns IS NULL OR s.last_time_ns >= c.time_ns) ORDER BY s.start_time_ns DESC LIMIT 1)";

ParameterChange change_at(const Statement& row) {
  ParameterChange change{.id = row.integer_at(0),
                         .utc_ns = row.integer_at(1),
                         .core_start_time_ns = row.unsigned_at(2),
                         .time_ns = row.unsigned_at(3),
                         .parameter = static_cast<std::uint32_t>(row.integer_at(4)),
                         .name = row.text_at(5),
                         .value = row.real_at(6),
                         .before = row.real_at(7),
                         .reason = row.text_at(8),
                         .source = row.optional_text_at(9),
                         .actor = actor_at(row, 10)};
  if (!row.is_null(14)) change.session = row.integer_at(14);
  return change;
}

// Inside a write transaction.
void insert_rows(sqlite3* handle, std::span<const ParameterChange> changes) {
  Statement insert(handle,
                   "INSERT INTO parameter_changes (utc_ns, core_start_time_ns, time_ns, parameter, name, value, before, reason, source, "
                   "actor_id) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)");
  for (const ParameterChange& change : changes) {
    insert.integer(1, change.utc_ns)
        .unsigned_integer(2, change.core_start_time_ns)
        .unsigned_integer(3, change.time_ns)
        .integer(4, change.parameter)
        .text(5, std::string_view(change.name))
        .real(6, change.value)
        .real(7, change.before)
        .text(8, std::string_view(change.reason))
        .text(9, change.source);
    bind_actor(insert, 10, handle, change.actor);
    insert.run();
  }
}

std::map<std::uint32_t, double> newest_values(sqlite3* handle) {
  std::map<std::uint32_t, double> values;
  // With a lone max() SQLite takes the other columns from its row.
  Statement rows(handle, "SELECT parameter, value, max(id) FROM parameter_changes GROUP BY parameter");
  while (rows.step()) values.emplace(static_cast<std::uint32_t>(rows.integer_at(0)), rows.real_at(1));
  return values;
}

}  // namespace

Status ParameterLog::append(std::span<const ParameterChange> changes) {
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    insert_rows(handle, changes);
    transaction.commit();
    return {};
  });
}

Status ParameterLog::catch_up(std::span<const ParameterChange> now) {
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    const auto known = newest_values(handle);
    std::vector<ParameterChange> missing;
    for (const ParameterChange& in_force : now) {
      const auto at = known.find(in_force.parameter);
      if (at != known.end() && at->second == in_force.value) continue;
      ParameterChange& row = missing.emplace_back(in_force);
      row.before = at == known.end() ? in_force.value : at->second;
      row.reason = std::string(at == known.end() ? kFirstSeen : kNotSeen);
    }
    if (missing.empty()) return {};
    insert_rows(handle, missing);
    transaction.commit();
    return {};
  });
}

Result<VisitPage<ParameterChange>> ParameterLog::list(const ChangeQuery& query) const {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<VisitPage<ParameterChange>> {
    std::string sql =
        "SELECT c.id, utc_ns, core_start_time_ns, time_ns, parameter, name, value, before, reason, source, user, role, origin, client, " +
        std::string(kSessionThen) +
        " FROM parameter_changes AS c LEFT JOIN actors ON actors.id = actor_id WHERE c.id < ?1 AND reason <> ?9 ";
    if (query.name) sql += "AND name = ?3 ";
    if (query.reason) sql += "AND reason = ?4 ";
    if (query.user) sql += "AND user = ?5 ";
    if (query.from_utc_ns) sql += "AND utc_ns >= ?6 ";
    if (query.to_utc_ns) sql += "AND utc_ns < ?7 ";
    if (query.patient)
      sql += "AND (SELECT patient_id FROM visits JOIN sessions ON visit_id = visits.id WHERE sessions.id = " + std::string(kSessionThen) +
             ") = ?8 ";
    Statement rows(database_->handle(), sql + "ORDER BY c.id DESC LIMIT ?2");
    rows.text(9, kFirstSeen);
    if (query.name) rows.text(3, query.name);
    if (query.reason) rows.text(4, query.reason);
    if (query.user) rows.text(5, query.user);
    if (query.from_utc_ns) rows.integer(6, *query.from_utc_ns);
    if (query.to_utc_ns) rows.integer(7, *query.to_utc_ns);
    if (query.patient) rows.integer(8, *query.patient);
    const VisitQuery page{.limit = query.limit, .before = query.before};
    return page_of<ParameterChange>(rows, page, change_at, [](const ParameterChange& change) { return change.id; });
  });
}

Result<std::map<std::uint32_t, double>> ParameterLog::latest() const {
  return guarded([&]() -> Result<std::map<std::uint32_t, double>> { return newest_values(database_->handle()); });
}

Result<std::vector<ParameterDifference>> ParameterLog::between(std::int64_t from_utc_ns, std::int64_t to_utc_ns) const {
  return guarded([&]() -> Result<std::vector<ParameterDifference>> {
    // What the first change after the first moment replaced, and what the last one before the second left.
    Statement rows(
        database_->handle(),
        "SELECT first.parameter, last.name, first.before, last.value FROM "
        "(SELECT parameter, before, min(id) FROM parameter_changes WHERE utc_ns > ?1 AND utc_ns <= ?2 GROUP BY parameter) AS first "
        "JOIN (SELECT parameter, name, value, max(id) FROM parameter_changes WHERE utc_ns > ?1 AND utc_ns <= ?2 "
        "GROUP BY parameter) AS last ON last.parameter = first.parameter "
        "WHERE first.before <> last.value ORDER BY first.parameter");
    rows.integer(1, from_utc_ns).integer(2, to_utc_ns);
    std::vector<ParameterDifference> out;
    while (rows.step()) out.push_back({static_cast<std::uint32_t>(rows.integer_at(0)), rows.text_at(1), rows.real_at(2), rows.real_at(3)});
    return out;
  });
}

}  // namespace hoist::db
