#include "db/store/alarms.hpp"

#include <limits>

#include "control/contract/commands.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// The number stands in the text, so that SQLite can use the index of schema/012, which holds these rows only.
static_assert(contract::EventKind::fault_raised == contract::EventKind{4} && contract::EventKind::fault_cleared == contract::EventKind{5});
constexpr const char* kRows =
    ", e.time_ns - s.start_time_ns, e.name, (SELECT c.time_ns FROM events AS c "
    "WHERE c.session_id = e.session_id AND c.number > e.number AND c.kind = 5 AND c.name = e.name ORDER BY c.number LIMIT 1) - e.time_ns, "
    "s.simulated, patients.code "
    "FROM events AS e JOIN sessions AS s ON s.id = e.session_id LEFT JOIN visits ON visits.id = s.visit_id "
    "LEFT JOIN patients ON patients.id = visits.patient_id WHERE e.kind = 4 AND (e.session_id, e.number) < (?1, ?2) ";

StoredAlarm alarm_at(const Statement& row) {
  StoredAlarm alarm{.place = {row.integer_at(0), row.integer_at(1)},
                    .utc_ns = row.integer_at(2),
                    .time_s = static_cast<double>(row.integer_at(3)) / 1e9,
                    .fault = row.text_at(4),
                    .lasted_s = {},
                    .simulated = row.integer_at(6) != 0,
                    .subject = row.optional_text_at(7)};
  if (!row.is_null(5)) alarm.lasted_s = static_cast<double>(row.integer_at(5)) / 1e9;
  return alarm;
}

}  // namespace

Result<AlarmPage> stored_alarms(Database& database, const AlarmQuery& query) {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<AlarmPage> {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::read);
    const std::string utc = utc_of_time_sql("e.time_ns");
    std::string sql = "SELECT e.session_id, e.number, " + utc + kRows;
    if (query.fault) sql += "AND e.name = ?4 ";
    if (query.session) sql += "AND e.session_id = ?5 ";
    if (query.from_utc_ns) sql += "AND " + utc + " >= ?6 ";
    if (query.to_utc_ns) sql += "AND " + utc + " < ?7 ";
    Statement rows(handle, sql + "ORDER BY e.session_id DESC, e.number DESC LIMIT ?3");
    constexpr std::int64_t kEnd = std::numeric_limits<std::int64_t>::max();
    const AlarmPlace before = query.before.value_or(AlarmPlace{kEnd, kEnd});
    // One more than asked tells whether a next page exists.
    rows.integer(1, before.session).integer(2, before.number).unsigned_integer(3, query.limit + 1);
    if (query.fault) rows.text(4, query.fault);
    if (query.session) rows.integer(5, *query.session);
    if (query.from_utc_ns) rows.integer(6, *query.from_utc_ns);
    if (query.to_utc_ns) rows.integer(7, *query.to_utc_ns);
    AlarmPage page;
    while (rows.step()) {
      if (page.items.size() == query.limit) {
        page.next = page.items.back().place;
        break;
      }
      page.items.push_back(alarm_at(rows));
    }
    return page;
  });
}

}  // namespace hoist::db
