#include "server/api/trend_reading.hpp"

#include <memory>
#include <utility>

#include "server/api/lists.hpp"
#include "server/api/pieces.hpp"

namespace hoist::server::api {

namespace {
struct Work {
  std::vector<db::TrendSession> sessions;
  std::function<void(std::vector<db::TrendEntry>)> done;
  std::size_t next = 0;
  std::vector<db::TrendEntry> entries = {};
};
void go_on(const CallPtr& call, const std::shared_ptr<Work>& work) {
  if (work->next == work->sessions.size()) return work->done(std::move(work->entries));
  const db::TrendSession& session = work->sessions[work->next++];
  read_in_pieces<db::MetricsReading>(call, session.session, [call, work, session](db::Result<db::SessionMetrics> metrics) {
    auto entry = db::trend_entry(session, std::move(metrics));
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
