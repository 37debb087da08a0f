#include "server/api/trend_reading.hpp"

#include <memory>
#include <utility>

#include "server/api/lists.hpp"

namespace hoist::server::api {

db::Result<db::Database*> database_for_piece(Records& records) {
  if (records.late()) return db::Error{db::ErrorKind::busy, "The recorder is busy. Try again in a moment.", {}};
  if (db::Database* database = records.database()) return database;
  return db::Error{db::ErrorKind::io, records.why(), {}};
}

namespace {
struct Work {
  std::vector<db::TrendSession> sessions;
  std::function<void(std::vector<db::TrendEntry>)> done;
  std::size_t next = 0;
  std::vector<db::TrendEntry> entries = {};
};
using Entry = db::Result<std::optional<db::TrendEntry>>;

void go_on(const CallPtr& call, const std::shared_ptr<Work>& work) {
  if (work->next == work->sessions.size()) return work->done(std::move(work->entries));
  const auto read = [session = work->sessions[work->next++]](Records& records) -> Entry {
    const auto database = database_for_piece(records);
    return database ? db::trend_entry(**database, session) : Entry(database.error());
  };
  ask_recorder<Entry>(call, read, [call, work](Entry entry) {
    if (!entry) return call->respond(store_error(entry.error(), call->request.path));
    if (*entry) work->entries.push_back(std::move(**entry));
    go_on(call, work);
  });
}
}  // namespace

void read_trend(const CallPtr& call, std::vector<db::TrendSession> sessions, std::function<void(std::vector<db::TrendEntry>)> done) {
  go_on(call, std::make_shared<Work>(Work{.sessions = std::move(sessions), .done = std::move(done)}));
}

}  // namespace hoist::server::api
