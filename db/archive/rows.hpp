// The rows of one session, from a hoist's file or from the archive, in the same order; and their digests.
#pragma once
#include <functional>
#include <string>

#include "db/archive/digest.hpp"
#include "db/archive/postgres.hpp"
#include "db/archive/tables.hpp"
#include "db/store/session_types.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {

/// kDescription and the visit: the row that `description` returns.
inline constexpr std::array kDescriptionRow{archive_columns::kDescription[0], archive_columns::kDescription[1],
                                            ArchiveColumn{"code", Kind::text}, ArchiveColumn{"day", Kind::text}};

using UseRow = std::function<void(const Row&)>;

/// Calls `use` for each row of a session's table, in the table's order.
class SessionRows {
 public:
  virtual ~SessionRows() = default;
  virtual void each(const ArchiveTable& table, const UseRow& use) = 0;
  /// The columns of kSession, and those of kDescriptionRow.
  virtual Row session() = 0;
  virtual Row description() = 0;
};

class LocalRows final : public SessionRows {
 public:
  LocalRows(sqlite3* handle, SessionId session) : handle_(handle), session_(session) {}
  void each(const ArchiveTable& table, const UseRow& use) override;
  Row session() override;
  Row description() override;

 private:
  Row one_row(std::span<const ArchiveColumn> columns, const std::string& sql);
  sqlite3* handle_;
  SessionId session_;
};

class ArchivedRows final : public SessionRows {
 public:
  ArchivedRows(Postgres& postgres, std::string session) : postgres_(&postgres), session_(std::move(session)) {}
  void each(const ArchiveTable& table, const UseRow& use) override;
  Row session() override;
  Row description() override;

 private:
  Row one_row(std::span<const ArchiveColumn> columns, const std::string& sql);
  Postgres* postgres_;
  std::string session_;  ///< its id in the archive, as text
};

/// Reads a session whole: each row goes to `use` (may be empty) and into the digest of what was recorded.
using UseTableRow = std::function<void(const ArchiveTable&, const Row&)>;
std::string content_digest(SessionRows& rows, const UseTableRow& use = {});
/// The digest of what people may change.
std::string description_digest(SessionRows& rows);

/// "a", "b", "c": quoted, since some are words of SQL.
std::string quoted_names(std::span<const ArchiveColumn> columns);

}  // namespace hoist::db
