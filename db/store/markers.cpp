#include "db/store/markers.hpp"

#include <optional>

#include "db/store/actor_rows.hpp"
#include "db/store/overwriting.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

constexpr const char* kRows =
    "SELECT number, tick, utc_ns, text, user, role, origin, client, utc_ns - started_utc_ns FROM markers "
    "JOIN sessions ON sessions.id = session_id LEFT JOIN actors ON actors.id = actor_id WHERE session_id = ?1 ";

MarkerInfo info_at(const Statement& row) {
  MarkerInfo info{.number = row.integer_at(0),
                  .marker = {row.unsigned_at(1), row.integer_at(2), row.text_at(3), actor_at(row, 4)},
                  .time_s = static_cast<double>(row.integer_at(8)) / 1e9,
                  .tag = {}};
  info.tag = edit_tag({info.marker.text});
  return info;
}

std::optional<MarkerInfo> marker_row(sqlite3* handle, SessionId session, std::int64_t number) {
  Statement row(handle, std::string(kRows) + "AND number = ?2");
  return row.integer(1, session).integer(2, number).step() ? std::optional(info_at(row)) : std::nullopt;
}

// The row that is to be changed; inside the transaction of its change.
Result<MarkerInfo> row_to_change(sqlite3* handle, SessionId session, std::int64_t number, const std::string& expected) {
  auto found = marker_row(handle, session, number);
  if (!found) return Error{ErrorKind::not_found, "session " + std::to_string(session) + " has no marker " + std::to_string(number), {}};
  if (const Status same = check_tag(expected, found->tag); !same) return same.error();
  return std::move(*found);
}

}  // namespace

Result<std::vector<MarkerInfo>> MarkerStore::list(SessionId session) const {
  return guarded([&]() -> Result<std::vector<MarkerInfo>> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    if (Statement known(handle, "SELECT 1 FROM sessions WHERE id = ?1"); !known.integer(1, session).step())
      return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
    std::vector<MarkerInfo> out;
    Statement rows(handle, std::string(kRows) + "ORDER BY number");
    rows.integer(1, session);
    while (rows.step()) out.push_back(info_at(rows));
    return out;
  });
}

Result<MarkerInfo> MarkerStore::change(SessionId session, std::int64_t number, const std::string& text, const std::string& expected) {
  if (Status checked = check_marker(text); !checked) return checked.error();
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return guarded([&]() -> Result<MarkerInfo> {
    Transaction transaction(handle, Transaction::Kind::write);
    auto row = row_to_change(handle, session, number, expected);
    if (!row) return row.error();
    Statement(handle, "UPDATE markers SET text = ?3 WHERE session_id = ?1 AND number = ?2")
        .integer(1, session)
        .integer(2, number)
        .text(3, std::string_view(text))
        .run();
    transaction.commit();
    row->marker.text = text;
    row->tag = edit_tag({text});
    return row;
  });
}

Status MarkerStore::remove(SessionId session, std::int64_t number, const std::string& expected) {
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    if (const auto row = row_to_change(handle, session, number, expected); !row) return row.error();
    Statement(handle, "DELETE FROM markers WHERE session_id = ?1 AND number = ?2").integer(1, session).integer(2, number).run();
    transaction.commit();
    return {};
  });
}

}  // namespace hoist::db
