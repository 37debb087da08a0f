#include "db/store/trend.hpp"

#include <limits>

#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

Result<TrendPage> trend_sessions(Database& database, std::int64_t patient, std::size_t limit, std::optional<SessionId> before) {
  if (limit == 0 || limit > kMaxPage) return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<TrendPage> {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::read);
    if (!patient_row(handle, patient)) return Error{ErrorKind::not_found, "there is no patient " + std::to_string(patient), {}};
    TrendPage page;
    const std::string of_patient =
        "FROM sessions JOIN visits ON visits.id = visit_id WHERE patient_id = ?1 AND ended_utc_ns IS NOT NULL AND standby = 0 AND "
        "simulated = ";
    if (Statement count(handle, "SELECT count(*) " + of_patient + "1"); count.integer(1, patient).step())
      page.simulated = count.unsigned_at(0);
    Statement rows(handle, "SELECT sessions.id, visits.id, day, started_utc_ns, exercise " + of_patient +
                               "0 AND sessions.id < ?2 ORDER BY sessions.id DESC LIMIT ?3");
    rows.integer(1, patient).integer(2, before.value_or(std::numeric_limits<SessionId>::max())).unsigned_integer(3, limit + 1);
    while (rows.step()) {
      if (page.items.size() == limit) {
        page.next = page.items.back().session;
        break;
      }
      page.items.push_back({.session = rows.integer_at(0),
                            .visit = rows.integer_at(1),
                            .day = rows.text_at(2),
                            .started_utc_ns = rows.integer_at(3),
                            .exercise_json = rows.optional_text_at(4)});
    }
    return page;
  });
}

}  // namespace hoist::db
