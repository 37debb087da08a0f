// What is walked: as clients say it, as the database stores it, and the pose where it starts. The shapes: control/contract/exercises.def.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/guided_path.hpp"
#include "db/store/tasks.hpp"
#include "server/text/field_error.hpp"

namespace hoist::server {

using contract::Exercise;
struct StartPose {
  double x_m = 0, y_m = 0, psi_rad = 0;
};

// By the table of exercises (db/store/exercise_json.hpp); null means free. Nothing, with the reason in `errors` by the names below `field`,
// for anything else.
[[nodiscard]] std::optional<Exercise> read_exercise(const nlohmann::json& value, std::vector<FieldError>& errors,
                                                    const std::string& field = "exercise");
// What the hoist is to drive by itself: an exercise (not free) with "speed_m_s" and "laps"? (1), held against the limits in force. The
// reasons in `errors` when it cannot be driven.
[[nodiscard]] std::optional<contract::GuidedPath> read_guided(const nlohmann::json& value, const contract::GuidedLimits& limits,
                                                              std::vector<FieldError>& errors);
[[nodiscard]] nlohmann::json exercise_json(const Exercise& exercise);
// As the database stores it, and db::exercise_as_told() tells it, with the task that it belongs to; nothing for free walking without one.
[[nodiscard]] std::optional<std::string> stored_exercise(const Exercise& exercise, const std::optional<db::TaskRecord>& task = {});
[[nodiscard]] StartPose start_pose(const Exercise& exercise);
// What a simulator scenario plays: "figure-eight", "square", "straight" …; free for anything else.
[[nodiscard]] Exercise exercise_of_scenario(std::string_view scenario);

}  // namespace hoist::server
