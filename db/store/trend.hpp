// Which recordings a patient's trend is made of: those of a real hoist that have ended. What was walked in the simulator never enters it.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

struct TrendSession {
  SessionId session = 0;
  std::int64_t visit = 0;
  std::string day;  ///< of the visit
  std::int64_t started_utc_ns = 0;
  std::optional<std::string> exercise_json;
};
struct TrendPage {
  std::vector<TrendSession> items;  ///< newest first
  std::optional<SessionId> next;
  std::uint64_t simulated = 0;  ///< ended recordings of this patient that were left out
};

/// `limit`: 1 to kMaxPage; `before`: only older ones. Errors: not_found, bad_value (limit), busy, io.
Result<TrendPage> trend_sessions(Database& database, std::int64_t patient, std::size_t limit, std::optional<SessionId> before);

}  // namespace hoist::db
