// Own lines in the store, and as JSON.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "db/store/exercise_json.hpp"
#include "db/store/lines.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/tasks.hpp"
#include "db/summary/trend.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

using contract::Exercise;
using contract::ExerciseShape;
using nlohmann::json;

Exercise own_line() { return contract::usual_exercise(ExerciseShape::own); }

TEST(OwnLine, IsReadToCentimetresWrittenAndReadAgainTheSame) {
  json told = exercise_json(own_line(), ExerciseNames::told);
  EXPECT_EQ(told["x_m"], (json{0.0, 4.0, 4.0, 2.0, 0.0}));
  told["x_m"][1] = 3.999;
  told["y_m"][2] = 1.23456;
  std::vector<ExerciseProblem> problems;
  const auto read = read_exercise(told, ExerciseNames::told, problems);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->line.points[1].x_m, 4.0);
  EXPECT_EQ(read->line.points[2].y_m, 1.23);
  const std::string stored = exercise_json(*read, ExerciseNames::stored).dump();
  ASSERT_TRUE(check_exercise(stored).ok());
  EXPECT_EQ(read_exercise(json::parse(stored), ExerciseNames::stored, problems)->line, read->line);
  EXPECT_EQ(figure_of_stored(stored).length_m(), contract::figure_of(*read).length_m());
  // The largest line with the longest texts of a task still fits a recording.
  Exercise most{{ExerciseShape::own, false, 0, 19.99}, {}};
  most.line.closed = true;
  for (most.line.count = 0; most.line.count < contract::kOwnPointsMost; ++most.line.count)
    most.line.points[most.line.count] = {-49.99 + 0.21 * static_cast<double>(most.line.count), -49.99};
  json largest = exercise_json(most, ExerciseNames::stored);
  largest["task"] = {{"task", std::string(64, 'x')},
                     {"version", 1},
                     {"ends", "distance"},
                     {"goal", 20.0},
                     {"edge_m", 0.0},
                     {"repetition", 20},
                     {"repetitions", 20},
                     {"rest_s", 600.0},
                     {"line", std::string(64, '"')}};
  EXPECT_TRUE(check_exercise(largest.dump()).ok()) << largest.dump().size() << ' ' << check_exercise(largest.dump()).error().message;
}

TEST(OwnLine, ARefusalNamesThePointAndTheRange) {
  const auto problem = [](const json& patch) {
    json told = exercise_json(own_line(), ExerciseNames::told);
    told.merge_patch(patch);
    std::vector<ExerciseProblem> problems;
    EXPECT_FALSE(read_exercise(told, ExerciseNames::told, problems)) << told;
    return problems.empty() ? ExerciseProblem{} : problems.front();
  };
  const ExerciseProblem far = problem({{"y_m", {0, 0, -50.01, 3, 2}}});
  EXPECT_EQ(far.field, "y_m.2");
  EXPECT_EQ(far.value, -50.01);
  EXPECT_EQ(far.min, -50);
  EXPECT_EQ(far.max, 50);
  const ExerciseProblem near = problem({{"x_m", {0, 4, 4, 4, 0}}, {"y_m", {0, 0, 2, 2.1, 2}}});
  EXPECT_EQ(near.field, "x_m.3");
  EXPECT_NEAR(*near.value, 0.1, 1e-9);
  EXPECT_EQ(near.min, 0.2);
  EXPECT_EQ(problem({{"x_m", {0, 4, 4, 2, 0.1}}, {"y_m", {0, 0, 2, 3, 0}}}).field, "x_m.0") << "the closing straight";
  const ExerciseProblem many = problem({{"x_m", json(std::vector<double>(25, 1.0))}});
  EXPECT_EQ(many.field, "x_m");
  EXPECT_EQ(many.value, 25);
  EXPECT_EQ(many.min, 3) << "closed";
  EXPECT_EQ(many.max, 24);
  EXPECT_EQ(problem({{"y_m", {0, 0}}}).field, "y_m");
  EXPECT_EQ(problem({{"closed", 1}}).field, "closed");
  EXPECT_EQ(problem({{"corner_radius_m", -1}}).field, "corner_radius_m");
  EXPECT_EQ(problem({{"points", 1}}).field, "points");
}

TEST(OwnLine, IsKeptByNameChangedForWhatWasSeenAndDeleted) {
  TemporaryFolder dir;
  Database database = std::move(*Database::open(dir / "hoist.db"));
  LineStore lines(database);
  const auto made = lines.create("Hall", own_line(), kStartUtc_ns);
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(made->version, 1);
  EXPECT_EQ(made->exercise.line, own_line().line);
  EXPECT_EQ(lines.create("Hall", own_line(), 0).error().kind, ErrorKind::taken);
  EXPECT_EQ(lines.create("", own_line(), 0).error().field, "name");
  EXPECT_EQ(lines.create("two\nlines", own_line(), 0).error().field, "name");
  EXPECT_EQ(lines.create("Square", contract::usual_exercise(ExerciseShape::square), 0).error().kind, ErrorKind::bad_value);
  EXPECT_EQ(lines.create("Nothing", Exercise{{ExerciseShape::own, false, 0, 0}, {}}, 0).error().kind, ErrorKind::bad_value);

  Exercise open = own_line();
  open.line.closed = false;
  const auto changed = lines.change(made->id, {.name = "Corridor", .exercise = open}, kStartUtc_ns + 1, made->tag);
  ASSERT_TRUE(changed.ok());
  EXPECT_EQ(std::pair(changed->name, changed->version), std::pair(std::string("Corridor"), std::int64_t{2}));
  EXPECT_FALSE(lines.get(made->id)->exercise.line.closed);
  EXPECT_EQ(lines.change(made->id, {.name = "x", .exercise = {}}, 0, made->tag).error().kind, ErrorKind::changed);
  ASSERT_TRUE(lines.create("Hall", own_line(), 0).ok());
  EXPECT_EQ(lines.change(made->id, {.name = "Hall", .exercise = {}}, 0, "").error().kind, ErrorKind::taken);
  const auto page = lines.list({.limit = 1});
  EXPECT_EQ(page->items.at(0).name, "Hall") << "newest first";
  EXPECT_EQ(lines.list({.limit = 1, .before = page->next})->items.at(0).name, "Corridor");
  EXPECT_EQ(lines.remove(made->id, made->tag).error().kind, ErrorKind::changed);
  ASSERT_TRUE(lines.remove(made->id, changed->tag).ok());
  EXPECT_EQ(lines.get(made->id).error().kind, ErrorKind::not_found);
  EXPECT_EQ(lines.remove(made->id, "").error().kind, ErrorKind::not_found);

  for (std::size_t i = 1; i < kMaxLines; ++i) ASSERT_TRUE(lines.create(std::to_string(i), own_line(), 0).ok());
  EXPECT_EQ(lines.create("one more", own_line(), 0).error().kind, ErrorKind::wrong_state);
  execute(database.handle(), "UPDATE lines SET exercise = '{}' WHERE name = '1'");
  EXPECT_EQ(lines.list({.limit = 200}).error().kind, ErrorKind::corrupt);
}

TEST(OwnLine, ATrendTellsItsNameAndComparesWalksAlongTheSamePoints) {
  const auto walked = [](const Exercise& exercise, const std::string& name) {
    TaskRecord task;
    task.task = "own_line";
    task.line = name;
    TrendSession session;
    session.exercise_json = stored_with_task(exercise, task);
    return session;
  };
  Exercise other = own_line();
  other.line.points[1].x_m += 1;
  const TrendSession hall = walked(own_line(), "Hall"), renamed = walked(own_line(), "Hall, first floor"), garden = walked(other, "Hall");
  EXPECT_EQ(trend_item_json({hall, std::nullopt})["line"], "Hall");
  EXPECT_TRUE(comparable(hall, renamed));
  EXPECT_FALSE(comparable(hall, garden)) << "the name alone says nothing";
  TrendSession untitled;
  untitled.exercise_json = exercise_json(own_line(), ExerciseNames::stored).dump();
  EXPECT_TRUE(trend_item_json({untitled, std::nullopt})["line"].is_null());
}

}  // namespace
}  // namespace hoist::db::test
