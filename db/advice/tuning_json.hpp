// Suggested settings as programs read them: the names that REST and `hoist tune-advice --json` use.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "db/advice/tuning.hpp"

namespace hoist::db {

/// A row for each rule; a rule without a suggestion has its reason, and null for all numbers.
[[nodiscard]] nlohmann::json tuning_json(const TuningAdvice& advice);

}  // namespace hoist::db
