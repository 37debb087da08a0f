#include "db/summary/trend.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/metrics/metric_list.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/task_record.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {

using nlohmann::json;

namespace {
// What was walked, with the names of REST.
json walked_json(const TrendSession& session) {
  const json walked = walked_as(session);
  return {{"exercise", exercise_as_told(session.exercise_json)}, {"task", walked[1]}, {"ends", walked[2]}};
}

// Only what it is called: walks are compared along the same points.
json line_name(const TrendSession& session) {
  const auto task = task_of_stored(session.exercise_json);
  return task && !task->line.empty() ? json(task->line) : json(nullptr);
}

// The comparable entries in groups, what was walked last first.
std::vector<std::vector<const TrendEntry*>> groups_of(std::span<const TrendEntry> entries) {
  std::vector<json> kinds;
  std::vector<std::vector<const TrendEntry*>> groups;
  for (const TrendEntry& entry : entries) {
    json kind = walked_as(entry.session);
    const auto at = std::ranges::find(kinds, kind) - kinds.begin();
    if (at == std::ssize(kinds)) {
      kinds.push_back(std::move(kind));
      groups.emplace_back();
    }
    groups[static_cast<std::size_t>(at)].push_back(&entry);
  }
  return groups;
}

// The valid values of a figure, oldest first.
std::vector<Measured> values_of(std::span<const TrendEntry* const> newest_first, std::size_t figure) {
  std::vector<Measured> values;
  for (const TrendEntry* entry : newest_first)
    if (entry->metrics && entry->metrics->figures[figure].value)
      values.push_back({entry->session.session, entry->session.visit, *entry->metrics->figures[figure].value, entry->session.place});
  std::ranges::reverse(values);
  return values;
}
}  // namespace

Result<std::optional<TrendEntry>> trend_entry(Database& database, const TrendSession& session) {
  return trend_entry(session, session_metrics(database, session.session));
}

Result<std::optional<TrendEntry>> trend_entry(const TrendSession& session, Result<SessionMetrics> metrics) {
  if (metrics) return std::optional(TrendEntry{session, std::move(*metrics)});
  if (metrics.error().kind == ErrorKind::not_found) return std::optional<TrendEntry>{};
  // A damaged recording is a gap in the trend, not its end.
  if (metrics.error().kind == ErrorKind::corrupt) return std::optional(TrendEntry{session, std::nullopt});
  return metrics.error();
}

std::vector<FigureChange> changes_in(std::span<const TrendEntry> entries) {
  std::vector<FigureChange> all;
  for (const auto& group : groups_of(entries))
    for (std::size_t i = 0; i < kMetrics.size(); ++i)
      if (const auto values = values_of(group, i); !values.empty())
        all.push_back({.walked = group.front()->session,
                       .figure = kMetrics[i].key,
                       .change = *change_of(kMetrics[i].key, values),
                       .retention = retention_of(kMetrics[i].key, values),
                       .learning = learning_of(values)});
  return all;
}

json trend_item_json(const TrendEntry& entry) {
  const TrendSession& session = entry.session;
  json row = walked_json(session);
  row.update({{"session", session.session},
              {"visit", session.visit},
              {"day", session.day},
              {"started_utc_ms", session.started_utc_ns / 1'000'000},
              {"line", line_name(session)},
              {"figures", nullptr},
              {"reasons", json::object()},
              {"reason_code", nullptr}});
  if (!entry.metrics) return row;
  const json told = metrics_json(*entry.metrics, session.exercise_json);
  row["figures"] = json::object();
  for (const MetricInfo& figure : kMetrics) {
    const std::string key(figure.key);
    row["figures"][key] = told.at(key);
    if (told.at(key).is_null()) row["reasons"][key] = told.at("computed").at(key).at("reason_code");
  }
  row["reason_code"] = told.at("reason_code");
  return row;
}

namespace {
json why_json(NoChange why) { return why == NoChange::none ? json(nullptr) : json(no_change_name(why)); }
json learning_json(const Learning& learning) {
  json out{{"walks", learning.walks}, {"visits", learning.visits}, {"slope", nullptr}, {"reason_code", why_json(learning.why)}};
  if (learning.slope) out["slope"] = {{"middle", learning.slope->middle}, {"low", learning.slope->low}, {"high", learning.slope->high}};
  return out;
}
json retention_json(const std::optional<Change>& kept) {
  if (!kept) return nullptr;
  return {{"before_session", kept->first.session},
          {"after_session", kept->last.session},
          {"before", kept->first.value},
          {"after", kept->last.value},
          {"reason_code", why_json(kept->why)}};
}
}  // namespace

json change_json(const FigureChange& one) {
  const Change& change = one.change;
  json whom = nullptr;
  if (change.published != nullptr) whom = {{"en", change.published->whom_en}, {"de", change.published->whom_de}};
  json row = walked_json(one.walked);
  row.update({{"figure", one.figure},
              {"first_session", change.first.session},
              {"last_session", change.last.session},
              {"first", change.first.value},
              {"last", change.last.value},
              {"minimal_detectable_change", change.minimal ? json(*change.minimal) : json(nullptr)},
              {"source", change.published != nullptr ? json(change.published->source) : json(nullptr)},
              {"whom", std::move(whom)},
              {"repeats", change.repeats},
              {"reason_code", why_json(change.why)},
              {"retention", retention_json(one.retention)},
              {"learning", learning_json(one.learning)}});
  return row;
}

}  // namespace hoist::db
