// Reports of many sessions and the table of all of them: the pages of `hoist report` and of the layout `reports` of a bundle.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "db/report/report.hpp"

namespace hoist::db {

class ReportBatch {
 public:
  ReportBatch(Database& database, ReportOptions options) : database_(database), options_(std::move(options)) {}
  /// The page of a session, which is in the group from here on. Errors: not_found, wrong_state (still being recorded), corrupt, busy, io.
  [[nodiscard]] Result<std::string> page(SessionId session);
  /// The table of all sessions that have a page.
  [[nodiscard]] std::string group() const { return group_report(group_, options_); }
  [[nodiscard]] std::size_t size() const { return group_.size(); }

 private:
  Result<std::optional<TrendEntry>> entry_of(const TrendSession& session);

  Database& database_;
  ReportOptions options_;
  // Many reports look at the same earlier sessions: each is evaluated once.
  std::map<SessionId, std::optional<TrendEntry>> known_;
  std::vector<ReportSession> group_;
};

/// One page, with its session and trend read here. Errors as of ReportBatch::page.
[[nodiscard]] inline Result<std::string> session_report(Database& database, SessionId session, const ReportOptions& options) {
  return ReportBatch(database, options).page(session);
}

}  // namespace hoist::db
