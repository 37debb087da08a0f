// How long sessions are kept, and which ones may go. Deleting them is deletion.hpp.
#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

inline constexpr std::int64_t kLeastKept_days = 30, kMostKept_days = 36500;
inline constexpr std::int64_t kLeastShare_percent = 5, kMostShare_percent = 90;
/// The wall clock is believed this far beyond the newest session: one that was set wrong must not make all sessions old.
inline constexpr std::int64_t kClockBeyond_days = 7;
/// A session of before 2020 was recorded with a clock that was not set: its age is not known, so it is never too old.
inline constexpr std::int64_t kClockWasSet_utc_ns = 1'577'836'800'000'000'000;

/// Off unless one of the first two is set.
struct RetentionRule {
  std::optional<std::int64_t> days = {};          ///< a session is deleted when it is older
  std::optional<std::int64_t> disk_percent = {};  ///< the oldest are deleted while the recordings take more of their disk
  bool needs_backup = true;                       ///< only sessions that a checked backup holds are deleted
  [[nodiscard]] bool on() const { return days || disk_percent; }
  bool operator==(const RetentionRule&) const = default;
};
/// Off when none was ever set. Error corrupt: what is stored is no rule.
Result<RetentionRule> retention_rule(Database& database);
/// For the rule whose tag this is (edit_tag.hpp); empty = any. Errors: bad_value (days, disk_percent), changed.
Status set_retention_rule(Database& database, const RetentionRule& rule, std::string_view tag = {});
std::string tag_of(const RetentionRule& rule);
/// As it is stored and told: days, disk_percent, needs_backup.
nlohmann::json rule_json(const RetentionRule& rule);
/// Of such a JSON; what is missing or of another kind stays as in RetentionRule.
RetentionRule rule_of(const nlohmann::json& told);

/// What a rule deletes now. Never in it: a session that is being recorded, those of today and of the newest day that has any.
struct RetentionPlan {
  std::vector<SessionId> sessions;              ///< in the order of their numbers
  std::uint64_t bytes = 0;                      ///< that their samples, frames and journal take
  std::int64_t from_utc_ns = 0, to_utc_ns = 0;  ///< earliest and latest start of them
  std::uint64_t without_backup = 0;             ///< further ones, which are kept only because no backup holds them
  std::uint64_t used_bytes = 0;                 ///< of the file, without its free pages
  std::uint64_t excess_bytes = 0;               ///< by which the recordings still exceed their share afterwards
};
/// `disk_bytes`: size of the disk the file is on. Nothing when `step` (called with 0 to 1) ended it.
Result<std::optional<RetentionPlan>> plan_retention(Database& database, const RetentionRule& rule, std::int64_t utc_ns,
                                                    std::uint64_t disk_bytes, const CheckStep& step);

/// A checked backup in `folder` holds the sessions up to `newest`.
Status note_backup(Database& database, std::int64_t utc_ns, const std::filesystem::path& folder, SessionId newest);

}  // namespace hoist::db
