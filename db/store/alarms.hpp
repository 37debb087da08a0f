// The alarms of all recorded sessions: each fault that was raised while something was being recorded, newest session first.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// Where an alarm stands: its session, and its number among the session's events.
struct AlarmPlace {
  SessionId session = 0;
  std::int64_t number = 0;
  bool operator==(const AlarmPlace&) const = default;
};
struct StoredAlarm {
  AlarmPlace place;
  std::int64_t utc_ns = 0;         ///< by the wall clock as it was set then
  double time_s = 0;               ///< since the session's start
  std::string fault;               ///< as it was called then
  std::optional<double> lasted_s;  ///< absent: not over before the session's end
  bool simulated = false;
  std::optional<std::string> subject;
};
struct AlarmQuery {
  std::size_t limit = 50;  ///< 1 to kMaxPage
  std::optional<AlarmPlace> before = {};
  std::optional<std::string> fault = {};
  std::optional<SessionId> session = {};
  std::optional<std::int64_t> from_utc_ns = {}, to_utc_ns = {};  ///< from <= t < to
};
struct AlarmPage {
  std::vector<StoredAlarm> items;
  std::optional<AlarmPlace> next;
};

/// Errors: bad_value (limit), busy, io.
Result<AlarmPage> stored_alarms(Database& database, const AlarmQuery& query);

}  // namespace hoist::db
