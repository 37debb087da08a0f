#include "db/store/retention.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "db/store/edit_tag.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr std::string_view kSetting = "retention";
constexpr std::int64_t kSecond_ns = 1'000'000'000, kDay_s = 86'400;

Status check_range(const std::optional<std::int64_t>& value, std::int64_t least, std::int64_t most, const char* field) {
  if (!value || (*value >= least && *value <= most)) return {};
  return Error{ErrorKind::bad_value, std::string(field) + " must be " + std::to_string(least) + " to " + std::to_string(most), field};
}
Status check_rule(const RetentionRule& rule) {
  if (Status days = check_range(rule.days, kLeastKept_days, kMostKept_days, "days"); !days) return days;
  return check_range(rule.disk_percent, kLeastShare_percent, kMostShare_percent, "disk_percent");
}

// A session that no rule protects. Sessions count in the order of their numbers, which no clock can change.
struct Candidate {
  SessionId id = 0;
  std::int64_t started_utc_ns = 0;
  bool in_backup = false;
};
std::vector<Candidate> candidates(sqlite3* handle, std::int64_t utc_ns) {
  const std::string day = local_day_sql("started_utc_ns");
  // A day that has not come yet, by a clock that was set back since, counts as today.
  Statement row(handle,
                "SELECT id, started_utc_ns, id <= (SELECT coalesce(max(newest_session), 0) FROM backups) FROM sessions "
                "WHERE ended_utc_ns IS NOT NULL "
                "AND " +
                    day + " < " + local_day_sql("?1") + " AND " + day + " < (SELECT max(" + day + ") FROM sessions) ORDER BY id");
  row.integer(1, utc_ns);
  std::vector<Candidate> out;
  while (row.step()) out.push_back({row.integer_at(0), row.integer_at(1), row.integer_at(2) != 0});
  return out;
}

// The length of a blob stands in its row's head: no chunk is read for this.
class SessionSize {
 public:
  explicit SessionSize(sqlite3* handle)
      : row_(handle,
             "SELECT (SELECT coalesce(sum(length(directory) + length(body)), 0) FROM chunks WHERE session_id = ?1) + "
             "(SELECT coalesce(sum(length(body)), 0) FROM bus_chunks WHERE session_id = ?1) + "
             "(SELECT coalesce(sum(length(body)), 0) FROM journal_chunks WHERE session_id = ?1) + "
             "(SELECT coalesce(sum(length(body)), 0) FROM core_images WHERE session_id = ?1)") {}
  std::uint64_t operator()(SessionId session) {
    row_.reset();
    return row_.integer(1, session).step() ? row_.unsigned_at(0) : 0;
  }

 private:
  Statement row_;
};

std::uint64_t bytes_in_use(sqlite3* handle) {
  const std::int64_t pages = number_of(handle, "PRAGMA page_count") - number_of(handle, "PRAGMA freelist_count");
  return static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(number_of(handle, "PRAGMA page_size"));
}

RetentionRule stored_rule(sqlite3* handle) {
  Statement row(handle, "SELECT value FROM settings WHERE name = ?1");
  if (!row.text(1, kSetting).step()) return {};
  const json told = json::parse(row.text_at(0), nullptr, false);
  const RetentionRule rule = rule_of(told);
  if (!told.is_object() || !check_rule(rule))
    throw SqlFailure{Error{ErrorKind::corrupt, "the stored rule of retention cannot be read", {}}};
  return rule;
}

}  // namespace

json rule_json(const RetentionRule& rule) {
  const auto or_null = [](const std::optional<std::int64_t>& value) { return value ? json(*value) : json(nullptr); };
  return {{"days", or_null(rule.days)}, {"disk_percent", or_null(rule.disk_percent)}, {"needs_backup", rule.needs_backup}};
}

RetentionRule rule_of(const json& told) {
  const auto number = [&](const char* name) {
    const auto at = told.find(name);
    return at != told.end() && at->is_number_integer() ? std::optional(at->get<std::int64_t>()) : std::nullopt;
  };
  return {number("days"), number("disk_percent"), told.find("needs_backup") == told.end() || told["needs_backup"] != json(false)};
}

std::string tag_of(const RetentionRule& rule) { return edit_tag({rule_json(rule).dump()}); }

Result<RetentionRule> retention_rule(Database& database) {
  return guarded([&]() -> Result<RetentionRule> { return stored_rule(database.handle()); });
}

Status set_retention_rule(Database& database, const RetentionRule& rule, std::string_view tag) {
  if (Status checked = check_rule(rule); !checked) return checked;
  return guarded([&]() -> Status {
    sqlite3* handle = database.handle();
    Transaction transaction(handle, Transaction::Kind::write);
    if (!tag.empty())
      if (Status same = check_tag(tag, tag_of(stored_rule(handle))); !same) return same;
    const std::string text = rule_json(rule).dump();
    Statement(handle, "INSERT INTO settings (name, value) VALUES (?1, ?2) ON CONFLICT (name) DO UPDATE SET value = ?2")
        .text(1, kSetting)
        .text(2, std::string_view(text))
        .run();
    transaction.commit();
    return {};
  });
}

Result<std::optional<RetentionPlan>> plan_retention(Database& database, const RetentionRule& rule, std::int64_t utc_ns,
                                                    std::uint64_t disk_bytes, const CheckStep& step) {
  if (Status checked = check_rule(rule); !checked) return checked.error();
  return guarded([&]() -> Result<std::optional<RetentionPlan>> {
    sqlite3* handle = database.handle();
    RetentionPlan plan;
    plan.used_bytes = bytes_in_use(handle);
    if (!rule.on()) return std::optional(plan);
    const std::int64_t newest = number_of(handle, "SELECT max(started_utc_ns) FROM sessions");
    const std::int64_t now = std::min(utc_ns, newest + kClockBeyond_days * kDay_s * kSecond_ns);
    const std::int64_t old = now - rule.days.value_or(0) * kDay_s * kSecond_ns;
    const std::uint64_t used = plan.used_bytes, most = disk_bytes / 100 * static_cast<std::uint64_t>(rule.disk_percent.value_or(100));
    const std::uint64_t excess = rule.disk_percent && used > most ? used - most : 0;
    std::uint64_t passed_over = 0;  // of sessions that only want a backup
    SessionSize size_of(handle);
    const std::vector<Candidate> all = candidates(handle, utc_ns);
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!step(static_cast<double>(i) / static_cast<double>(all.size()))) return std::optional<RetentionPlan>{};
      const auto& [id, started, in_backup] = all[i];
      const bool too_old = rule.days && started < old && started >= kClockWasSet_utc_ns;
      // What would go if it were in a backup counts as gone here, so that it is named and no younger one goes in its place.
      const bool too_much = plan.bytes + passed_over < excess;
      if (!too_old && !too_much) continue;
      const std::uint64_t bytes = size_of(id);
      if (rule.needs_backup && !in_backup) {
        ++plan.without_backup;
        passed_over += bytes;
        continue;
      }
      plan.from_utc_ns = plan.sessions.empty() ? started : std::min(plan.from_utc_ns, started);
      plan.to_utc_ns = plan.sessions.empty() ? started : std::max(plan.to_utc_ns, started);
      plan.sessions.push_back(id);
      plan.bytes += bytes;
    }
    plan.excess_bytes = excess > plan.bytes ? excess - plan.bytes : 0;
    return std::optional(std::move(plan));
  });
}

Status note_backup(Database& database, std::int64_t utc_ns, const std::filesystem::path& folder, SessionId newest) {
  return guarded([&]() -> Status {
    const std::string name = folder.string();
    Statement row(database.handle(), "INSERT INTO backups (utc_ns, folder, newest_session) VALUES (?1, ?2, ?3)");
    row.integer(1, utc_ns).text(2, std::string_view(name)).integer(3, newest).run();
    return {};
  });
}

}  // namespace hoist::db
