// Every change of a parameter in force, also outside sessions: what, when, who, why. Rows are only added.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "db/store/change_reasons.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

struct ParameterChange {
  std::int64_t id = 0;
  std::int64_t utc_ns = 0;
  std::uint64_t core_start_time_ns = 0, time_ns = 0;
  std::uint32_t parameter = 0;  ///< id in params.def
  std::string name;
  double value = 0, before = 0;
  std::string reason;                      ///< kFirstSeen or one of kChangeReasons
  std::optional<std::string> source = {};  ///< name of the preset or profile
  std::optional<Actor> actor = {};         ///< absent: the core by itself, or not known
  std::optional<SessionId> session = {};   ///< that was being recorded then; found when it is read
};
struct ChangeQuery {
  std::size_t limit = 50;  ///< 1 to kMaxPage
  std::optional<std::int64_t> before = {};
  std::optional<std::string> name = {}, reason = {}, user = {};
  std::optional<std::int64_t> patient = {};                      ///< only during sessions of this patient
  std::optional<std::int64_t> from_utc_ns = {}, to_utc_ns = {};  ///< from <= t < to
};
struct ParameterDifference {
  std::uint32_t parameter = 0;
  std::string name;
  double from = 0, to = 0;
};

class ParameterLog {
 public:
  explicit ParameterLog(Database& database) : database_(&database) {}
  /// All or nothing.
  Status append(std::span<const ParameterChange> changes);
  /// The first row of each parameter that has none, and a row `not_seen` for each whose newest value is another: `now` holds what is in force
  /// (parameter, name, value, times). All or nothing.
  Status catch_up(std::span<const ParameterChange> now);
  /// Newest first, without the first rows.
  Result<VisitPage<ParameterChange>> list(const ChangeQuery& query) const;
  /// The newest value of each parameter, by its id.
  Result<std::map<std::uint32_t, double>> latest() const;
  /// What was other at the second moment than at the first, in the order of the parameters' ids.
  Result<std::vector<ParameterDifference>> between(std::int64_t from_utc_ns, std::int64_t to_utc_ns) const;

 private:
  Database* database_;
};

}  // namespace hoist::db
