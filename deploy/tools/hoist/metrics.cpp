// hoist metrics: the figures of recorded sessions, and whether figures told earlier are still those of their recording.
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "db/metrics/metric_list.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

using nlohmann::json;

constexpr const char* kMetricsHelp =
    "usage: hoist metrics DB SESSION|all\n"
    "       hoist metrics --list\n"
    "       hoist metrics recompute DB FILE [FILE...]\n\n"
    "The figures of a session, as one line of JSON: the answer of GET /api/v1/sessions/N/metrics; `all`: a line for each session, the "
    "oldest\n"
    "first. null = not valid; \"computed\" says of each figure why, and names the version of its definition and a hash of the recorded "
    "values it\n"
    "was computed from. The definitions: --list, db/metrics/metrics.gen.md.\n\n"
    "recompute: computes figures that were told earlier again. FILE holds lines of `hoist metrics`, answers of REST, JSON exports, or "
    "results of\n"
    "the job recompute_metrics. Exit code 0: all are the same; 1: with the same version and the same recorded values a figure is another "
    "one,\n"
    "or a session is not there; 3: none differs, but some are of another version, or of values that have changed since.\n";

// What was told of sessions: each object with "computed", wherever it stands.
void collect(const json& told, std::vector<json>& out) {
  if (told.is_object() && told.contains("computed") && told.contains("session")) return out.push_back(told);
  if (!told.is_structured()) return;
  // Samples of an export are numbers only.
  for (const char* const name : {"metrics", "items", "result"})
    if (told.is_object() && told.contains(name)) collect(told[name], out);
  if (told.is_array())
    for (const json& one : told) collect(one, out);
}

// A file is one JSON text, or one to a line.
bool read_told(const std::string& path, std::vector<json>& out) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (!file) return false;
  const std::size_t before = out.size();
  if (const json whole = json::parse(text.str(), nullptr, false); !whole.is_discarded()) {
    collect(whole, out);
  } else {
    for (std::string line; std::getline(text, line);) {
      const json one = json::parse(line, nullptr, false);
      if (one.is_discarded()) return false;
      collect(one, out);
    }
  }
  return out.size() > before;
}

struct Counts {
  std::size_t sessions = 0, same = 0, different = 0, other_version = 0, other_data = 0;
};

void compare(const json& told, const json& now, Counts& counts) {
  for (const auto& [key, was] : told["computed"].items()) {
    const auto is = now["computed"].find(key);
    if (is == now["computed"].end() || (*is)["version"] != was["version"]) {
      ++counts.other_version;
    } else if ((*is)["hash"] != was["hash"]) {
      ++counts.other_data;
    } else if (now[key] == told[key]) {
      ++counts.same;
    } else {
      ++counts.different;
      std::printf("session %lld: %s was %s and is %s\n", told["session"].get<long long>(), key.c_str(), told[key].dump().c_str(),
                  now[key].dump().c_str());
    }
  }
}

int recompute(db::Database& database, std::span<const std::string_view> files) {
  std::vector<json> all;
  for (const std::string_view file : files)
    if (!read_told(std::string(file), all)) return bad_usage("metrics", std::string(file) + " holds no figures of sessions");
  Counts counts;
  bool missing = false;
  for (const json& told : all) {
    const auto session = told["session"].is_number_integer() ? told["session"].get<db::SessionId>() : 0;
    const db::Result<json> now = db::session_metrics_json(database, session);
    if (!now) {
      std::printf("session %lld: %s\n", static_cast<long long>(session), now.error().message.c_str());
      missing = true;
      continue;
    }
    ++counts.sessions;
    compare(told, *now, counts);
  }
  std::printf("%zu sessions: %zu figures are the same, %zu differ, %zu are of another version, %zu of values that have changed\n",
              counts.sessions, counts.same, counts.different, counts.other_version, counts.other_data);
  if (missing || counts.different > 0) return kRefused;
  return counts.other_version + counts.other_data > 0 ? kPartly : kDone;
}

int print_all(db::Database& database) {
  std::vector<db::SessionId> ids;
  db::SessionQuery query{.limit = db::kMaxPage, .before = {}, .subject = {}};
  do {
    const db::Result<db::SessionPage> page = db::SessionReader(database).list(query);
    if (!page) return refuse("metrics", page.error());
    for (const db::SessionInfo& session : page->sessions) ids.push_back(session.id);
    query.before = page->next;
  } while (query.before);
  for (auto id = ids.rbegin(); id != ids.rend(); ++id) {
    const db::Result<json> metrics = db::session_metrics_json(database, *id);
    if (!metrics) return refuse("metrics", metrics.error());
    std::printf("%s\n", metrics->dump().c_str());
  }
  return kDone;
}

int print_list() {
  for (const db::MetricInfo& metric : db::kMetrics)
    std::printf("%s, version %u, %s\n  %s\n  = %s\n  valid with: %s\n", std::string(metric.key).c_str(), metric.version,
                std::string(metric.unit).c_str(), std::string(metric.doc).c_str(), std::string(metric.formula).c_str(),
                metric.gate.empty() ? "every session" : std::string(metric.gate).c_str());
  return kDone;
}

}  // namespace

int run_metrics(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kMetricsHelp, stdout);
    return kDone;
  }
  if (arguments.size() == 1 && arguments[0] == "--list") return print_list();
  const bool again = arguments.size() >= 3 && arguments[0] == "recompute";
  const bool all = arguments.size() == 2 && arguments[1] == "all";
  const auto session = arguments.size() == 2 && !all ? parse_session(arguments[1]) : std::nullopt;
  if (!again && !all && !session) return bad_usage("metrics", "name a database and a session's number, or all");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[again ? 1 : 0]));
  if (!database) return refuse("metrics", database.error());
  if (again) return recompute(*database, arguments.subspan(2));
  if (all) return print_all(*database);
  const db::Result<json> metrics = db::session_metrics_json(*database, *session);
  if (!metrics) return refuse("metrics", metrics.error());
  std::printf("%s\n", metrics->dump().c_str());
  return kDone;
}

}  // namespace hoist::tool
