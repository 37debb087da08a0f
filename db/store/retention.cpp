#include "db/store/retention.hpp"

#include <string>

#include "db/store/sqlite.hpp"

namespace hoist::db {

Result<Retention> retention(Database& database) {
  return guarded([&]() -> Result<Retention> {
    Statement row(database.handle(), "SELECT months, needs_backup FROM retention");
    if (!row.step()) return Retention{};
    return Retention{row.is_null(0) ? std::nullopt : std::optional(row.integer_at(0)), row.integer_at(1) != 0};
  });
}

Status set_retention(Database& database, const Retention& wish) {
  if (wish.months && (*wish.months < 1 || *wish.months > kMostMonths))
    return Error{ErrorKind::bad_value, "months must be 1 to " + std::to_string(kMostMonths), "months"};
  return guarded([&]() -> Status {
    Statement row(database.handle(), "UPDATE retention SET months = ?1, needs_backup = ?2");
    if (wish.months)
      row.integer(1, *wish.months);
    else
      row.null(1);
    row.integer(2, wish.needs_backup ? 1 : 0).run();
    return {};
  });
}

Result<Expired> expired_sessions(Database& database, std::int64_t utc_ns) {
  return guarded([&]() -> Result<Expired> {
    Expired out;
    Statement row(database.handle(),
                  "SELECT sessions.id, NOT needs_backup OR sessions.id <= (SELECT coalesce(max(newest_session), 0) FROM backups) "
                  "FROM sessions, retention WHERE months IS NOT NULL AND ended_utc_ns IS NOT NULL AND started_utc_ns > ?3 AND "
                  "started_utc_ns < 1000000000 * "
                  "CAST(strftime('%s', min(?1, (SELECT max(started_utc_ns) FROM sessions) / 1000000000 + 86400 * ?2), 'unixepoch', "
                  "'-' || months || ' months') AS INTEGER) ORDER BY sessions.id");
    row.integer(1, utc_ns / 1'000'000'000).integer(2, kClockBeyond_days).integer(3, kClockWasSet_utc_ns);
    while (row.step()) {
      if (row.integer_at(1) != 0)
        out.sessions.push_back(row.integer_at(0));
      else
        ++out.without_backup;
    }
    return out;
  });
}

Status note_backup(Database& database, const BackupInfo& backup) {
  return guarded([&]() -> Status {
    const std::string folder = backup.folder.string();
    Statement row(database.handle(), "INSERT INTO backups (utc_ns, folder, newest_session) VALUES (?1, ?2, ?3)");
    row.integer(1, backup.utc_ns).text(2, std::string_view(folder)).integer(3, backup.newest_session).run();
    return {};
  });
}

}  // namespace hoist::db
