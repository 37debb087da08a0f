// What is walked: as browsers say it, as the database stores it, and the pose where it starts.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/problem.hpp"

namespace hoist::server {

struct Exercise {
  enum class Shape : std::uint8_t { free, eight, square, straight };
  Shape shape = Shape::free;
  double c_m = 0, radius_m = 0;  // eight
  double side_m = 0;             // square
  double length_m = 0;           // straight
};
struct StartPose {
  double x_m = 0, y_m = 0, psi_rad = 0;
};

// Sizes that fit a hall and a hoist.
inline constexpr double kExerciseMin_m = 0.2, kExerciseMax_m = 100.0;

// {"shape": "eight", "c_m", "radius_m"} | {"shape": "square", "side_m"} | {"shape": "straight", "length_m"} | {"shape": "free"}; null and
// absent mean free. Nothing, with the reason in `errors`, for anything else.
[[nodiscard]] std::optional<Exercise> read_exercise(const nlohmann::json& value, std::vector<FieldError>& errors);
[[nodiscard]] nlohmann::json exercise_json(const Exercise& exercise);
// As the database stores it; nothing for free walking.
[[nodiscard]] std::optional<std::string> stored_exercise(const Exercise& exercise);
// The database's text as browsers read it; null for nothing or a text that cannot be read.
[[nodiscard]] nlohmann::json exercise_of_store(const std::optional<std::string>& text);
[[nodiscard]] StartPose start_pose(const Exercise& exercise);
// What a simulator scenario plays: "figure-eight", "square", "straight" …; free for anything else.
[[nodiscard]] Exercise exercise_of_scenario(std::string_view scenario);

}  // namespace hoist::server
