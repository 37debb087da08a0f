// What every screen is told of the walk: the exercise, the start mark, the time in motion and the path.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmath>

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
      EXPECT_EQ(walk.take(record), record.tick == 1);
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
  EXPECT_TRUE(walk.take(record));
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
