#include "db/summary/session_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "db/export/exercise_names.hpp"
#include "db/export/provenance.hpp"
#include "db/metrics/run_summary.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/moving_part.hpp"

namespace hoist::db {

nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise) {
  using nlohmann::json;
  const auto or_null = [](const std::optional<double>& value) { return value ? json(*value) : json(nullptr); };
  const NoFigure why = metrics.why_absent;
  return {{"session", metrics.session},
          {"C", or_null(metrics.correlation)},
          {"J_N", or_null(metrics.normalised_ise)},
          {"reference_length_m", or_null(metrics.path_length_m)},
          {"duration_s", metrics.moving_s},
          {"motion_s", metrics.motion_s},
          {"missing_s", metrics.missing_s},
          {"distance_m", metrics.distance_m},
          {"mean_speed_m_s", metrics.mean_speed_m_s},
          {"max_speed_m_s", metrics.max_speed_m_s},
          {"track", metrics.track},
          {"exercise", exercise_as_told(exercise)},
          {"reason_if_none", why == NoFigure::none ? json(nullptr) : json(no_figure_sentence(why))},
          {"reason_code", why == NoFigure::none ? json(nullptr) : json(no_figure_name(why))}};
}

Result<nlohmann::json> session_metrics_json(Database& database, SessionId session) {
  using nlohmann::json;
  const auto info = SessionReader(database).get(session);
  if (!info) return info.error();
  const auto part = moving_part(database, session);
  if (!part) return part.error();
  const auto metrics = session_metrics(database, session, *part);
  if (!metrics) return metrics.error();
  // Compared where it is judged at all.
  std::optional<RunDeviation> off;
  if (info->exercise_json && metrics->normalised_ise)
    off = run_deviation(path_of_exercise(*info->exercise_json), run_of(*part, metrics->start_m));
  const auto or_null = [](double value) { return std::isfinite(value) ? json(value) : json(nullptr); };
  json told = metrics_json(*metrics, info->exercise_json);
  told["rms_position_m"] = off ? or_null(off->position_rms_m) : json(nullptr);
  told["rms_heading_rad"] = off ? or_null(off->heading_rms_rad) : json(nullptr);
  return told;
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
