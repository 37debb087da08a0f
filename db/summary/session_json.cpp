#include "db/summary/session_json.hpp"

#include <nlohmann/json.hpp>
#include <sstream>

#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/tasks.hpp"
#include "db/summary/provenance.hpp"

namespace hoist::db {

namespace {
// A recorded column stands for its twin of the repaired track; what the session does not have is left out.
std::string recorded_name(const InputHashes& recorded, const std::string& input) {
  if (const std::string fused = "fused_" + input; recorded.contains(fused)) return fused;
  return recorded.contains(input) ? input : "";
}

nlohmann::json code_or_null(NoFigure why) { return why == NoFigure::none ? nlohmann::json(nullptr) : nlohmann::json(no_figure_name(why)); }

// Which definition a figure follows, what it was computed from, and why it has no number.
nlohmann::json computed_from(const MetricInfo& metric, NoFigure why, const InputHashes& recorded) {
  nlohmann::json inputs = nlohmann::json::array();
  std::uint64_t hash = contract::kHashStart;
  std::istringstream names{std::string(metric.inputs)};
  for (std::string name; names >> name;) {
    const std::string input = recorded_name(recorded, name);
    if (input.empty()) continue;
    inputs.push_back(input);
    hash = contract::hash_number(contract::hash_bytes(hash, input), recorded.find(input)->second);
  }
  return {{"version", metric.version}, {"inputs", std::move(inputs)}, {"hash", layout_text(hash)}, {"reason_code", code_or_null(why)}};
}
}  // namespace

nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise) {
  using nlohmann::json;
  const NoFigure why = metrics.why_absent;
  json told{{"session", metrics.session},
            {"track", metrics.track},
            {"exercise", exercise_as_told(exercise)},
            {"reason_if_none", why == NoFigure::none ? json(nullptr) : json(no_figure_sentence(why))},
            {"reason_code", code_or_null(why)}};
  for (std::size_t i = 0; i < kMetrics.size(); ++i) {
    const std::string key(kMetrics[i].key);
    const Figure& one = metrics.figures[i];
    told[key] = one.value ? json(*one.value) : json(nullptr);
    told["computed"][key] = computed_from(kMetrics[i], one.why, metrics.inputs);
  }
  return told;
}

Result<FiguresReading> FiguresReading::open(Database& database, SessionId session) {
  auto metrics = MetricsReading::open(database, session);
  if (!metrics) return metrics.error();
  return FiguresReading(std::move(*metrics));
}
nlohmann::json FiguresReading::take() { return metrics_json(metrics_.take(), metrics_.info().exercise_json); }

Result<nlohmann::json> session_metrics_json(Database& database, SessionId session) {
  auto reading = FiguresReading::open(database, session);
  if (!reading) return reading.error();
  return read_whole(database, *reading);
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
          {"standby", session.standby},
          {"subject", or_null(session.subject)},
          {"study", session.study ? json{{"study", session.study->study}, {"subject", session.study->subject}, {"run", session.study->run}}
                                  : json(nullptr)},
          {"note", session.note},
          {"exercise", exercise_as_told(session.exercise_json)},
          {"task", task_as_told(session.exercise_json)},
          {"software_version", session.software_version},
          {"core_version", or_null(session.core_version)},
          {"layout_hash", layout_text(session.layout_hash)},
          {"stored_bytes", session.stored_bytes}};
}

}  // namespace hoist::db
