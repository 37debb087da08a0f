#include "db/summary/session_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "db/metrics/metric_list.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {

namespace {
nlohmann::json or_null(double value) { return value; }
nlohmann::json or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

// A recorded column stands for its twin of the repaired track; what the session does not have is left out.
std::string recorded_name(const InputHashes& recorded, const std::string& input) {
  if (const std::string fused = "fused_" + input; recorded.contains(fused)) return fused;
  return recorded.contains(input) ? input : "";
}

// Which definition a figure follows and what it was computed from.
nlohmann::json computed_from(const MetricInfo& metric, const InputHashes& recorded) {
  nlohmann::json inputs = nlohmann::json::array();
  std::uint64_t hash = contract::kHashStart;
  std::istringstream names{std::string(metric.inputs)};
  for (std::string name; names >> name;) {
    const std::string input = recorded_name(recorded, name);
    if (input.empty()) continue;
    inputs.push_back(input);
    hash = contract::hash_number(contract::hash_bytes(hash, input), recorded.find(input)->second);
  }
  return {{"version", metric.version}, {"inputs", std::move(inputs)}, {"hash", layout_text(hash)}};
}
}  // namespace

nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise) {
  using nlohmann::json;
  const NoFigure why = metrics.why_absent;
  json told{{"session", metrics.session},
            {"track", metrics.track},
            {"exercise", exercise_as_told(exercise)},
            {"reason_if_none", why == NoFigure::none ? json(nullptr) : json(no_figure_sentence(why))},
            {"reason_code", why == NoFigure::none ? json(nullptr) : json(no_figure_name(why))}};
#define HOIST_METRIC(key, version, unit, member, defined, inputs, source, doc) told[#key] = or_null(metrics.member);
#include "db/metrics/metrics.def"
#undef HOIST_METRIC
  for (const MetricInfo& metric : kMetrics) told["computed"][std::string(metric.key)] = computed_from(metric, metrics.inputs);
  return told;
}

Result<nlohmann::json> session_metrics_json(Database& database, SessionId session) {
  const auto info = SessionReader(database).get(session);
  if (!info) return info.error();
  const auto metrics = session_metrics(database, session);
  if (!metrics) return metrics.error();
  return metrics_json(*metrics, info->exercise_json);
}

nlohmann::json session_json(const SessionInfo& session) {
  using nlohmann::json;
  const auto or_null = [](const auto& value) { return value ? json(*value) : json(nullptr); };
  return {{"id", session.id},
          {"started_utc_ms", session.started_utc_ns / 1'000'000},
          {"ended_utc_ms", session.ended_utc_ns ? json(*session.ended_utc_ns / 1'000'000) : json(nullptr)},
          {"duration_s", session.duration_s},
          {"samples", session.sample_count},
          {"gaps", session.gap_count},
          {"recording", session.recording},
          {"close_reason", session.close_reason},
          {"simulated", session.simulated},
          {"subject", or_null(session.subject)},
          {"note", session.note},
          {"exercise", exercise_as_told(session.exercise_json)},
          {"software_version", session.software_version},
          {"core_version", or_null(session.core_version)},
          {"layout_hash", layout_text(session.layout_hash)},
          {"stored_bytes", session.stored_bytes}};
}

}  // namespace hoist::db
