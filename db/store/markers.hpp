// The markers of recorded sessions, as people change them afterwards.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

struct MarkerInfo {
  std::int64_t number = 0;  ///< within its session
  Marker marker;
  double time_s = 0;  ///< of its step, since the session's start
  std::string tag;    ///< of text, kind and time
};

/// What of a marker may be changed; absent stays. `time_s`: since the session's start, within its samples.
struct MarkerPatch {
  std::optional<std::string> text, kind;
  std::optional<double> time_s;
};

/// `expected`: the tag that the change was made for, empty = any. Errors: not_found, changed, bad_value (text, kind, time_s), busy, disk_full.
class MarkerStore {
 public:
  explicit MarkerStore(Database& database) : database_(&database) {}
  /// In the order in which they were set, those with numbers above `after`.
  Result<std::vector<MarkerInfo>> list(SessionId session, std::int64_t after, std::size_t limit) const;
  /// In a session that has ended; in one under way it is the writer's (SessionWriter::store_marker). Errors: not_found, wrong_state (under way),
  /// bad_value (text, kind), busy, disk_full.
  Status add(SessionId session, const Marker& marker);
  Result<MarkerInfo> change(SessionId session, std::int64_t number, const MarkerPatch& patch, const std::string& expected);
  /// Overwritten, too.
  Status remove(SessionId session, std::int64_t number, const std::string& expected);

 private:
  Database* database_;
};

}  // namespace hoist::db
