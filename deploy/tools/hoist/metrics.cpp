// hoist metrics: how well a session's exercise was walked.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "db/summary/session_json.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

int run_metrics(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist metrics DB SESSION\n\nC and J_N of the session's exercise and a few plain figures, as one line of JSON: the "
        "answer of GET /api/v1/sessions/N/metrics. null = not defined. \"computed\" names for each figure the version of its "
        "definition and a hash of the recorded values it was computed from. The definitions: db/metrics/metrics.gen.md.\n",
        stdout);
    return kDone;
  }
  const auto session = arguments.size() == 2 ? parse_session(arguments[1]) : std::nullopt;
  if (!session) return bad_usage("metrics", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("metrics", database.error());
  const db::Result<nlohmann::json> metrics = db::session_metrics_json(*database, *session);
  if (!metrics) return refuse("metrics", metrics.error());
  std::printf("%s\n", metrics->dump().c_str());
  return kDone;
}

}  // namespace hoist::tool
