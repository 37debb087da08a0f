// What routes that read the database share: numbers of a path or query, pages of lists, work on the recorder's thread.
#pragma once
#include <algorithm>
#include <charconv>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/store/session_reader.hpp"
#include "server/api/answers.hpp"

namespace hoist::server::api {

template <typename T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

inline Problem bad_query(std::string name, std::string message, std::optional<double> min, std::optional<double> max) {
  Problem problem{.status = 422, .name = "invalid", .title = "A value cannot be used", .detail = name + " " + message};
  problem.errors.push_back({std::move(name), std::move(message), std::nullopt, min, max});
  return problem;
}

inline std::optional<std::string> query(const Call& call, const char* name) {
  const auto at = call.request.query.find(name);
  return at == call.request.query.end() ? std::nullopt : std::optional{at->second};
}

// Runs `work` with the database, or says why there is none.
inline void with_database(const CallPtr& call, std::function<Response(db::Database&)> work) {
  in_background(call, [work = std::move(work), path = call->request.path](Records& records) -> Response {
    db::Database* database = records.database();
    return database == nullptr ? no_database(records.why(), path) : work(*database);
  });
}
// Limit and cursor of a list. False: the call has failed.
inline bool read_limit(const CallPtr& call, std::size_t& limit, std::size_t most) {
  const auto text = query(*call, "limit");
  if (!text) return true;
  const auto value = number<std::size_t>(*text);
  if (!value || *value < 1 || *value > most) {
    call->fail(bad_query("limit", "must be a whole number from 1 to " + std::to_string(most), 1, static_cast<double>(most)));
    return false;
  }
  limit = *value;
  return true;
}
inline bool read_cursor(const CallPtr& call, std::optional<std::int64_t>& before) {
  const auto cursor = query(*call, "cursor");
  if (!cursor || cursor->empty()) return true;
  before = number<std::int64_t>(*cursor);
  if (before) return true;
  call->fail(bad_query("cursor", "must be the `next` of an earlier answer", {}, {}));
  return false;
}
template <typename Query>
bool read_page(const CallPtr& call, Query& wanted) {
  return read_limit(call, wanted.limit, db::kMaxPage) && read_cursor(call, wanted.before);
}

// What a request names of a list whose rows have numbers: `last` is the number of the last row of the page before.
struct ListPage {
  std::size_t limit = 50;
  std::optional<std::int64_t> last = {};
};
inline bool read_page(const CallPtr& call, ListPage& page) {
  return read_limit(call, page.limit, db::kMaxPage) && read_cursor(call, page.last);
}
// A page of a list from up to `limit` + 1 rows. `cursor_of` gives the text by which a client names the row behind which it goes on.
template <typename Row, typename ToJson, typename CursorOf>
nlohmann::json page_json(const std::vector<Row>& rows, std::size_t limit, ToJson to_json, CursorOf cursor_of) {
  nlohmann::json items = nlohmann::json::array(), next;
  for (std::size_t i = 0; i < std::min(limit, rows.size()); ++i) items.push_back(to_json(rows[i]));
  if (rows.size() > limit) next = cursor_of(rows[limit - 1]);
  return {{"items", std::move(items)}, {"next", std::move(next)}};
}

inline nlohmann::json next_json(const std::optional<std::int64_t>& next) {
  return next ? nlohmann::json(std::to_string(*next)) : nlohmann::json(nullptr);
}

// The number in the path, of a `thing`; nothing after a 404.
inline std::optional<std::int64_t> path_id(const CallPtr& call, const char* thing, std::size_t at = 0) {
  const auto id = number<std::int64_t>(call->path_values.at(at));
  if (id && *id >= 0) return id;
  call->fail(
      {.status = 404, .name = "unknown", .title = "There is no such thing", .detail = "There is no such " + std::string(thing) + "."});
  return std::nullopt;
}

// The tag of If-Match, or several with commas (db::check_tag); empty for "*". The router has refused a request without the header.
inline std::string given_tag(const Call& call) { return strong_tags(call.request.header("if-match")); }

// A moment in ms of UTC as ns; nothing when it is not in the query. False: the call has failed.
inline bool read_moment(const CallPtr& call, const char* name, std::optional<std::int64_t>& utc_ns) {
  const auto text = query(*call, name);
  if (!text) return true;
  constexpr std::int64_t kMost_ms = std::numeric_limits<std::int64_t>::max() / 1'000'000;
  const auto value = number<std::int64_t>(*text);
  if (!value || *value < 0 || *value > kMost_ms) {
    call->fail(bad_query(name, "must be a time in whole milliseconds since 1970", 0, static_cast<double>(kMost_ms)));
    return false;
  }
  utc_ns = *value * 1'000'000;
  return true;
}

// The number of something; nothing when it is not in the query. False: the call has failed.
inline bool read_id(const CallPtr& call, const char* name, std::optional<std::int64_t>& id) {
  const auto text = query(*call, name);
  if (!text) return true;
  id = number<std::int64_t>(*text);
  if (id) return true;
  call->fail(bad_query(name, "must be a whole number", {}, {}));
  return false;
}

inline Response no_content() {
  Response response;
  response.status = 204;
  return response;
}

inline std::string etag_of(const std::string& tag) { return "\"" + tag + "\""; }

// One editable row: its JSON, and its tag as ETag.
inline Response row_response(const nlohmann::json& row, unsigned status = 200) {
  Response response = json_response(row, status);
  response.set("ETag", etag_of(row.at("etag").get<std::string>()));
  return response;
}

// A page of rows, and how to ask for the next one.
template <typename Page, typename ToJson>
Response rows_response(const Page& page, ToJson to_json) {
  nlohmann::json items = nlohmann::json::array();
  for (const auto& item : page.items) items.push_back(to_json(item));
  return json_response({{"items", std::move(items)}, {"next", next_json(page.next)}});
}

// The changed row as the answer.
inline OutcomeDone answer_row(const CallPtr& call) {
  return answer_with(call, [call](const Outcome& outcome) { call->respond(row_response(nlohmann::json::parse(outcome.row))); });
}
// A new row, and where it is: in `rows`, for instance "/api/v1/lines/".
inline OutcomeDone answer_created(const CallPtr& call, std::string_view rows) {
  return answer_with(call, [call, rows = std::string{rows}](const Outcome& outcome) {
    const nlohmann::json row = nlohmann::json::parse(outcome.row);
    Response response = row_response(row, 201);
    response.set("Location", rows + std::to_string(row.at("id").get<std::int64_t>()));
    call->respond(std::move(response));
  });
}
inline OutcomeDone answer_gone(const CallPtr& call) {
  return answer_with(call, [call](const Outcome&) { call->respond(no_content()); });
}

}  // namespace hoist::server::api
