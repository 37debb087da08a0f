// What is walked: as browsers say it, as the database stores it, and the pose where it starts.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/guided_path.hpp"
#include "server/text/field_error.hpp"

namespace hoist::server {

struct Exercise {
  enum class Shape : std::uint8_t { free, eight, square, straight, circle };
  Shape shape = Shape::free;
  double c_m = 0, radius_m = 0;  // eight; the circle has only the radius
  double side_m = 0;             // square
  double corner_radius_m = 0;    // square; 0 = sharp corners
  double length_m = 0;           // straight
  bool clockwise = false;        // not for the straight
};
struct StartPose {
  double x_m = 0, y_m = 0, psi_rad = 0;
};

// Sizes that fit a hall and a hoist.
inline constexpr double kExerciseMin_m = 0.2, kExerciseMax_m = 100.0;

// {"shape": "eight", "c_m", "radius_m"} | {"shape": "square", "side_m", "corner_radius_m"?} | {"shape": "circle", "radius_m"} | {"shape":
// "straight", "length_m"} | {"shape": "free"}, all but the last two with "clockwise"?; null and absent mean free. Nothing, with the reason in
// `errors` by the names below `field`, for anything else.
[[nodiscard]] std::optional<Exercise> read_exercise(const nlohmann::json& value, std::vector<FieldError>& errors,
                                                    const std::string& field = "exercise");
// What the hoist is to drive by itself: an exercise (not free) with "speed_m_s" and "laps"? (1), held against the limits in force. The
// reasons in `errors` when it cannot be driven.
[[nodiscard]] std::optional<contract::GuidedPath> read_guided(const nlohmann::json& value, const contract::GuidedLimits& limits,
                                                              std::vector<FieldError>& errors);
[[nodiscard]] Exercise exercise_of_guided(const contract::GuidedPath& path);
// The figure on the floor; not valid() for free walking.
[[nodiscard]] contract::ReferencePath figure_of(const Exercise& exercise);
[[nodiscard]] nlohmann::json exercise_json(const Exercise& exercise);
// As the database stores it, and db::exercise_as_told() tells it; nothing for free walking.
[[nodiscard]] std::optional<std::string> stored_exercise(const Exercise& exercise);
[[nodiscard]] StartPose start_pose(const Exercise& exercise);
// What a simulator scenario plays: "figure-eight", "square", "straight" …; free for anything else.
[[nodiscard]] Exercise exercise_of_scenario(std::string_view scenario);

}  // namespace hoist::server
