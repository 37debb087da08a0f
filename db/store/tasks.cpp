#include "db/store/tasks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "control/contract/guided_path.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/json_members.hpp"
#include "db/store/lines.hpp"
#include "db/store/task_list.hpp"

namespace hoist::db {

using contract::Exercise;
using contract::ExerciseRole;
using contract::ExerciseShape;
using nlohmann::json;

namespace {
/// Half of the finest step: a value given in decimals is that number, not its neighbour.
constexpr double kWithin = 1e-9;

TaskRange range(Members& members, const char* name, double least, double most) {
  Members of = members.inside(name);
  TaskRange range;
  range.least = of.number("least", least, most);
  range.most = of.number("most", range.least, most);
  range.usual = of.number("usual", range.least, range.most);
  range.step = of.number("step", kWithin, most > 1 ? most : 1);
  of.end();
  return range;
}

void read_sizes(const json& sizes, TaskInfo& task, std::string& problem) {
  Members members(sizes, "sizes.", problem);
  for (const contract::ExerciseSize& row : contract::kExerciseSizes) {
    const std::string name{row.name};
    if (row.shape != task.shape || !sizes.is_object() || !sizes.contains(name)) continue;
    const double least_m = row.required ? contract::kExerciseLeast_m : 0.0;
    task.sizes.push_back({row.role, range(members, name.c_str(), least_m, contract::kExerciseMost_m)});
  }
  members.end();
  if (contract::drivable(task.shape) && task.sizes.empty()) members.wrong("", "must have a size");
}

void read_leads(const json& leads, TaskInfo& task, std::string& problem) {
  if (!leads.is_array() || leads.empty()) problem = problem.empty() ? "leads must be a list" : problem;
  for (const json& lead : leads) {
    const auto row = std::ranges::find_if(contract::kModes, [&](const contract::ModeInfo& m) { return lead == m.name && m.moving; });
    if (row == contract::kModes.end())
      problem = problem.empty() ? "leads names a mode in which the wheels do not turn" : problem;
    else
      task.leads.push_back(static_cast<contract::Mode>(row->value));
  }
  if (!contract::drivable(task.shape) && std::ranges::count(task.leads, contract::Mode::guided) != 0)
    problem = problem.empty() ? "leads: the hoist cannot lead along this line" : problem;
}

void read_end(const json& ends, TaskInfo& task, std::string& problem) {
  Members of(ends, "ends.", problem);
  const auto end = find_task_end(of.text("by"));
  if (!end) of.wrong("by", "must be distance, time, turn, back or hand");
  task.ends = end.value_or(TaskEnd::hand);
  switch (task.ends) {
    case TaskEnd::distance:
      task.goal = range(of, "goal", 1, contract::kGuidedLapsMost);
      if (task.shape == ExerciseShape::free) of.wrong("by", "needs a line");
      break;
    case TaskEnd::time:
      task.goal = range(of, "goal", 1, 3600);
      break;
    case TaskEnd::turn:
      task.goal = range(of, "goal", 0.1, 100);
      break;
    case TaskEnd::back:
      task.goal = range(of, "goal", 1, 100);
      break;
    case TaskEnd::hand:
      task.goal = range(of, "goal", 0, 0);
  }
  of.end();
}

void read_results(const json& results, std::string& problem) {
  if (!results.is_array() || results.empty()) problem = problem.empty() ? "results must be a list" : problem;
  for (const json& key : results)
    if (std::ranges::none_of(kMetrics, [&key](const MetricInfo& m) { return key == m.key; }))
      problem = problem.empty() ? "results names a figure that does not exist: " + key.dump() : problem;
}

TaskInfo read_task(std::string_view text, std::string& problem) {
  const json file = json::parse(text, nullptr, false);
  TaskInfo task;
  task.text = text;
  Members members(file, "", problem);
  task.name = members.text("name");
  task.version = members.whole("version", 1, 1'000'000);
  members.words("title");
  members.words("instruction");
  const json& line = members.member("line");
  const contract::ExerciseInfo* shape = line.is_string() ? contract::find_exercise(line.get_ref<const std::string&>()) : nullptr;
  task.shape = shape == nullptr ? ExerciseShape::free : shape->shape;
  if (!line.is_null() && task.shape == ExerciseShape::free) members.wrong("line", "must be an exercise, or null");
  read_sizes(members.member("sizes"), task, problem);
  read_leads(members.member("leads"), task, problem);
  read_end(members.member("ends"), task, problem);
  task.edge_m = members.number("edge_m", 0, 10);
  task.repetitions = range(members, "repetitions", 1, 100);
  task.rest_s = range(members, "rest_s", 0, 3600);
  read_results(members.member("results"), problem);
  members.end();
  if (problem.empty() && 2 * task.edge_m > 0 &&
      (task.shape != ExerciseShape::straight || task.sizes.front().range.least <= 2 * task.edge_m))
    members.wrong("edge_m", "leaves nothing of the line");
  return task;
}

// What is wrong with one value of a choice.
void check_range(const std::string& field, double given, const TaskRange& range, std::vector<ExerciseProblem>& problems) {
  // Written so that a NaN fails.
  if (!(given >= range.least - kWithin && given <= range.most + kWithin))
    problems.push_back({field, "is outside its range", given, range.least, range.most});
}
double number_or(const json& wish, const std::string& name, const TaskRange& range, const std::string& field,
                 std::vector<ExerciseProblem>& problems) {
  const auto at = wish.find(name);
  if (at == wish.end() || at->is_null()) return range.usual;
  if (!at->is_number()) {
    problems.push_back({field, "must be a number", std::nullopt, range.least, range.most});
    return range.usual;
  }
  check_range(field, at->get<double>(), range, problems);
  return at->get<double>();
}

Exercise exercise_of(const TaskInfo& task, const json& wish, std::vector<ExerciseProblem>& problems) {
  Exercise exercise = contract::usual_exercise(task.shape);
  const double usual_m = exercise.size_m;
  const json sizes = wish.contains("sizes") && wish["sizes"].is_object() ? wish["sizes"] : json::object();
  std::size_t known = 0;
  bool radius_told = false;
  for (const TaskSize& size : task.sizes) {
    const std::string name{contract::find_size(task.shape, size.role)->name};
    known += sizes.contains(name) ? 1 : 0;
    radius_told = radius_told || size.role == ExerciseRole::radius;
    contract::size_of(exercise, size.role) = number_or(sizes, name, size.range, "sizes." + name, problems);
  }
  if (known != sizes.size()) problems.push_back({"sizes", "has one that this task does not adjust"});
  if (!radius_told && usual_m > 0) exercise.radius_m *= exercise.size_m / usual_m;
  const auto turned = wish.find("clockwise");
  exercise.clockwise = turned != wish.end() && *turned == true;
  if (exercise.clockwise && !contract::find_exercise(task.shape)->turned) problems.push_back({"clockwise", "is not for this task"});
  return exercise;
}

// The line of a task of own lines.
void read_own_line(const json& wish, TaskChoice& choice, std::vector<ExerciseProblem>& problems) {
  const auto line = wish.find("line");
  const bool there = line != wish.end() && !line->is_null();
  if (choice.task->shape != ExerciseShape::own) {
    if (there) problems.push_back({"line", "is not for this task"});
    return;
  }
  if (!there || !line->is_object()) return problems.push_back({"line", "must be an own line: name and exercise"});
  const auto name = line->find("name");
  if (name != line->end() && name->is_string()) choice.line = name->get<std::string>();
  if (Status checked = check_line_name(choice.line); !checked) problems.push_back({"line.name", checked.error().message});
  const auto exercise = line->find("exercise");
  std::vector<ExerciseProblem> wrong;
  const auto read = read_exercise(exercise == line->end() ? json::object() : *exercise, ExerciseNames::told, wrong);
  if (read && read->shape != ExerciseShape::own) wrong.push_back({"shape", "must be own"});
  for (ExerciseProblem& problem : wrong) {
    problem.field = "line.exercise." + problem.field;
    problems.push_back(std::move(problem));
  }
  if (read) choice.exercise = *read;
}

std::uint32_t whole_or(const json& wish, const char* name, const TaskRange& range, std::vector<ExerciseProblem>& problems) {
  const double given = number_or(wish, name, range, name, problems);
  if (given != std::floor(given)) problems.push_back({name, "must be a whole number", given, range.least, range.most});
  return given >= 0 && given <= 1e6 ? static_cast<std::uint32_t>(given) : 1;
}
}  // namespace

Result<std::vector<TaskInfo>> read_tasks(std::span<const std::string_view> files) {
  std::vector<TaskInfo> tasks;
  for (const std::string_view file : files) {
    std::string problem;
    TaskInfo task = read_task(file, problem);
    if (std::ranges::count(tasks, task.name, &TaskInfo::name) != 0) problem = "name is that of another task";
    if (!problem.empty()) return Error{ErrorKind::bad_value, "task " + task.name + ": " + problem, "task"};
    tasks.push_back(std::move(task));
  }
  return tasks;
}

const std::vector<TaskInfo>& tasks() {
  static const std::vector<TaskInfo> kTasks = [] {
    Result<std::vector<TaskInfo>> read = read_tasks(task_list());
    if (!read) {
      std::fprintf(stderr, "%s\n", read.error().message.c_str());
      std::abort();
    }
    return std::move(*read);
  }();
  return kTasks;
}

const TaskInfo* find_task(std::string_view name) {
  const auto at = std::ranges::find(tasks(), name, &TaskInfo::name);
  return at == tasks().end() ? nullptr : &*at;
}

std::optional<TaskChoice> read_task_choice(const json& wish, std::vector<ExerciseProblem>& problems) {
  const auto name = wish.is_object() ? wish.find("task") : wish.end();
  const TaskInfo* task =
      wish.is_object() && name != wish.end() && name->is_string() ? find_task(name->get_ref<const std::string&>()) : nullptr;
  if (task == nullptr) {
    problems.push_back({"task", "is not one of /api/v1/tasks"});
    return std::nullopt;
  }
  const std::size_t before = problems.size();
  TaskChoice choice{.task = task, .exercise = exercise_of(*task, wish, problems)};
  choice.goal = number_or(wish, "goal", task->goal, "goal", problems);
  read_own_line(wish, choice, problems);
  if (task->ends == TaskEnd::distance) choice.goal = whole_or(wish, "goal", task->goal, problems);
  choice.repetitions = whole_or(wish, "repetitions", task->repetitions, problems);
  choice.rest_s = number_or(wish, "rest_s", task->rest_s, "rest_s", problems);
  if (task->shape == ExerciseShape::own && !choice.exercise.line.closed && choice.goal > 1)
    problems.push_back({"goal", "is once along an open line", choice.goal, 1.0, 1.0});
  // What a recording may not hold, a task must not ask for: a radius beyond its share of the size.
  if (problems.size() == before && task->shape != ExerciseShape::free)
    (void)read_exercise(exercise_json(choice.exercise, ExerciseNames::told), ExerciseNames::told, problems);
  return problems.size() == before ? std::optional{choice} : std::nullopt;
}

TaskRecord task_record(const TaskChoice& choice, std::uint32_t repetition) {
  return {.task = choice.task->name,
          .version = choice.task->version,
          .ends = choice.task->ends,
          .goal = choice.goal,
          .edge_m = choice.task->edge_m,
          .repetition = repetition,
          .repetitions = choice.repetitions,
          .rest_s = choice.rest_s,
          .line = choice.line};
}

std::string stored_with_task(const Exercise& exercise, const TaskRecord& record) {
  json stored = exercise_json(exercise, ExerciseNames::stored);
  stored["task"] = task_json(record);
  return stored.dump();
}

}  // namespace hoist::db
