// A patient's figures over the sessions, which of them have changed by more than they vary by themselves, and which improve within a visit.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "db/metrics/change.hpp"
#include "db/metrics/learning.hpp"
#include "db/store/trend.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::db {

/// One session of a trend with its figures; none: its recording is damaged.
struct TrendEntry {
  TrendSession session;
  std::optional<SessionMetrics> metrics;
};
/// Nothing when the session was deleted meanwhile. Errors: busy, io.
Result<std::optional<TrendEntry>> trend_entry(Database& database, const TrendSession& session);
/// The same of figures that were read in pieces, or of why they could not be.
Result<std::optional<TrendEntry>> trend_entry(const TrendSession& session, Result<SessionMetrics> metrics);

struct FigureChange {
  TrendSession walked;  ///< one of the compared sessions: their exercise, task and goal
  std::string_view figure;
  Change change;
  std::optional<Change> retention;
  Learning learning;
};
/// Of each figure that has a value in comparable walks. `entries`: newest first, as trend_sessions gives them; what was walked last comes first.
[[nodiscard]] std::vector<FigureChange> changes_in(std::span<const TrendEntry> entries);

/// As REST tells it: an item of Trend, and of its changes.
[[nodiscard]] nlohmann::json trend_item_json(const TrendEntry& entry);
[[nodiscard]] nlohmann::json change_json(const FigureChange& change);

}  // namespace hoist::db
