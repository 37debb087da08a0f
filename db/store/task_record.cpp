#include "db/store/task_record.hpp"

#include <nlohmann/json.hpp>

#include "db/store/json_members.hpp"

namespace hoist::db {

using nlohmann::json;

json task_json(const TaskRecord& r) {
  json told{{"task", r.task},     {"version", r.version},       {"ends", task_end_name(r.ends)}, {"goal", r.goal},
            {"edge_m", r.edge_m}, {"repetition", r.repetition}, {"repetitions", r.repetitions},  {"rest_s", r.rest_s}};
  if (!r.line.empty()) told["line"] = r.line;
  return told;
}

std::optional<TaskRecord> read_task_record(const json& value) {
  constexpr std::uint32_t kMost = 1'000'000;
  constexpr std::size_t kNameMost = 64;
  std::string problem;
  Members of(value, "task.", problem);
  TaskRecord record;
  record.task = of.text("task");
  record.version = of.whole("version", 1, kMost);
  const auto end = find_task_end(of.text("ends"));
  record.ends = end.value_or(TaskEnd::hand);
  record.goal = of.number("goal", 0, kMost);
  record.edge_m = of.number("edge_m", 0, kMost);
  record.repetition = of.whole("repetition", 1, kMost);
  record.repetitions = of.whole("repetitions", 1, kMost);
  record.rest_s = of.number("rest_s", 0, kMost);
  if (value.is_object() && value.contains("line")) record.line = of.text("line");
  of.end();
  return problem.empty() && end && record.task.size() <= kNameMost && record.line.size() <= kNameMost ? std::optional{record}
                                                                                                      : std::nullopt;
}

std::optional<TaskRecord> task_of_stored(const std::optional<std::string>& stored) {
  if (!stored) return std::nullopt;
  const json value = json::parse(*stored, nullptr, false);
  const auto task = value.is_object() ? value.find("task") : value.end();
  return value.is_object() && task != value.end() ? read_task_record(*task) : std::nullopt;
}

json task_as_told(const std::optional<std::string>& stored) {
  const auto record = task_of_stored(stored);
  return record ? task_json(*record) : json(nullptr);
}

}  // namespace hoist::db
