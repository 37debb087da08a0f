// Clinical tasks: what a therapist asks a patient to walk. The files of db/tasks say which there are, what may be adjusted and what ends
// them; a recording names its task and repetition beside its exercise.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "db/metrics/task_end.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/result.hpp"
#include "db/store/task_record.hpp"

namespace hoist::db {

/// What may be chosen, both ends included; `step` is that of a button.
struct TaskRange {
  double usual = 0, least = 0, most = 0, step = 0;
};
struct TaskSize {
  contract::ExerciseRole role{};
  TaskRange range;
};

struct TaskInfo {
  std::string name;
  std::uint32_t version = 0;
  contract::ExerciseShape shape{};  ///< free: the task has no line
  std::vector<TaskSize> sizes;      ///< those that may be adjusted; the others keep their proportion to the first
  std::vector<contract::Mode> leads;
  TaskEnd ends{};
  TaskRange goal;     ///< of `ends`: times along the line, seconds, radians, metres; 0 for an end by hand
  double edge_m = 0;  ///< at both ends of the line, walked but not timed
  TaskRange repetitions, rest_s;
  std::string text;  ///< the file itself, which REST passes on
};

/// A task as it is to be done now.
struct TaskChoice {
  const TaskInfo* task = nullptr;
  contract::Exercise exercise;
  double goal = 0;
  std::uint32_t repetitions = 1;
  double rest_s = 0;
  std::string line = {};  ///< name of an own line
};

/// Reads the files of db/tasks; bad_value with the task and what is wrong with it.
[[nodiscard]] Result<std::vector<TaskInfo>> read_tasks(std::span<const std::string_view> files);
/// THE tasks, in the order of their files. A file that is not one ends the program; the tests read them all.
[[nodiscard]] const std::vector<TaskInfo>& tasks();
/// Null for a name that no task has.
[[nodiscard]] const TaskInfo* find_task(std::string_view name);

/// {"task": "walk_10m"} and what is adjusted: "sizes", "clockwise", "goal", "repetitions", "rest_s"; what is left out is as usual. The task of
/// own lines asks for {"line": {"name", "exercise"}}. Nothing, with every reason in `problems`, for what the task does not allow.
[[nodiscard]] std::optional<TaskChoice> read_task_choice(const nlohmann::json& wish, std::vector<ExerciseProblem>& problems);
[[nodiscard]] TaskRecord task_record(const TaskChoice& choice, std::uint32_t repetition);

/// An exercise with the task it belongs to, as recordings store it.
[[nodiscard]] std::string stored_with_task(const contract::Exercise& exercise, const TaskRecord& record);

}  // namespace hoist::db
