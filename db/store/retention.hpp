// How long sessions are kept, and which are older.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "db/store/backup.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

inline constexpr std::int64_t kMostMonths = 240;
/// The clock is believed this far beyond the newest session: one that was set wrong must not make all sessions old.
inline constexpr int kClockBeyond_days = 31;
/// A session of before 2020 was recorded with a clock that was not set: its age is not known, so it is kept.
inline constexpr std::int64_t kClockWasSet_utc_ns = 1'577'836'800'000'000'000;

struct Retention {
  std::optional<std::int64_t> months = {};  ///< absent = sessions are kept for ever
  bool needs_backup = true;                 ///< only sessions that are in a checked backup are deleted
  bool operator==(const Retention&) const = default;
};
Result<Retention> retention(Database& database);
/// Error bad_value (months).
Status set_retention(Database& database, const Retention& wish);

struct Expired {
  std::vector<SessionId> sessions;   ///< to be deleted, oldest first
  std::uint64_t without_backup = 0;  ///< old enough, and kept because no backup holds them
};
/// Ended sessions that are older than the setting allows. None while it is off.
Result<Expired> expired_sessions(Database& database, std::int64_t utc_ns);

/// A checked backup holds the sessions that had ended by then.
Status note_backup(Database& database, const BackupInfo& backup);

}  // namespace hoist::db
