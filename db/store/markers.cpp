#include "db/store/markers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

#include "control/contract/step_line.hpp"
#include "db/store/actor_rows.hpp"
#include "db/store/overwriting.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/session_times.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

std::string markers_sql(std::string_view more) {
  return "SELECT m.number, m.tick, m.utc_ns, m.text, user, role, origin, client, " + time_of_step_sql("m.tick") +
         " - s.start_time_ns, ifnull(m.kind, 'note') FROM markers AS m JOIN sessions AS s ON s.id = m.session_id "
         "LEFT JOIN actors ON actors.id = m.actor_id WHERE m.session_id = ?1 " +
         std::string(more);
}

MarkerInfo info_at(const Statement& row) {
  MarkerInfo info{.number = row.integer_at(0),
                  .marker = {row.unsigned_at(1), row.integer_at(2), row.text_at(3), actor_at(row, 4), row.text_at(9)},
                  .time_s = static_cast<double>(row.integer_at(8)) / 1e9,
                  .tag = {}};
  info.tag = edit_tag({info.marker.text, info.marker.kind, std::to_string(info.marker.utc_ns)});
  return info;
}

std::optional<MarkerInfo> marker_row(sqlite3* handle, SessionId session, std::int64_t number) {
  Statement row(handle, markers_sql("AND m.number = ?2"));
  return row.integer(1, session).integer(2, number).step() ? std::optional(info_at(row)) : std::nullopt;
}

struct Moment {
  std::uint64_t tick = 0;
  std::int64_t utc_ns = 0;
};

// A moment within the session's samples. Ticks follow each other at the step's period, also over a gap.
Result<Moment> moment_at(sqlite3* handle, SessionId session, double time_s) {
  Statement row(handle,
                "SELECT start_time_ns, (SELECT max(last_time_ns) FROM chunks WHERE session_id = sessions.id) FROM sessions WHERE id = ?1");
  row.integer(1, session).step();
  const double end_s = row.is_null(1) ? 0 : static_cast<double>(row.integer_at(1) - row.integer_at(0)) / 1e9;
  if (!(time_s >= 0 && time_s <= end_s)) {
    std::array<char, 32> most{};
    std::snprintf(most.data(), most.size(), "%.2f", std::floor(end_s * 100) / 100);
    return Error{ErrorKind::bad_value, std::string("time_s must be 0 to ") + most.data() + ", within the session", "time_s"};
  }
  const std::int64_t time_ns = row.integer_at(0) + std::llround(time_s * 1e9);
  Statement near(
      handle,
      "SELECT first_tick, first_time_ns FROM chunks WHERE session_id = ?1 ORDER BY first_time_ns > ?2, abs(first_time_ns - ?2) LIMIT 1");
  near.integer(1, session).integer(2, time_ns).step();
  constexpr auto kPeriod_ns = static_cast<double>(contract::kStepPeriod_ns);
  const std::int64_t steps = std::llround(static_cast<double>(time_ns - near.integer_at(1)) / kPeriod_ns);
  Statement utc(handle, "SELECT " + utc_of_time_sql("?2") + " FROM sessions AS s WHERE s.id = ?1");
  utc.integer(1, session).integer(2, time_ns).step();
  return Moment{static_cast<std::uint64_t>(std::max<std::int64_t>(0, near.integer_at(0) + steps)), utc.integer_at(0)};
}

// The row that is to be changed; inside the transaction of its change.
Result<MarkerInfo> row_to_change(sqlite3* handle, SessionId session, std::int64_t number, const std::string& expected) {
  auto found = marker_row(handle, session, number);
  if (!found) return Error{ErrorKind::not_found, "session " + std::to_string(session) + " has no marker " + std::to_string(number), {}};
  if (const Status same = check_tag(expected, found->tag); !same) return same.error();
  return std::move(*found);
}

}  // namespace

Result<std::vector<MarkerInfo>> MarkerStore::list(SessionId session, std::int64_t after, std::size_t limit) const {
  return guarded([&]() -> Result<std::vector<MarkerInfo>> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    if (Statement known(handle, "SELECT 1 FROM sessions WHERE id = ?1"); !known.integer(1, session).step())
      return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
    std::vector<MarkerInfo> out;
    Statement rows(handle, markers_sql("AND m.number > ?2 ORDER BY m.number LIMIT ?3"));
    rows.integer(1, session).integer(2, after).unsigned_integer(3, limit);
    while (rows.step()) out.push_back(info_at(rows));
    return out;
  });
}

Status MarkerStore::add(SessionId session, const Marker& marker) {
  if (Status checked = check_marker(marker.text); !checked) return checked;
  if (Status checked = check_marker_kind(marker.kind); !checked) return checked;
  sqlite3* handle = database_->handle();
  return guarded([&]() -> Status {
    Transaction transaction(handle, Transaction::Kind::write);
    Statement known(handle, "SELECT ended_utc_ns FROM sessions WHERE id = ?1");
    if (!known.integer(1, session).step()) return Error{ErrorKind::not_found, "there is no session " + std::to_string(session), {}};
    if (known.is_null(0)) return Error{ErrorKind::wrong_state, "session " + std::to_string(session) + " is still being recorded", {}};
    Statement row(
        handle,
        "INSERT INTO markers (session_id, number, tick, utc_ns, text, actor_id, kind) VALUES (?1, (SELECT ifnull(max(number), -1) + 1 "
        "FROM markers WHERE session_id = ?1), ?2, ?3, ?4, ?5, nullif(?6, 'note'))");
    row.integer(1, session).unsigned_integer(2, marker.tick).integer(3, marker.utc_ns).text(4, std::string_view(marker.text));
    bind_actor(row, 5, handle, marker.actor);
    row.text(6, std::string_view(marker.kind)).run();
    transaction.commit();
    return {};
  });
}

Result<MarkerInfo> MarkerStore::change(SessionId session, std::int64_t number, const MarkerPatch& patch, const std::string& expected) {
  if (patch.text)
    if (Status checked = check_marker(*patch.text); !checked) return checked.error();
  if (patch.kind)
    if (Status checked = check_marker_kind(*patch.kind); !checked) return checked.error();
  sqlite3* handle = database_->handle();
  const Overwriting overwriting(handle);
  return guarded([&]() -> Result<MarkerInfo> {
    Transaction transaction(handle, Transaction::Kind::write);
    const auto before = row_to_change(handle, session, number, expected);
    if (!before) return before.error();
    Moment moment{before->marker.tick, before->marker.utc_ns};
    if (patch.time_s) {
      const auto moved = moment_at(handle, session, *patch.time_s);
      if (!moved) return moved.error();
      moment = *moved;
    }
    Statement(handle,
              "UPDATE markers SET text = ?3, kind = nullif(?4, 'note'), tick = ?5, utc_ns = ?6 WHERE session_id = ?1 AND number = ?2")
        .integer(1, session)
        .integer(2, number)
        .text(3, std::string_view(patch.text.value_or(before->marker.text)))
        .text(4, std::string_view(patch.kind.value_or(before->marker.kind)))
        .unsigned_integer(5, moment.tick)
        .integer(6, moment.utc_ns)
        .run();
    MarkerInfo after = marker_row(handle, session, number).value();
    transaction.commit();
    return after;
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
