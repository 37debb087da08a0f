#include "db/store/audit.hpp"

#include <limits>

#include "db/store/actor_rows.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {

Status AuditLog::append(std::span<const AuditEntry> entries) {
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    Statement row(handle, "INSERT INTO audit (utc_ns, actor_id, action, result, session_id, detail) VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
    for (const AuditEntry& entry : entries) {
      bind_actor(row, 2, handle, entry.actor);
      if (entry.session)
        row.integer(5, *entry.session);
      else
        row.null(5);
      row.integer(1, entry.utc_ns)
          .text(3, std::string_view(entry.action))
          .text(4, std::string_view(entry.result))
          .text(6, std::string_view(entry.detail))
          .run();
    }
    transaction.commit();
    return {};
  });
}

Result<AuditPage> AuditLog::list(const AuditQuery& query) const {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<AuditPage> {
    Statement rows(database_->handle(),
                   "SELECT audit.id, utc_ns, action, result, session_id, detail, user, role, origin, client FROM audit "
                   "LEFT JOIN actors ON actors.id = actor_id WHERE audit.id < ?1 ORDER BY audit.id DESC LIMIT ?2");
    // One more than asked tells whether a next page exists.
    rows.integer(1, query.before.value_or(std::numeric_limits<std::int64_t>::max())).unsigned_integer(2, query.limit + 1);
    AuditPage page;
    while (rows.step()) {
      if (page.items.size() == query.limit) {
        page.next = page.items.back().id;
        break;
      }
      AuditEntry entry{.utc_ns = rows.integer_at(1), .actor = actor_at(rows, 6), .action = rows.text_at(2), .result = rows.text_at(3)};
      if (!rows.is_null(4)) entry.session = rows.integer_at(4);
      entry.detail = rows.text_at(5);
      page.items.push_back({rows.integer_at(0), std::move(entry)});
    }
    return page;
  });
}

}  // namespace hoist::db
