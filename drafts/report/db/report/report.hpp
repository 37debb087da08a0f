// Reports for print: one page for a patient, everything for a clinician, and a group. Self-contained HTML; a browser makes paper or PDF of it.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "db/report/words.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/summary/trend.hpp"

namespace hoist::db {

/// patient: one page, the main figures in plain words. full: every figure with definition and gate, settings, origin.
enum class ReportKind : std::uint8_t { patient, full };
[[nodiscard]] std::optional<ReportKind> find_report_kind(std::string_view name);

struct ReportOptions {
  ReportKind kind = ReportKind::full;
  Language language = Language::en;
  std::string program;  ///< that makes it: version and commit
};

/// Sessions that a patient's report looks at, the newest ones.
inline constexpr std::size_t kReportSessions = 50;

/// One session. Errors: not_found, corrupt, io.
[[nodiscard]] Result<std::string> session_report(Database& database, SessionId session, const ReportOptions& options);
/// A patient's progress, from a trend that was read before (trend_sessions, trend_entry). Errors: not_found, io.
[[nodiscard]] Result<std::string> patient_report(Database& database, std::int64_t patient, const TrendPage& page,
                                                 std::span<const TrendEntry> entries, const ReportOptions& options);
/// The same with its trend read here.
[[nodiscard]] Result<std::string> patient_report(Database& database, std::int64_t patient, const ReportOptions& options);

/// One row of a group report.
struct GroupRow {
  SessionInfo session;
  std::optional<SessionMetrics> metrics;  ///< none: the recording is damaged
};
/// Errors: not_found, io.
[[nodiscard]] Result<GroupRow> group_row(Database& database, SessionId session);
[[nodiscard]] std::string group_report(std::span<const GroupRow> rows, const ReportOptions& options);

}  // namespace hoist::db
