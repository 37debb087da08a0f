// Which recordings a patient's trend is made of: those of a real hoist that have ended. What was walked in the simulator never enters it.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/store/walk_order.hpp"

namespace hoist::db {

struct TrendSession {
  SessionId session = 0;
  std::int64_t visit = 0;
  std::string day;  ///< of the visit
  std::int64_t started_utc_ns = 0;
  std::optional<std::string> exercise_json;
  /// Among the comparable walks of its visit, with a figure or without: 0 is the newest one read, -1 the walk before it.
  std::int64_t place = 0;
  [[nodiscard]] WalkOrder order() const { return {day, started_utc_ns, session}; }
};

/// What makes walks comparable: [exercise with its sizes, name of the task, {"by", "goal", "edge_m"} of its end]; both null without a task.
/// Free walking is no exercise, or one that only a task names.
[[nodiscard]] nlohmann::json walked_as(const TrendSession& session);
/// Whether two walks may be compared: the same exercise with the same sizes, and the same task with the same goal, whichever repetition.
[[nodiscard]] bool comparable(const TrendSession& a, const TrendSession& b);

struct TrendQuery {
  std::size_t limit = 50;                       ///< 1 to kMaxPage
  std::optional<WalkOrder> before = {};         ///< only older ones
  std::optional<SessionId> comparable_to = {};  ///< only walks that may be compared with this one
};
struct TrendPage {
  std::vector<TrendSession> items;  ///< newest first
  std::optional<WalkOrder> next;
  /// The oldest walk comparable to each of the items, where it is no item itself; newest first, all older than the items.
  std::vector<TrendSession> firsts;
  std::uint64_t simulated = 0;  ///< ended recordings of this patient that were left out
};

/// Errors: not_found (the patient, or `comparable_to`), bad_value (limit), busy, io.
Result<TrendPage> trend_sessions(Database& database, std::int64_t patient, const TrendQuery& query);

}  // namespace hoist::db
