#include "db/report/batch.hpp"

namespace hoist::db {

Result<std::string> ReportBatch::page(SessionId session) {
  auto of = read_report_session(database_, session);
  if (!of) return of.error();
  const auto sessions = report_trend(database_, of->session);
  if (!sessions) return sessions.error();
  std::vector<TrendEntry> trend;
  for (const TrendSession& one : *sessions) {
    const auto entry = entry_of(one);
    if (!entry) return entry.error();
    if (*entry) trend.push_back(**entry);
  }
  auto page = session_report(database_, *of, trend, options_);
  if (page) group_.push_back(std::move(*of));
  return page;
}

Result<std::optional<TrendEntry>> ReportBatch::entry_of(const TrendSession& session) {
  if (const auto at = known_.find(session.session); at != known_.end()) {
    std::optional<TrendEntry> entry = at->second;
    if (entry) entry->session = session;  // its place counts from the newest walk of this page
    return entry;
  }
  auto entry = trend_entry(database_, session);
  if (entry) known_.emplace(session.session, *entry);
  return entry;
}

}  // namespace hoist::db
