// An exercise is stored with the names of check_exercise; everybody outside is told REST's: the eight's centre is "c_m".
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace hoist::db {

/// Null for none, and for a text that is no JSON object.
nlohmann::json exercise_as_told(const std::optional<std::string>& stored);

}  // namespace hoist::db
