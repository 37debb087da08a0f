// Reports for print: one page for a patient, everything for a clinician, and several sessions as a group. Self-contained HTML without scripts; a
// browser makes paper or PDF of it. Pseudonymous: patient codes, never names.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/report/options.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/summary/trend.hpp"

namespace hoist::db {

/// What a page may load: nothing, but its own style. A header Content-Security-Policy.
inline constexpr std::string_view kReportPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A session and its figures.
struct ReportSession {
  SessionInfo session;
  SessionMetrics metrics;
};
/// Errors: not_found, not_now (still being recorded), corrupt, io.
[[nodiscard]] Result<ReportSession> read_report_session(Database& database, SessionId session);
/// The same in pieces.
class ReportReading {
 public:
  static Result<ReportReading> open(Database& database, SessionId session);
  Result<bool> piece(Database& database) { return metrics_.piece(database); }
  ReportSession take() { return {metrics_.info(), metrics_.take()}; }

 private:
  explicit ReportReading(MetricsReading metrics) : metrics_(std::move(metrics)) {}
  MetricsReading metrics_;
};

/// The sessions that the progress of a report is made of: of the same patient's comparable ones this one, the newest before it, and the first. None
/// of a simulated session and of one without a patient. Errors: busy, io.
[[nodiscard]] Result<std::vector<TrendSession>> report_trend(Database& database, const SessionInfo& session);

/// `trend`: the figures of report_trend, newest first (trend_entry). Errors: not_found, corrupt, io.
[[nodiscard]] Result<std::string> session_report(Database& database, const ReportSession& of, std::span<const TrendEntry> trend,
                                                 const ReportOptions& options);

/// The main figures of several sessions with mean and standard deviation over the valid ones. The kind of the options is not used.
[[nodiscard]] std::string group_report(std::span<const ReportSession> sessions, const ReportOptions& options);

}  // namespace hoist::db
