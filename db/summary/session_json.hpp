// A session and its figures as programs read them: the names that REST uses, for the command line and the exported files.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "db/store/session_types.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::db {

/// The figures of db/metrics/metric_list.hpp by their keys, null = not valid; "computed" says of each which version of its definition it follows,
/// the inputs it was computed from, their hash (16 hexadecimal digits) and why it is not valid; "session", "track", "exercise";
/// "reason_if_none" and "reason_code" of C and J_N.
nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise);

/// The same of a stored session, read in pieces: what REST and `hoist metrics` answer. Errors: those of MetricsReading.
class FiguresReading {
 public:
  static Result<FiguresReading> open(Database& database, SessionId session);
  Result<bool> piece(Database& database) { return metrics_.piece(database); }
  nlohmann::json take();

 private:
  explicit FiguresReading(MetricsReading metrics) : metrics_(std::move(metrics)) {}
  MetricsReading metrics_;
};
/// In one piece.
Result<nlohmann::json> session_metrics_json(Database& database, SessionId session);
/// A session as the list of sessions and one session's page tell it.
nlohmann::json session_json(const SessionInfo& session);

}  // namespace hoist::db
