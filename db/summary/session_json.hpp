// A session and its figures as programs read them: the names that REST uses, for the command line and the exported files.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "db/store/session_types.hpp"
#include "db/summary/session_metrics.hpp"

namespace hoist::db {

/// {"session", "C", "J_N", "reference_length_m", "duration_s" (in motion), …, "exercise", "reason_if_none"}; null = not defined.
nlohmann::json metrics_json(const SessionMetrics& metrics, const std::optional<std::string>& exercise);

}  // namespace hoist::db
