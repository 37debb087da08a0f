#include "db/summary/session_json.hpp"

#include <nlohmann/json.hpp>

#include "db/export/exercise_names.hpp"

namespace hoist::db {

nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise) {
  using nlohmann::json;
  const auto or_null = [](const std::optional<double>& value) { return value ? json(*value) : json(nullptr); };
  return {{"session", metrics.session},
          {"C", or_null(metrics.correlation)},
          {"J_N", or_null(metrics.normalised_ise)},
          {"reference_length_m", or_null(metrics.path_length_m)},
          {"duration_s", metrics.moving_s},
          {"missing_s", metrics.missing_s},
          {"distance_m", metrics.distance_m},
          {"mean_speed_m_s", metrics.mean_speed_m_s},
          {"max_speed_m_s", metrics.max_speed_m_s},
          {"track", metrics.track},
          {"exercise", exercise_as_told(exercise)},
          {"reason_if_none", !metrics.why_absent.empty() ? json(metrics.why_absent)
                             : !exercise                 ? json("No exercise was chosen.")
                                                         : json(nullptr)}};
}

}  // namespace hoist::db
