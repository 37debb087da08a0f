// What a recording keeps of the task that it is a repetition of, beside its exercise.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "db/metrics/task_end.hpp"

namespace hoist::db {

/// What a recording says of its task, so that its figures do not depend on today's files.
struct TaskRecord {
  std::string task;
  std::uint32_t version = 1;
  TaskEnd ends{};
  double goal = 0, edge_m = 0;
  std::uint32_t repetition = 1, repetitions = 1;
  double rest_s = 0;
  std::string line = {};  ///< name of an own line; empty = none
};

[[nodiscard]] nlohmann::json task_json(const TaskRecord& record);
/// Nothing for what is no task of a recording.
[[nodiscard]] std::optional<TaskRecord> read_task_record(const nlohmann::json& value);
/// The task of a stored exercise; nothing for an exercise without one, and for a text that check_exercise refuses.
[[nodiscard]] std::optional<TaskRecord> task_of_stored(const std::optional<std::string>& stored);
/// The same as JSON; null for none.
[[nodiscard]] nlohmann::json task_as_told(const std::optional<std::string>& stored);

}  // namespace hoist::db
