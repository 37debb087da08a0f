#include "db/summary/trend.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "db/metrics/metric_list.hpp"
#include "db/store/exercise_json.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {

namespace {
// The exercises of the entries, the one walked last first.
std::vector<std::optional<std::string>> exercises_of(std::span<const TrendEntry> entries) {
  std::vector<std::optional<std::string>> all;
  for (const TrendEntry& entry : entries)
    if (std::ranges::find(all, entry.session.exercise_json) == all.end()) all.push_back(entry.session.exercise_json);
  return all;
}

// The valid values of a figure, oldest first.
std::vector<Measured> values_of(std::span<const TrendEntry> entries, const std::optional<std::string>& exercise, std::size_t figure) {
  std::vector<Measured> values;
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    if (!entry->metrics || entry->session.exercise_json != exercise) continue;
    if (const auto& value = entry->metrics->figures[figure].value)
      values.push_back({.session = entry->session.session, .visit = entry->session.visit, .value = *value});
  }
  return values;
}
}  // namespace

Result<std::optional<TrendEntry>> trend_entry(Database& database, const TrendSession& session) {
  auto metrics = session_metrics(database, session.session);
  if (metrics) return std::optional(TrendEntry{session, std::move(*metrics)});
  if (metrics.error().kind == ErrorKind::not_found) return std::optional<TrendEntry>{};
  // A damaged recording is a gap in the trend, not its end.
  if (metrics.error().kind == ErrorKind::corrupt) return std::optional(TrendEntry{session, std::nullopt});
  return metrics.error();
}

std::vector<FigureChange> changes_in(std::span<const TrendEntry> entries) {
  std::vector<FigureChange> all;
  for (const auto& exercise : exercises_of(entries))
    for (std::size_t i = 0; i < kMetrics.size(); ++i)
      if (const auto change = change_of(kMetrics[i].key, values_of(entries, exercise, i)))
        all.push_back({.exercise_json = exercise, .figure = kMetrics[i].key, .change = *change});
  return all;
}

nlohmann::json trend_item_json(const TrendEntry& entry) {
  const TrendSession& session = entry.session;
  nlohmann::json row{{"session", session.session},
                     {"visit", session.visit},
                     {"day", session.day},
                     {"started_utc_ms", session.started_utc_ns / 1'000'000},
                     {"exercise", exercise_as_told(session.exercise_json)},
                     {"figures", nullptr},
                     {"reason_code", nullptr}};
  if (!entry.metrics) return row;
  const nlohmann::json told = metrics_json(*entry.metrics, session.exercise_json);
  row["figures"] = nlohmann::json::object();
  for (const MetricInfo& figure : kMetrics) row["figures"][std::string{figure.key}] = told.at(std::string{figure.key});
  row["reason_code"] = told.at("reason_code");
  return row;
}

nlohmann::json change_json(const FigureChange& one) {
  using nlohmann::json;
  const Change& change = one.change;
  return {{"exercise", exercise_as_told(one.exercise_json)},
          {"figure", one.figure},
          {"first_session", change.first.session},
          {"last_session", change.last.session},
          {"first", change.first.value},
          {"last", change.last.value},
          {"least", change.least ? json(*change.least) : json(nullptr)},
          {"source", change.published ? json(change.published->source) : json(nullptr)},
          {"whom", change.published ? json{{"en", change.published->whom_en}, {"de", change.published->whom_de}} : json(nullptr)},
          {"repeats", change.repeats},
          {"reason_code", change.why == NoChange::none ? json(nullptr) : json(no_change_name(change.why))}};
}

}  // namespace hoist::db
