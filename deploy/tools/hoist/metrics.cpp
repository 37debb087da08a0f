// hoist metrics: how well a session's exercise was walked.
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "db/summary/session_metrics.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

int run_metrics(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist metrics DB SESSION\n\nC and J_N of the session's exercise and a few plain figures, as one line of JSON; null = not "
        "defined.\n",
        stdout);
    return kDone;
  }
  const auto session = arguments.size() == 2 ? parse_session(arguments[1]) : std::nullopt;
  if (!session) return bad_usage("metrics", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("metrics", database.error());
  const db::Result<db::SessionMetrics> metrics = db::session_metrics(*database, *session);
  if (!metrics) return refuse("metrics", metrics.error());
  const auto optional = [](const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(nullptr); };
  const nlohmann::json line{{"session", metrics->session},
                            {"moving_samples", metrics->moving_samples},
                            {"moving_s", metrics->moving_s},
                            {"distance_m", metrics->distance_m},
                            {"mean_speed_m_s", metrics->mean_speed_m_s},
                            {"max_speed_m_s", metrics->max_speed_m_s},
                            {"track", metrics->track},
                            {"shape", metrics->shape},
                            {"C", optional(metrics->correlation)},
                            {"J", optional(metrics->normalised_ise)},
                            {"L", optional(metrics->path_length_m)},
                            {"why_absent", metrics->why_absent}};
  std::printf("%s\n", line.dump().c_str());
  return kDone;
}

}  // namespace hoist::tool
