// The files of db/tasks, and how a recording names its task.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "control/contract/guided_path.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/task_list.hpp"
#include "db/store/tasks.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

using nlohmann::json;

TEST(Tasks, EveryFileIsOneAndAllThatItAllowsCanBeWalked) {
  ASSERT_GE(tasks().size(), 13U);
  for (const TaskInfo& task : tasks()) {
    SCOPED_TRACE(task.name);
    for (const auto end : {&TaskRange::least, &TaskRange::usual, &TaskRange::most}) {
      json wish{{"task", task.name}, {"goal", task.goal.*end}, {"repetitions", task.repetitions.*end}, {"rest_s", task.rest_s.*end}};
      if (task.shape == contract::ExerciseShape::own)
        wish["line"] = {{"name", "Hall"}, {"exercise", exercise_json(contract::usual_exercise(task.shape), ExerciseNames::told)}};
      for (const TaskSize& size : task.sizes)
        wish["sizes"][std::string(contract::find_size(task.shape, size.role)->name)] = size.range.*end;
      std::vector<ExerciseProblem> problems;
      const auto choice = read_task_choice(wish, problems);
      ASSERT_TRUE(choice) << wish << problems.front().field << ' ' << problems.front().message;
      EXPECT_EQ(choice->goal, task.goal.*end);
      const std::string stored = stored_with_task(choice->exercise, task_record(*choice, 2));
      EXPECT_TRUE(check_exercise(stored).ok()) << stored;
      EXPECT_EQ(task_of_stored(stored)->repetition, 2U);
      EXPECT_EQ(task_of_stored(stored)->line, wish.contains("line") ? "Hall" : "");
      EXPECT_EQ(std::ranges::count(task.leads, contract::Mode::guided) != 0, contract::drivable(task.shape));
      if (!contract::drivable(task.shape)) continue;
      // What the hoist may lead, it can: by the core's own check, with the usual limits.
      contract::GuidedPath path;
      static_cast<contract::SizedExercise&>(path) = choice->exercise;
      path.speed_m_s = 0.2;
      const contract::GuidedProblems wrong = contract::check_guided(path, contract::guided_limits(contract::Params{}));
      EXPECT_EQ(wrong.count, 0U) << stored << static_cast<int>(wrong.rows[0].field) << ' ' << wrong.rows[0].value;
    }
  }
  // The hoist has no lift: nothing that needs one is offered.
  for (const char* name : {"sit_stand", "chair_rise"}) EXPECT_EQ(find_task(name), nullptr);
}

TEST(Tasks, AFileThatIsNoTaskIsRefusedByName) {
  const json good = json::parse(task_list()[0]);
  const auto problem = [](const json& file) {
    const std::string text = file.dump();
    const std::string_view one = text;
    const auto read = read_tasks({&one, 1});
    return read ? "" : read.error().message;
  };
  ASSERT_EQ(problem(good), "");
  const auto changed = [&](const json& patch) {
    json file = good;
    file.merge_patch(patch);
    return problem(file);
  };
  EXPECT_NE(changed({{"colour", "red"}}).find("not known"), std::string::npos);
  EXPECT_NE(changed({{"line", "spiral"}}).find("line"), std::string::npos);
  EXPECT_NE(changed({{"instruction", {{"de", ""}}}}).find("instruction.de"), std::string::npos);
  EXPECT_NE(changed({{"sizes", {{"length_m", {{"usual", 99}}}}}}).find("usual"), std::string::npos);
  EXPECT_NE(changed({{"leads", {"standby"}}}).find("leads"), std::string::npos);
  EXPECT_NE(changed({{"ends", {{"by", "bell"}}}}).find("by"), std::string::npos);
  EXPECT_NE(changed({{"results", {"happiness"}}}).find("happiness"), std::string::npos);
  EXPECT_NE(changed({{"edge_m", 3}}).find("edge_m"), std::string::npos) << "6 m of line, 3 m of edge at both ends";
  EXPECT_NE(changed({{"sizes", nullptr}}).find("sizes is missing"), std::string::npos) << "a merged null takes it out";
  const std::string_view twice[] = {task_list()[0], task_list()[0]};
  EXPECT_NE(read_tasks(twice).error().message.find("another"), std::string::npos);
}

TEST(Tasks, AnOwnLineIsAskedForWithNameAndPointsOnly) {
  const json good{{"task", "own_line"},
                  {"line", {{"name", "Hall"}, {"exercise", {{"shape", "own"}, {"closed", false}, {"x_m", {0, 2}}, {"y_m", {0, 1}}}}}}};
  const auto field = [](const json& wish) -> std::string {
    std::vector<ExerciseProblem> problems;
    const auto choice = read_task_choice(wish, problems);
    EXPECT_NE(choice.has_value(), !problems.empty());
    return problems.empty() ? "" : problems.front().field;
  };
  EXPECT_EQ(field(good), "");
  const auto changed = [&](const json& patch) {
    json wish = good;
    wish.merge_patch(patch);
    return field(wish);
  };
  EXPECT_EQ(changed({{"line", nullptr}}), "line");
  EXPECT_EQ(changed({{"line", {{"name", ""}}}}), "line.name");
  EXPECT_EQ(changed({{"line", {{"name", std::string(65, 'x')}}}}), "line.name");
  EXPECT_EQ(changed({{"line", {{"exercise", nullptr}}}}), "line.exercise.shape");
  EXPECT_EQ(changed({{"line", {{"exercise", {{"x_m", {0, 60}}}}}}}), "line.exercise.x_m.1");
  EXPECT_EQ(changed({{"line", {{"exercise", {{"shape", "free"}, {"closed", nullptr}, {"x_m", nullptr}, {"y_m", nullptr}}}}}}),
            "line.exercise.shape");
  EXPECT_EQ(changed({{"goal", 2}}), "goal") << "an open line has no laps";
  EXPECT_EQ(changed({{"clockwise", true}}), "clockwise");
  EXPECT_EQ(changed({{"task", "free_walk"}}), "line") << "of this task only";
}

TEST(Tasks, ARecordingSaysItsTaskAndRefusesWhatIsNone) {
  const std::string stored =
      R"({"shape":"free","task":{"task":"turn_180","version":1,"ends":"turn","goal":3.14,"edge_m":0,"repetition":1,"repetitions":4,"rest_s":30}})";
  EXPECT_TRUE(check_exercise(stored).ok());
  EXPECT_EQ(exercise_as_told(stored), (json{{"shape", "free"}})) << "the exercise alone";
  EXPECT_EQ(task_as_told(stored)["goal"], 3.14);
  EXPECT_FALSE(check_exercise(R"({"shape":"free"})").ok()) << "free walking without a task is no exercise";
  EXPECT_FALSE(check_exercise(R"({"shape":"free","task":{"task":"turn_180"}})").ok());
  EXPECT_FALSE(check_exercise(R"({"shape":"circle","radius_m":1,"task":7})").ok());
  for (const char* const no_count : {"1.5", "0", "1e300", "-1", "null"}) {
    std::string wrong = stored;
    wrong.replace(wrong.find("\"repetition\":1") + 13, 1, no_count);
    EXPECT_FALSE(check_exercise(wrong).ok()) << no_count;
  }
  EXPECT_TRUE(task_as_told(R"({"shape":"circle","radius_m":1})").is_null());
  EXPECT_TRUE(task_as_told(std::nullopt).is_null());
}

}  // namespace
}  // namespace hoist::db::test
