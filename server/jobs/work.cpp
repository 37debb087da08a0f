#include "server/jobs/work.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"
#include "server/jobs/jobs.hpp"

namespace hoist::server::job {

using nlohmann::json;

JobResult integrity_check(db::Database& database, const JobArguments&, const JobStep& step) {
  auto checked = db::check_integrity(database, step);
  if (!checked) return checked.error();
  if (!*checked) return std::optional<JobYield>{};
  db::IntegrityReport& report = **checked;
  const json told{{"kind", "integrity_check"},
                  {"sound", report.sound()},
                  {"structure", report.structure},
                  {"blobs", report.blobs},
                  {"damaged_blobs", report.damaged_blobs},
                  {"damaged_sessions", report.damaged_sessions}};
  return std::optional(JobYield{.result = told.dump(-1, ' ', false, json::error_handler_t::replace), .check = std::move(report)});
}

namespace {
db::Result<std::vector<db::SessionId>> newest_sessions(db::Database& database) {
  std::vector<db::SessionId> ids;
  db::SessionQuery query{.limit = db::kMaxPage, .before = {}, .subject = {}};
  do {
    const auto page = db::SessionReader(database).list(query);
    if (!page) return page.error();
    for (const db::SessionInfo& session : page->sessions) ids.push_back(session.id);
    query.before = page->next;
  } while (query.before && ids.size() < kJobSessions);
  ids.resize(std::min(ids.size(), kJobSessions));
  return ids;
}
}  // namespace

JobResult recompute_metrics(db::Database& database, const JobArguments& arguments, const JobStep& step) {
  std::vector<db::SessionId> ids = arguments.sessions;
  if (ids.empty()) {
    auto newest = newest_sessions(database);
    if (!newest) return newest.error();
    ids = std::move(*newest);
  }
  json items = json::array(), failed = json::array();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!step(static_cast<double>(i) / static_cast<double>(ids.size()))) return std::optional<JobYield>{};
    // A session that is gone or damaged is one of its own: the others are computed.
    if (auto figures = db::session_metrics_json(database, ids[i]); figures)
      items.push_back(std::move(*figures));
    else
      failed.push_back({{"session", ids[i]}, {"detail", figures.error().message}});
  }
  const json told{{"kind", "recompute_metrics"}, {"items", std::move(items)}, {"failed", std::move(failed)}};
  return std::optional(JobYield{.result = told.dump(-1, ' ', false, json::error_handler_t::replace), .check = {}});
}

}  // namespace hoist::server::job
