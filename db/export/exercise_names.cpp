#include "db/export/exercise_names.hpp"

#include <nlohmann/json.hpp>

namespace hoist::db {

nlohmann::json exercise_as_told(const std::optional<std::string>& stored) {
  if (!stored) return nullptr;
  nlohmann::json exercise = nlohmann::json::parse(*stored, nullptr, false);
  if (!exercise.is_object()) return nullptr;
  if (const auto centre = exercise.find("centre_m"); centre != exercise.end()) {
    exercise["c_m"] = *centre;
    exercise.erase("centre_m");
  }
  return exercise;
}

}  // namespace hoist::db
