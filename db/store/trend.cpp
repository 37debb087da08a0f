#include "db/store/trend.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/task_record.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

using nlohmann::json;

namespace {

TrendSession session_at(const Statement& row) {
  return {.session = row.integer_at(0),
          .visit = row.integer_at(1),
          .day = row.text_at(2),
          .started_utc_ns = row.integer_at(3),
          .exercise_json = row.optional_text_at(4)};
}

// The walk that others are to be comparable to, of any patient.
std::optional<TrendSession> walk_of(sqlite3* handle, SessionId session) {
  Statement row(handle, "SELECT exercise FROM sessions WHERE id = ?1");
  if (!row.integer(1, session).step()) return std::nullopt;
  return TrendSession{.session = session, .day = {}, .exercise_json = row.optional_text_at(0)};
}

// `walks`: from the newest to the oldest.
void fill_page(std::vector<TrendSession> walks, std::size_t limit, const std::optional<json>& wanted, TrendPage& page) {
  struct Kind {
    json walked;
    std::optional<TrendSession> oldest = {};          // behind the items
    std::map<std::int64_t, std::int64_t> walks = {};  // of each visit, so far
  };
  std::vector<Kind> kinds;
  for (TrendSession& session : walks) {
    json kind = walked_as(session);
    if (wanted && kind != *wanted) continue;
    auto known = std::ranges::find(kinds, kind, &Kind::walked);
    const bool item = page.items.size() < limit;
    if (item && known == kinds.end()) known = kinds.insert(kinds.end(), {.walked = std::move(kind)});
    if (known != kinds.end()) session.place = -known->walks[session.visit]++;
    if (item) {
      page.items.push_back(std::move(session));
    } else {
      page.next = page.items.back().order();
      if (known != kinds.end()) known->oldest = std::move(session);
    }
  }
  for (Kind& kind : kinds)
    if (kind.oldest) page.firsts.push_back(std::move(*kind.oldest));
  std::ranges::sort(page.firsts, std::ranges::greater{}, &TrendSession::order);
}

}  // namespace

json walked_as(const TrendSession& session) {
  json exercise = exercise_as_told(session.exercise_json);
  if (exercise.is_null()) exercise = {{"shape", "free"}};
  const auto task = task_of_stored(session.exercise_json);
  if (!task) return json::array({std::move(exercise), nullptr, nullptr});
  return json::array(
      {std::move(exercise), task->task, {{"by", task_end_name(task->ends)}, {"goal", task->goal}, {"edge_m", task->edge_m}}});
}

bool comparable(const TrendSession& a, const TrendSession& b) { return walked_as(a) == walked_as(b); }

Result<TrendPage> trend_sessions(Database& database, std::int64_t patient, const TrendQuery& query) {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<TrendPage> {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::read);
    if (!patient_row(handle, patient)) return Error{ErrorKind::not_found, "there is no patient " + std::to_string(patient), {}};
    std::optional<json> wanted;
    if (query.comparable_to) {
      const auto walk = walk_of(handle, *query.comparable_to);
      if (!walk) return Error{ErrorKind::not_found, "there is no session " + std::to_string(*query.comparable_to), {}};
      wanted.emplace(walked_as(*walk));
    }
    TrendPage page;
    const std::string of_patient =
        "FROM sessions JOIN visits ON visits.id = visit_id WHERE patient_id = ?1 AND ended_utc_ns IS NOT NULL AND standby = 0 AND "
        "simulated = ";
    if (Statement count(handle, "SELECT count(*) " + of_patient + "1"); count.integer(1, patient).step())
      page.simulated = count.unsigned_at(0);
    std::vector<TrendSession> walks;
    Statement rows(handle, "SELECT sessions.id, visits.id, day, started_utc_ns, exercise " + of_patient + "0");
    rows.integer(1, patient);
    while (rows.step())
      if (TrendSession walk = session_at(rows); !query.before || walk.order() < *query.before) walks.push_back(std::move(walk));
    std::ranges::sort(walks, std::ranges::greater{}, &TrendSession::order);
    fill_page(std::move(walks), query.limit, wanted, page);
    return page;
  });
}

}  // namespace hoist::db
