// What happened over all sessions: changes of parameters, alarms, a patient's figures. Reading runs on the recorder's thread.
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/alarms.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/parameter_log.hpp"
#include "db/summary/provenance.hpp"
#include "db/summary/session_json.hpp"
#include "db/summary/trend.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/api/pieces.hpp"
#include "server/api/trend_reading.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
constexpr std::size_t kTrendMost = 50, kTrendUsual = 20;

template <typename T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}
}  // namespace

void list_parameter_history(const CallPtr& call) {
  db::ChangeQuery wanted;
  if (!read_page(call, wanted) || !read_moment(call, "from_utc_ms", wanted.from_utc_ns) ||
      !read_moment(call, "to_utc_ms", wanted.to_utc_ns) || !read_id(call, "patient", wanted.patient))
    return;
  wanted.name = query(*call, "name");
  if (wanted.name && !contract::find_param(*wanted.name)) return call->fail(bad_query("name", "must be a parameter", {}, {}));
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::ParameterLog(database).list(wanted);
    if (!page) return store_error(page.error(), path);
    json items = json::array();
    for (const db::ParameterChange& change : page->items)
      items.push_back({{"id", change.id},
                       {"utc_ms", change.utc_ns / 1'000'000},
                       {"session", or_null(change.session)},
                       {"name", change.name},
                       {"value", change.value},
                       {"before", change.before},
                       {"how", change.reason},
                       {"source", or_null(change.source)},
                       {"actor", db::actor_json(change.actor)}});
    return json_response({{"items", std::move(items)}, {"next", next_json(page->next)}});
  });
}

void diff_parameters(const CallPtr& call) {
  std::optional<std::int64_t> from, to = call->services.utc_ns();
  if (!read_moment(call, "from_utc_ms", from) || !read_moment(call, "to_utc_ms", to)) return;
  if (!from) return call->fail(bad_query("from_utc_ms", "must be given", {}, {}));
  if (*to < *from) return call->fail(bad_query("to_utc_ms", "must not be before from_utc_ms", {}, {}));
  with_database(call, [from = *from, to = *to, path = call->request.path](db::Database& database) -> Response {
    const auto differences = db::ParameterLog(database).between(from, to);
    if (!differences) return store_error(differences.error(), path);
    json items = json::array();
    for (const db::ParameterDifference& one : *differences) items.push_back({{"name", one.name}, {"from", one.from}, {"to", one.to}});
    return json_response({{"from_utc_ms", from / 1'000'000}, {"to_utc_ms", to / 1'000'000}, {"items", std::move(items)}});
  });
}

namespace {
std::string text_of(const db::AlarmPlace& place) { return std::to_string(place.session) + "-" + std::to_string(place.number); }

// As text_of writes it. False: the call has failed.
bool read_alarm_cursor(const CallPtr& call, std::optional<db::AlarmPlace>& before) {
  const auto cursor = query(*call, "cursor");
  if (!cursor || cursor->empty()) return true;
  const std::size_t dash = cursor->find('-');
  const auto session = number<std::int64_t>(std::string_view(*cursor).substr(0, dash));
  const auto event = dash == std::string::npos ? std::nullopt : number<std::int64_t>(std::string_view(*cursor).substr(dash + 1));
  if (!session || !event) {
    call->fail(bad_query("cursor", "must be the `next` of an earlier answer", {}, {}));
    return false;
  }
  before = db::AlarmPlace{*session, *event};
  return true;
}
}  // namespace

void list_alarms(const CallPtr& call) {
  db::AlarmQuery wanted;
  if (!read_limit(call, wanted.limit, db::kMaxPage) || !read_alarm_cursor(call, wanted.before) ||
      !read_moment(call, "from_utc_ms", wanted.from_utc_ns) || !read_moment(call, "to_utc_ms", wanted.to_utc_ns) ||
      !read_id(call, "session", wanted.session))
    return;
  wanted.fault = query(*call, "fault");
  if (wanted.fault && contract::find_fault(*wanted.fault) == nullptr) return call->fail(bad_query("fault", "must be a fault", {}, {}));
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::stored_alarms(database, wanted);
    if (!page) return store_error(page.error(), path);
    json items = json::array();
    for (const db::StoredAlarm& alarm : page->items)
      items.push_back({{"session", alarm.place.session},
                       {"utc_ms", alarm.utc_ns / 1'000'000},
                       {"time_s", alarm.time_s},
                       {"fault", alarm.fault},
                       {"lasted_s", or_null(alarm.lasted_s)},
                       {"simulated", alarm.simulated},
                       {"subject", or_null(alarm.subject)}});
    return json_response({{"items", std::move(items)}, {"next", page->next ? json(text_of(*page->next)) : json(nullptr)}});
  });
}

namespace {
// "20261110-1794300000000000000-12", of a day YYYY-MM-DD.
std::string text_of(const db::WalkOrder& order) {
  std::string day = order.day;
  std::erase(day, '-');
  return day + "-" + std::to_string(order.started_utc_ns) + "-" + std::to_string(order.session);
}

// As text_of writes it. False: the call has failed.
bool read_trend_cursor(const CallPtr& call, std::optional<db::WalkOrder>& before) {
  constexpr std::size_t kDay_chars = 8;
  const auto cursor = query(*call, "cursor");
  if (!cursor || cursor->empty()) return true;
  const std::string_view text = *cursor, day = text.substr(0, kDay_chars), rest = text.substr(day.size());
  const std::size_t dash = rest.rfind('-');
  const auto started = dash == 0 || dash == std::string_view::npos ? std::nullopt : number<std::int64_t>(rest.substr(1, dash - 1));
  const auto session = started ? number<std::int64_t>(rest.substr(dash + 1)) : std::nullopt;
  if (number<std::uint32_t>(day) && rest.starts_with('-') && session) {
    before = {std::string(day.substr(0, 4)) + "-" + std::string(day.substr(4, 2)) + "-" + std::string(day.substr(6)), *started, *session};
    if (text_of(*before) == text) return true;
  }
  call->fail(bad_query("cursor", "must be the `next` of an earlier answer", {}, {}));
  return false;
}

// `entries`: those of the page's items, then of its firsts.
json trend_json(const db::TrendPage& page, const std::vector<db::TrendEntry>& entries) {
  json items = json::array(), firsts = json::array(), changes = json::array();
  for (const db::TrendEntry& entry : entries)
    (entry.session.order() >= page.items.back().order() ? items : firsts).push_back(db::trend_item_json(entry));
  for (const db::FigureChange& change : db::changes_in(entries)) changes.push_back(db::change_json(change));
  return {{"items", std::move(items)},
          {"next", page.next ? json(text_of(*page.next)) : json(nullptr)},
          {"firsts", std::move(firsts)},
          {"simulated_left_out", page.simulated},
          {"changes", std::move(changes)}};
}
}  // namespace

void get_trend(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  db::TrendQuery wanted{.limit = kTrendUsual};
  if (!id || !read_limit(call, wanted.limit, kTrendMost) || !read_trend_cursor(call, wanted.before) ||
      !read_id(call, "comparable_to", wanted.comparable_to))
    return;
  using Page = db::Result<db::TrendPage>;
  const auto list = [id = *id, wanted](Records& records) -> Page {
    const auto database = database_for_piece(records);
    return database ? db::trend_sessions(**database, id, wanted) : Page(database.error());
  };
  ask_recorder<Page>(call, list, [call](Page page) {
    if (!page) return call->respond(store_error(page.error(), call->request.path));
    std::vector<db::TrendSession> sessions = page->items;
    sessions.insert(sessions.end(), page->firsts.begin(), page->firsts.end());
    read_trend(call, std::move(sessions),
               [call, page = std::move(*page)](const std::vector<db::TrendEntry>& entries) { call->respond(trend_json(page, entries)); });
  });
}

}  // namespace hoist::server::api
