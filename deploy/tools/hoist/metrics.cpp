// hoist metrics: how well a session's exercise was walked.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"
#include "db/summary/session_metrics.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

int run_metrics(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist metrics DB SESSION\n\nC and J_N of the session's exercise and a few plain figures, as one line of JSON with the "
        "names of "
        "GET /api/v1/sessions/N/metrics; null = not defined. duration_s counts motion only.\n",
        stdout);
    return kDone;
  }
  const auto session = arguments.size() == 2 ? parse_session(arguments[1]) : std::nullopt;
  if (!session) return bad_usage("metrics", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("metrics", database.error());
  const db::Result<db::SessionMetrics> metrics = db::session_metrics(*database, *session);
  if (!metrics) return refuse("metrics", metrics.error());
  const db::Result<db::SessionInfo> info = db::SessionReader(*database).get(*session);
  if (!info) return refuse("metrics", info.error());
  std::printf("%s\n", db::metrics_json(*metrics, info->exercise_json).dump().c_str());
  return kDone;
}

}  // namespace hoist::tool
