// An exercise as JSON, by the table of exercises: read, written and checked in one place. Recordings keep their own name of one size (the
// eight's c_m is their centre_m).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/exercises.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

enum class ExerciseNames : std::uint8_t { told, stored };

/// What is wrong with one field of an exercise; min and max in metres.
struct ExerciseProblem {
  std::string field, message;
  std::optional<double> value = {}, min = {}, max = {};
};

/// Nothing, with every reason in `problems`, for what is no exercise. An optional size may be left out; told also as null or 0.
[[nodiscard]] std::optional<contract::Exercise> read_exercise(const nlohmann::json& value, ExerciseNames names,
                                                              std::vector<ExerciseProblem>& problems);
/// {"shape": "eight", "c_m": 1.0, "radius_m": 0.8} and, where it is walked so, "clockwise": true. An own line has "closed" and its points as
/// "x_m" and "y_m", which are read to whole centimetres.
[[nodiscard]] nlohmann::json exercise_json(const contract::Exercise& exercise, ExerciseNames names);

/// Whether the text is an exercise as recordings store it, at most 1000 bytes, with the task it belongs to where there is one (tasks.hpp);
/// free walking without a task is none. Otherwise bad_value, field exercise.
[[nodiscard]] Status check_exercise(std::string_view stored);
/// The line of a stored exercise; not valid() for a text that check_exercise refuses.
[[nodiscard]] contract::ReferencePath figure_of_stored(std::string_view stored);
/// A stored exercise with the names of REST, without its task; null for none, and for a text that is no JSON object.
[[nodiscard]] nlohmann::json exercise_as_told(const std::optional<std::string>& stored);

}  // namespace hoist::db
