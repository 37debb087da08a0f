// What every screen is told of the walk: the exercise, the start mark, the time in motion and the path.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>
#include <utility>

#include "control/contract/faults.hpp"
#include "server/state/walk.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;
using contract::TickRecord;

TickRecord standing(std::uint64_t tick, Mode mode = Mode::standby) {
  TickRecord record{};
  record.tick = tick;
  record.time_ns = tick * 10'000'000;
  record.mode = static_cast<std::uint8_t>(mode);
  return record;
}

TEST(Walk, APathOfAnyLengthStaysBoundedAndKeepsBothEnds) {
  server::PathTrace path;
  constexpr double kLength_m = 1000;
  for (int i = 0; i <= 100'000; ++i) path.add(i * 0.01, 0);
  ASSERT_LT(path.x_m().size(), server::PathTrace::kPointsMost);
  EXPECT_GT(path.x_m().size(), server::PathTrace::kPointsMost / 4);
  EXPECT_EQ(path.x_m().front(), 0);
  EXPECT_NEAR(path.x_m().back(), kLength_m, path.step_m() + 0.01);
  for (std::size_t i = 1; i < path.x_m().size(); ++i) {
    EXPECT_GE(path.x_m()[i] - path.x_m()[i - 1], path.step_m() - 1e-9) << i;
    EXPECT_LE(path.x_m()[i] - path.x_m()[i - 1], 1.6 * path.step_m()) << i;
  }
}

TEST(Walk, OnlyMotionCountsAndAStopInBetweenBeginsNothingAnew) {
  server::Walk walk(server::exercise_of_scenario("square"));
  std::uint64_t tick = 1;
  float distance_m = 0;
  const auto steps = [&](Mode mode, int count, float step_m) {
    for (int i = 0; i < count; ++i) {
      TickRecord record = standing(tick++, mode);
      record.distance_m = record.fused_x_m = distance_m += step_m;
      EXPECT_EQ(walk.take(record).marked, record.tick == 1);
    }
  };
  steps(Mode::standby, 50, 0);
  steps(Mode::user, 201, 0.005F);
  steps(Mode::protective_stop, 500, 0);
  steps(Mode::user, 101, 0.005F);
  const auto told = walk.told();
  EXPECT_NEAR(told["motion_s"].get<double>(), 3.0, 1e-9) << "2 s and 1 s of walking, 5 s of standing";
  EXPECT_NEAR(told["x_m"].back().get<double>(), 302 * 0.005, 0.021);
  EXPECT_EQ(told["x_m"].front(), 0);
  EXPECT_EQ(told["tick"], tick - 1);
}

TEST(Walk, AStartMarkBeginsAnew) {
  server::Walk walk({});
  for (std::uint64_t tick = 1; tick <= 300; ++tick) {
    TickRecord record = standing(tick, Mode::user);
    record.start_mark = 4;
    record.distance_m = record.fused_x_m = static_cast<float>(tick) * 0.01F;
    walk.take(record);
  }
  TickRecord record = standing(301);
  record.start_mark = 5;
  record.fused_x_m = -1.5F;
  record.fused_psi_rad = 0.5F;
  EXPECT_TRUE(walk.take(record).marked);
  const auto told = walk.told();
  EXPECT_EQ(told["mark"], (json{{"x_m", -1.5}, {"y_m", 0.0}, {"psi_rad", 0.5}}));
  EXPECT_EQ(told["x_m"], json::array({-1.5}));
  EXPECT_EQ(told["motion_s"], 0.0);
}

TEST(Walk, AServerThatCameLaterDoesNotClaimToKnowTheStart) {
  server::Walk walk({});
  TickRecord record = standing(5000, Mode::user);
  record.distance_m = 12.5F;
  walk.take(record);
  const auto told = walk.told();
  EXPECT_TRUE(told["mark"].is_null());
  EXPECT_TRUE(told["motion_s"].is_null());
  EXPECT_TRUE(told["begun"].is_null());
}

class WalkLiveTest : public ServerTest {};

TEST_F(WalkLiveTest, EveryScreenIsToldTheSameExerciseStartAndPath) {
  Live first(port_, bearer_);
  Live second(port_, bearer_);
  const json square{{"shape", "square"}, {"side_m", 3.0}};
  ASSERT_EQ(second.ask({{"type", "choose"}, {"exercise", square}})["ok"], true) << "choosing needs no control";
  const auto chosen = [&](Live& live) { return until([&] { return live.wait("walk")["exercise"] == square; }); };
  EXPECT_TRUE(chosen(first));
  EXPECT_TRUE(chosen(second));
  ASSERT_EQ(first.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(first.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", square}})["ok"], true);
  EXPECT_TRUE(until([&] { return second.wait("walk")["begun"] == square; }));
  const json other = second.ask({{"type", "choose"}, {"exercise", {{"shape", "free"}}}});
  EXPECT_EQ(other["ok"], false) << "not while the hoist is led";
  EXPECT_EQ(other["refusals"][0], "not_standby");
  EXPECT_EQ(other["detail"], "The hoist is not on standby.");
  core_->skip(500);
  // A page that was loaded just now, and a script: the start pose, the time and the path since the mark.
  Live third(port_, bearer_);
  const json told = third.wait("walk");
  EXPECT_EQ(told["exercise"], square);
  EXPECT_EQ(told["begun"], square);
  EXPECT_EQ(told["mark"]["psi_rad"], 0.0);
  EXPECT_NEAR(told["mark"]["x_m"].get<double>(), -1.5, 0.02);
  std::vector<TickRecord> walked;
  for (const TickRecord& record : core_->published())
    if (record.tick <= told["tick"].get<std::uint64_t>()) walked.push_back(record);
  const auto from =
      std::find_if(walked.begin(), walked.end(), [](const TickRecord& r) { return r.mode == static_cast<std::uint8_t>(Mode::user); });
  ASSERT_NE(from, walked.end());
  EXPECT_NEAR(told["motion_s"].get<double>(), static_cast<double>(walked.back().time_ns - from->time_ns) * 1e-9, 1e-6);
  EXPECT_NEAR(told["x_m"].back().get<double>(), walked.back().fused_x_m, 0.021);
  EXPECT_NEAR(told["x_m"].front().get<double>(), told["mark"]["x_m"].get<double>(), 1e-3);
  EXPECT_EQ(get("/api/v1/walk").json()["begun"], square);
}

TEST_F(WalkLiveTest, AnotherPatientBeginsAnewAlsoTheTask) {
  Live screen(port_, bearer_);
  ASSERT_EQ(screen.ask({{"type", "lease_take"}})["ok"], true);
  const json wish{{"task", "straight"}, {"sizes", {{"length_m", 20}}}, {"repetitions", 3}};
  ASSERT_EQ(call("PUT", "/api/v1/task", wish).status, 200);
  const json line = get("/api/v1/walk").json()["exercise"];
  core_->set([](TickRecord& r) { r.standing_still = 0; });
  const auto patient = [&](const char* code) { return call("POST", "/api/v1/patients", {{"code", code}}).json()["id"]; };
  const auto choose = [&](const json& who) { EXPECT_EQ(screen.ask({{"type", "choose_patient"}, {"patient", who}})["ok"], true); };
  // The start mark and the repetition of a walk of half a second.
  const auto walk = [&](const json& start) {
    EXPECT_EQ(screen.ask(start)["ok"], true) << start;
    const json repetition = get("/api/v1/walk").json()["task"]["repetition"];
    core_->skip(50);
    EXPECT_TRUE(until([&] { return get("/api/v1/walk").json()["motion_s"].get<double>() > 0.4; }));
    EXPECT_EQ(screen.ask({{"type", "mode"}, {"mode", "standby"}})["ok"], true);
    EXPECT_TRUE(until([&] { return get("/api/v1/walk").json()["task"]["ended_tick"].is_number() || repetition == 0; }));
    return std::pair(core_->published().back().start_mark, repetition.get<int>());
  };
  const json start{{"type", "mode"}, {"mode", "user"}, {"exercise", line}};
  const json first = patient("P-1"), second = patient("P-2");
  choose(first);
  const auto [mark, repetition] = walk(start);
  EXPECT_EQ(repetition, 1);
  choose(first);
  EXPECT_EQ(walk(start), std::pair(mark, 1)) << "the same patient goes on";
  choose(second);
  const json told = get("/api/v1/walk").json();
  EXPECT_EQ(told["motion_s"], 0.0);
  EXPECT_EQ(told["x_m"].size(), 1U) << "nothing of the path of the one before";
  EXPECT_EQ(told["task"]["repetition"], 0);
  EXPECT_TRUE(told["begun"].is_null());
  EXPECT_EQ(walk(start), std::pair(mark + 1, 1));
  choose(nullptr);
  const json only_moved{{"type", "mode"}, {"mode", "remote"}, {"exercise", nullptr}};
  EXPECT_EQ(walk(only_moved), std::pair(mark + 2, 0)) << "no patient is another one, and moving the hoist is no repetition";
  EXPECT_EQ(walk(only_moved), std::pair(mark + 2, 0));
  const json driven{{"type", "mode"}, {"mode", "remote"}, {"exercise", {{"shape", "free"}}}};
  EXPECT_EQ(walk(driven), std::pair(mark + 3, 0)) << "an exercise begins at its own start mark";
}

TEST_F(WalkLiveTest, ANewStartMarkIsToldToEveryScreen) {
  Live live(port_, bearer_);
  ASSERT_EQ(call("POST", "/api/v1/pose", {{"x_m", 2.0}, {"y_m", -1.0}, {"psi_rad", 0.5}}).status, 200);
  json told;
  ASSERT_TRUE(until([&] { return (told = live.wait("walk"))["mark"].is_object(); }));
  EXPECT_NEAR(told["mark"]["x_m"].get<double>(), 2.0, 0.02);
  EXPECT_EQ(told["motion_s"], 0.0);
}

TEST_F(WalkLiveTest, WhatAnotherCoreWalkedIsForgotten) {
  Live live(port_, bearer_);
  const json square{{"shape", "square"}, {"side_m", 3.0}};
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", square}})["ok"], true);
  EXPECT_TRUE(until([&] { return live.wait("walk")["begun"] == square; }));
  // The next core begins with the same number of the mark, somewhere else.
  core_->set([](TickRecord& r) {
    r.start_mark = 0;
    r.x_m = 7.0F;
  });
  core_->skip(200);
  ASSERT_TRUE(until([&] { return get("/api/v1/walk").json()["motion_s"].get<double>() > 1.9; }));
  core_.reset();
  wait_for_core(false);
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
  EXPECT_TRUE(until([&] { return live.wait("walk").value("begun", json("untold")).is_null(); })) << "every screen is told";
  wait_for_core();
  const json told = get("/api/v1/walk").json();
  EXPECT_TRUE(told["begun"].is_null());
  EXPECT_TRUE(told["mark"].is_null());
  EXPECT_TRUE(told["motion_s"].is_null());
  EXPECT_LT(told["x_m"].front().get<double>(), 7.0);
}

TEST_F(WalkLiveTest, AnyoneEndsAMotionOverBothWays) {
  Live driver(port_, bearer_);
  Live other(port_, bearer_);
  for (const bool rest : {false, true}) {
    ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
    ASSERT_EQ(driver.ask({{"type", "mode"}, {"mode", "user"}})["ok"], true);
    if (rest)
      EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "standby"}}).status, 200) << "no X-Hoist-Lease";
    else
      EXPECT_EQ(other.ask({{"type", "mode"}, {"mode", "standby"}})["ok"], true);
    EXPECT_TRUE(until([&] { return core_->mode() == Mode::standby; }));
  }
  EXPECT_EQ(other.ask({{"type", "mode"}, {"mode", "user"}})["refusals"][0], "no_lease");
}

TEST_F(WalkLiveTest, AChangeOfSettingsForAnotherVersionIsRefused_H27) {
  Live one(port_, bearer_);
  const auto version = one.wait("parameters")["version"].get<std::uint32_t>();
  const auto set = [&](double value, const json& made_for) {
    return one.ask({{"type", "set"}, {"values", {{"lean_gain_filtered_units", value}}}, {"version", made_for}});
  };
  EXPECT_EQ(set(44, version)["ok"], true) << "without control";
  EXPECT_EQ(set(45, version)["refusals"][0], "set_outdated");
  for (const json& wrong : {json(0), json(-1), json(1.5), json("1")}) EXPECT_EQ(set(46, wrong)["errors"][0]["field"], "version") << wrong;
  EXPECT_EQ(get("/api/v1/parameters/lean_gain_filtered_units").json()["value"], 44);
  EXPECT_EQ(one.ask({{"type", "preset"}, {"name", "walk"}, {"version", version}})["refusals"][0], "set_outdated");
}

// Listens at the core's socket, and neither accepts nor answers.
class Mute {
 public:
  explicit Mute(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ::unlink(path.c_str());
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(fd_, 8), 0);
  }
  ~Mute() { ::close(fd_); }
  Mute(const Mute&) = delete;
  Mute& operator=(const Mute&) = delete;

 private:
  int fd_;
};

TEST_F(WalkLiveTest, AScreenIsToldWhyTheCoreIsAway) {
  Live live(port_, bearer_);
  json told = live.wait("core");
  EXPECT_TRUE(told["problem"].is_null());
  EXPECT_TRUE(told["reason_code"].is_null());
  core_.reset();
  EXPECT_TRUE(until([&] { return (told = live.wait("core"))["connected"] == false && told["reason_code"] == "core_absent"; })) << told;
  EXPECT_FALSE(told["problem"].get<std::string>().empty());
  // The reason changes while the core stays away: now a program listens there that gives no reply.
  const Mute mute((folder_ / "core.sock").string());
  EXPECT_TRUE(until([&] { return (told = live.wait("core"))["reason_code"] == "core_silent"; }));
  EXPECT_EQ(told["reason_code"], "core_silent") << told;
  EXPECT_EQ(told["connected"], false);
  EXPECT_EQ(told["problem"], get("/api/v1/status").json()["core"]["problem"]);
}

// One step in which the hoist stands at this place of the floor.
TickRecord at_place(std::uint64_t tick, Mode mode, std::uint32_t mark, double x_m, double psi_rad = 0) {
  TickRecord record = standing(tick, mode);
  record.start_mark = mark;
  record.fused_x_m = static_cast<float>(x_m);
  record.fused_psi_rad = static_cast<float>(psi_rad);
  return record;
}

db::TaskChoice task_choice(const json& wish) {
  std::vector<db::ExerciseProblem> problems;
  const auto choice = db::read_task_choice(wish, problems);
  EXPECT_TRUE(choice) << (problems.empty() ? "" : problems.front().field + ' ' + problems.front().message);
  return choice.value_or(db::TaskChoice{});
}

TEST(TaskRun, ALineEndsWhereItEndsAndEachStartMarkIsARepetition) {
  server::TaskRun run;
  const db::TaskChoice straight = task_choice({{"task", "straight"}, {"sizes", {{"length_m", 2}}}, {"repetitions", 2}});
  run.choose(straight);
  EXPECT_EQ(run.told()["repetition"], 0);
  std::uint64_t tick = 1;
  // From x to x, 1 cm a step. The steps in which the task's end was to be told.
  const auto walk = [&](Mode mode, std::uint32_t mark, double from_m, double to_m) {
    std::vector<double> reached;
    for (double x_m = from_m; x_m <= to_m; x_m += 0.01)
      if (run.take(at_place(tick++, mode, mark, x_m)).reached) reached.push_back(x_m);
    return reached;
  };
  run.take(at_place(tick++, Mode::standby, 1, 0));
  ASSERT_EQ(run.next(straight.exercise, Mode::user)->repetition, 1U);
  EXPECT_FALSE(run.next(contract::usual_exercise(contract::ExerciseShape::circle), Mode::user)) << "another line is no repetition";
  run.begin(run.next(straight.exercise, Mode::user));
  EXPECT_TRUE(walk(Mode::user, 1, 0, 1).empty());
  EXPECT_FALSE(run.told()["reached"].get<bool>());
  // Broken off and gone on with: the same repetition.
  run.take(at_place(tick++, Mode::standby, 1, 1));
  EXPECT_EQ(run.told()["ended_tick"], tick - 1);
  ASSERT_EQ(run.next(straight.exercise, Mode::user)->repetition, 1U);
  run.begin(run.next(straight.exercise, Mode::user));
  const auto reached = walk(Mode::user, 1, 1, 2.2);
  ASSERT_EQ(reached.size(), 1U) << "told once";
  EXPECT_NEAR(reached.front(), 2.0, 0.03);
  run.take(at_place(tick++, Mode::standby, 1, 2.2));
  EXPECT_TRUE(run.told()["reached"].get<bool>());
  EXPECT_EQ(run.told()["ended_tick"], tick - 1) << "the rest is counted from here";
  // A new mark: the next one, which GUIDED ends by itself.
  run.take(at_place(tick++, Mode::standby, 2, 0));
  ASSERT_EQ(run.next(straight.exercise, Mode::guided)->repetition, 2U);
  run.begin(run.next(straight.exercise, Mode::guided));
  EXPECT_FALSE(run.told()["reached"].get<bool>());
  EXPECT_TRUE(run.told()["ended_tick"].is_null());
  EXPECT_TRUE(walk(Mode::guided, 2, 0, 2.2).empty());
  EXPECT_TRUE(run.told()["reached"].get<bool>());
  run.choose(std::nullopt);
  EXPECT_TRUE(run.told().is_null());
}

TEST(TaskRun, ARepetitionInWhichNothingMovedIsNotUsedUp) {
  server::TaskRun run;
  const db::TaskChoice straight = task_choice({{"task", "straight"}, {"sizes", {{"length_m", 2}}}, {"repetitions", 3}});
  run.choose(straight);
  std::uint64_t tick = 1;
  // Begins and ends at this start mark, at standstill or not; the repetition that it was.
  const auto walk = [&](Mode mode, std::uint32_t mark, bool moves) {
    run.take(at_place(tick++, Mode::standby, mark, 0));
    run.begin(run.next(straight.exercise, mode));
    TickRecord record = at_place(tick++, mode, mark, 0);
    record.standing_still = moves ? 0 : 1;
    run.take(record);
    run.take(at_place(tick++, Mode::standby, mark, 0));
    return run.told()["repetition"].get<int>();
  };
  EXPECT_EQ(walk(Mode::guided, 1, false), 1);
  EXPECT_EQ(walk(Mode::user, 2, false), 1) << "who leads has changed";
  EXPECT_EQ(walk(Mode::user, 3, true), 1);
  EXPECT_EQ(walk(Mode::user, 4, true), 2);
}

TEST(TaskRun, TimeCountsFromTheFirstMovementAndATurnToEitherSide) {
  server::TaskRun run;
  const db::TaskChoice minutes = task_choice({{"task", "walk_2min"}, {"goal", 30}});
  run.choose(minutes);
  run.take(at_place(1, Mode::standby, 1, 0));
  run.begin(run.next(minutes.exercise, Mode::user));
  std::uint64_t tick = 2, reached = 0;
  for (; tick < 500; ++tick) {
    TickRecord still = at_place(tick, Mode::user, 1, 0);
    still.standing_still = 1;
    run.take(still);
  }
  for (; tick < 4000 && reached == 0; ++tick)
    if (run.take(at_place(tick, Mode::user, 1, 0.01 * static_cast<double>(tick - 500))).reached) reached = tick;
  EXPECT_EQ(reached, 500U + 3000U);
  const db::TaskChoice turn = task_choice({{"task", "turn_180"}});
  run.choose(turn);
  EXPECT_FALSE(run.next(turn.exercise, Mode::guided)) << "nothing that the hoist could lead";
  run.begin(run.next(turn.exercise, Mode::remote));
  double ended_rad = 0;
  // Over the jump of a wrapped heading, to the right.
  for (double turned = 0; turned < 3.4 && ended_rad == 0; turned += 0.01)
    if (run.take(at_place(tick++, Mode::remote, 1, 0, std::remainder(-3.0 - turned, 6.283185307179586))).reached) ended_rad = turned;
  EXPECT_NEAR(ended_rad, 3.14159, 0.02);
  // There and back: being near the start again counts only after having been away.
  const db::TaskChoice there = task_choice({{"task", "up_and_go"}, {"goal", 2}});
  run.choose(there);
  run.begin(run.next(there.exercise, Mode::user));
  std::vector<double> back;
  for (double way_m = 0; way_m < 4.5; way_m += 0.01) {
    const double x_m = way_m < 2.1 ? way_m : 4.2 - way_m;
    if (run.take(at_place(tick++, Mode::user, 1, x_m)).reached) back.push_back(x_m);
  }
  ASSERT_EQ(back.size(), 1U);
  EXPECT_NEAR(back.front(), db::kTaskBack_m, 0.02);
}

TEST_F(WalkLiveTest, ATaskIsChosenForAllScreensEndsItsMotionAndIsRecorded) {
  Live live(port_, bearer_);
  const json listed = get("/api/v1/tasks").json()["items"];
  ASSERT_GE(listed.size(), 11U);
  EXPECT_EQ(listed[0]["name"], "walk_10m");
  const json wish{{"task", "straight"}, {"sizes", {{"length_m", 1}}}, {"repetitions", 3}};
  ASSERT_EQ(call("PUT", "/api/v1/task", wish).status, 200);
  const json line{{"shape", "straight"}, {"length_m", 1.0}};
  json told;
  ASSERT_TRUE(until([&] { return (told = live.wait("walk"))["task"].is_object(); }));
  EXPECT_EQ(told["exercise"], line);
  EXPECT_EQ(told["task"]["repetitions"], 3);
  core_->set([](TickRecord& r) { r.standing_still = 0; });
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", line}})["ok"], true);
  ASSERT_TRUE(until([&] { return live.wait("walk")["task"]["repetition"] == 1; }));
  EXPECT_EQ(call("PUT", "/api/v1/task", wish).status, 409) << "not while the hoist moves";
  ASSERT_TRUE(until([&] { return get("/api/v1/recording").json()["state"] == "recording"; }))
      << "else the walk is over before it is recorded";
  core_->skip(1050);
  EXPECT_TRUE(until([&] { return core_->mode() == Mode::standby; })) << "the end of the line ends the motion";
  EXPECT_TRUE(until([&] {
    const json task = get("/api/v1/walk").json()["task"];
    return task["reached"] == true && task["ended_tick"].is_number();
  }));
  core_->skip(400);
  json session;
  const auto is_recorded = [&] {
    const json listed_now = get("/api/v1/sessions").json();
    for (const json& one : listed_now["items"])
      if (one["recording"] == false && one["task"].is_object()) session = one;
    return session.is_object();
  };
  ASSERT_TRUE(until(is_recorded)) << get("/api/v1/sessions").json();
  EXPECT_EQ(session["exercise"], line);
  EXPECT_EQ(session["task"], (json{{"task", "straight"},
                                   {"version", 1},
                                   {"ends", "distance"},
                                   {"goal", 1.0},
                                   {"edge_m", 0.0},
                                   {"repetition", 1},
                                   {"repetitions", 3},
                                   {"rest_s", 60.0}}));
  // A start after the end is the next repetition, from its start mark; a screen need not say so.
  const auto mark = core_->published().back().start_mark;
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", line}})["ok"], true);
  EXPECT_TRUE(until([&] { return get("/api/v1/walk").json()["task"]["repetition"] == 2; }));
  EXPECT_EQ(core_->published().back().start_mark, mark + 1);
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "standby"}})["ok"], true);
  // Another exercise is no repetition of it.
  ASSERT_EQ(call("PUT", "/api/v1/exercise", {{"shape", "circle"}, {"radius_m", 2.0}}).status, 200);
  EXPECT_TRUE(get("/api/v1/walk").json()["task"].is_null());
}

TEST_F(WalkLiveTest, AWrongTaskNamesItsFieldAndChangesNothing) {
  const json before = get("/api/v1/walk").json()["exercise"];
  const auto refused = [&](const json& wish, std::string_view field) {
    const Answer answer = call("PUT", "/api/v1/task", wish);
    EXPECT_EQ(answer.status, 422) << wish;
    EXPECT_EQ(answer.json()["errors"][0]["field"], field) << wish;
    return answer.json()["errors"][0];
  };
  refused({{"task", "sit_stand"}}, "task");
  const json size = refused({{"task", "walk_10m"}, {"sizes", {{"length_m", 25}}}}, "sizes.length_m");
  EXPECT_EQ(size["min"], 6.0);
  EXPECT_EQ(size["max"], 24.0);
  refused({{"task", "walk_10m"}, {"sizes", {{"radius_m", 1}}}}, "sizes");
  refused({{"task", "walk_10m"}, {"clockwise", true}}, "clockwise");
  refused({{"task", "eight"}, {"goal", 1.5}}, "goal");
  refused({{"task", "turn_180"}, {"goal", 1}}, "goal");
  refused({{"task", "circle"}, {"repetitions", 0}}, "repetitions");
  refused({{"task", "circle"}, {"rest_s", 601}}, "rest_s");
  EXPECT_EQ(get("/api/v1/walk").json()["exercise"], before);
  EXPECT_TRUE(get("/api/v1/walk").json()["task"].is_null());
  ASSERT_EQ(call("PUT", "/api/v1/task", {{"task", "eight"}, {"sizes", {{"c_m", 2}}}}).status, 200);
  EXPECT_EQ(get("/api/v1/walk").json()["exercise"]["radius_m"], 1.6) << "the loops keep their proportion";
  ASSERT_EQ(call("PUT", "/api/v1/task", {{"task", nullptr}}).status, 200);
  EXPECT_TRUE(get("/api/v1/walk").json()["task"].is_null());
}

TEST_F(WalkLiveTest, AWrongChoiceNamesItsFieldAndChangesNothing) {
  Live live(port_, bearer_);
  const json before = get("/api/v1/walk").json()["exercise"];
  const json refused = live.ask({{"type", "choose"}, {"exercise", {{"shape", "square"}, {"side_m", 1000}}}});
  EXPECT_EQ(refused["errors"][0]["field"], "exercise.side_m");
  EXPECT_EQ(refused["errors"][0]["max"], 100.0);
  EXPECT_EQ(refused["reason_code"], "exercise");
  EXPECT_EQ(live.ask({{"type", "marker"}, {"text", "help"}})["reason_code"], "not_recording");
  EXPECT_EQ(live.ask({{"type", "marker"}, {"text", 7}})["reason_code"], "message");
  EXPECT_EQ(call("PUT", "/api/v1/exercise", {{"shape", "spiral"}}).status, 422);
  EXPECT_EQ(get("/api/v1/walk").json()["exercise"], before);
  EXPECT_EQ(call("PUT", "/api/v1/exercise", {{"shape", "circle"}, {"radius_m", 2.0}}).status, 200);
  EXPECT_EQ(get("/api/v1/walk").json()["exercise"], (json{{"shape", "circle"}, {"radius_m", 2.0}}));
}

}  // namespace
}  // namespace hoist::test
