// Start marks: when the track restarts and when it continues, with interrupted exercises and missed steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include "control/core/estimate/estimate.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::GuidedPath;
using contract::GuidedShape;

constexpr std::uint32_t kEight = 77, kSquare = 78;

std::uint32_t mark(ScriptedHoist& hoist, std::uint32_t exercise, std::uint32_t again = 0, double psi_rad = 0.5) {
  return hoist.ask(CommandKind::set_pose, 7, exercise, again, 1.0, 2.0, psi_rad);
}
void acknowledge(ScriptedHoist& hoist) {
  ASSERT_TRUE(hoist.reach(Mode::protective_stop));
  hoist.step(200);
  ASSERT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  hoist.step(120);
}

TEST(StartMark, TheSameExerciseGoesOnWhereTheHoistIsAfterAStop) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(mark(hoist, kEight), 0U);
  EXPECT_EQ(hoist.out.record.start_mark, 1U);
  ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  hoist.lean_gently(5, 300);
  hoist.lean(0);
  hoist.ask(CommandKind::stop);
  acknowledge(hoist);
  const double x_m = hoist.out.record.x_m, distance_m = hoist.out.record.distance_m;
  ASSERT_GT(distance_m, 0.3);
  ASSERT_EQ(mark(hoist, kEight), 0U);
  EXPECT_EQ(hoist.out.record.x_m, x_m);
  EXPECT_EQ(hoist.out.record.distance_m, distance_m);
  EXPECT_EQ(hoist.out.record.start_mark, 1U);
  EXPECT_EQ(hoist.count(contract::EventKind::pose_set), 1);
  // Another exercise, and the same one started again, get a new mark.
  ASSERT_EQ(mark(hoist, kSquare), 0U);
  EXPECT_EQ(hoist.out.record.start_mark, 2U);
  EXPECT_NEAR(hoist.out.record.x_m, 1.0, 1e-6);
  EXPECT_EQ(hoist.out.record.distance_m, 0);
  ASSERT_EQ(mark(hoist, kSquare, contract::kStartAgain, 0.7), 0U);
  EXPECT_EQ(hoist.out.record.start_mark, 3U);
  EXPECT_NEAR(hoist.out.record.psi_rad, 0.7, 1e-6);
  // A pose without an exercise is a mark that no exercise continues from.
  ASSERT_EQ(mark(hoist, 0), 0U);
  ASSERT_EQ(mark(hoist, 0), 0U);
  EXPECT_EQ(hoist.out.record.start_mark, 5U);
}

TEST(StartMark, WhatADriveDidNotCountEndsIt) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(mark(hoist, kEight), 0U);
  hoist.drive_left.booted = false;  // power-cycled: its counter restarts
  hoist.step(2);
  EXPECT_EQ(hoist.state.start.exercise, 0U);
}

constexpr GuidedPath kWay{GuidedShape::straight, false, 2.0, 0, 0.3, 1};

/// Drives about half of kWay, then breaks it off by STOP and acknowledges.
void break_off(ScriptedHoist& hoist) {
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(mark(hoist, kEight), 0U);
  ASSERT_EQ(hoist.ask_guided(kWay), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  hoist.drive_for(400, 0);
  hoist.ask(CommandKind::stop);
  hoist.hold(0, 0, false);
  acknowledge(hoist);
}

TEST(StartMark, AGuidedExerciseThatWasBrokenOffGoesOnAndAFinishedOneBeginsAgain) {
  ScriptedHoist hoist;
  ASSERT_NO_FATAL_FAILURE(break_off(hoist));
  const double done_norm = hoist.out.record.guided_progress_norm;
  ASSERT_GT(done_norm, 0.3);
  ASSERT_EQ(mark(hoist, kEight), 0U);
  GuidedPath slower = kWay;
  slower.speed_m_s = 0.2;
  ASSERT_EQ(hoist.ask_guided(slower), 0U);
  EXPECT_GE(hoist.out.record.guided_progress_norm, done_norm);
  EXPECT_EQ(hoist.out.record.guided_end, 0);
  ASSERT_TRUE(hoist.run_until_powered());
  float fastest_m_s = 0;
  for (int i = 0; i < 3000 && hoist.state.mode == Mode::guided; ++i) {
    hoist.drive_for(1, 0);
    fastest_m_s = std::max(fastest_m_s, hoist.out.record.speed_wish_m_s);
  }
  EXPECT_NEAR(fastest_m_s, slower.speed_m_s, 0.01) << "with the speed that was wished last";
  // Two metres from the mark, not from the place of continuation.
  EXPECT_NEAR(std::hypot(hoist.out.record.x_m - 1.0, hoist.out.record.y_m - 2.0), 2.0, 0.03);
  EXPECT_EQ(hoist.out.record.guided_progress_norm, 1.0F);
  hoist.hold(0, 0, false);
  hoist.step(120);
  ASSERT_EQ(hoist.ask_guided(kWay), 0U);
  EXPECT_NEAR(hoist.out.record.guided_progress_norm, 0.0, 0.01) << "also without a new mark";
  ASSERT_EQ(hoist.ask_mode(Mode::standby), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  hoist.step(120);
  ASSERT_EQ(mark(hoist, kEight), 0U);
  EXPECT_EQ(hoist.out.record.start_mark, 2U) << "nothing was left to go on with";
  ASSERT_EQ(hoist.ask_guided(kWay), 0U);
  EXPECT_NEAR(hoist.out.record.guided_progress_norm, 0.0, 0.01);
}

TEST(StartMark, ABrokenOffExerciseGoesOnAsTheSameFigureOnTheSameMarkOnly) {
  constexpr GuidedPath kLonger{GuidedShape::straight, false, 3.0, 0, 0.3, 1};
  struct Case {
    const char* what;
    std::uint32_t again;
    GuidedPath path;
    bool goes_on;
  };
  for (const Case& one :
       {Case{"the same", 0, kWay, true}, Case{"a new mark", contract::kStartAgain, kWay, false}, Case{"a longer way", 0, kLonger, false}}) {
    ScriptedHoist hoist;
    ASSERT_NO_FATAL_FAILURE(break_off(hoist));
    ASSERT_EQ(mark(hoist, kEight, one.again), 0U);
    ASSERT_EQ(hoist.ask_guided(one.path), 0U);
    EXPECT_EQ(hoist.out.record.guided_progress_norm > 0.3F, one.goes_on) << one.what;
  }
}

TEST(StartMark, ASquareBrokenOffInACornerGoesOnTurning) {
  constexpr GuidedPath kCorners{GuidedShape::square, false, 0.6, 0, 0.3, 1};
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(mark(hoist, kSquare, 0, 0.0), 0U);
  ASSERT_EQ(hoist.ask_guided(kCorners), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  for (int i = 0; i < 1500 && hoist.out.record.psi_rad < 1.2F; ++i) hoist.drive_for(1, 0);
  ASSERT_GE(hoist.out.record.psi_rad, 1.2F);
  hoist.ask(CommandKind::stop);
  hoist.hold(0, 0, false);
  acknowledge(hoist);
  ASSERT_EQ(mark(hoist, kSquare, 0, 0.0), 0U);
  ASSERT_EQ(hoist.ask_guided(kCorners), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  for (int i = 0; i < 4000 && hoist.state.mode == Mode::guided; ++i) hoist.drive_for(1, 0);
  EXPECT_EQ(hoist.out.record.guided_progress_norm, 1.0F);
  EXPECT_NEAR(hoist.out.record.x_m, 1.0, 0.04);
  EXPECT_NEAR(hoist.out.record.y_m, 2.0, 0.04);
}

// The core is suspended for n steps, which it leaves out; the wheels continue. The next data was sampled at the previous SYNC.
void leave_out(ScriptedHoist& hoist, int n) {
  hoist.extra = hoist.collect();
  for (FakeDrive* drive : {&hoist.drive_left, &hoist.drive_right})
    drive->counts += drive->wheel_m_s * 0.01 * n / (0.2 * std::numbers::pi) * 60000.0;
  hoist.tick_number += static_cast<std::uint64_t>(n);
  hoist.time_ns += static_cast<std::uint64_t>(n) * 10'000'000;
  const auto silence = [&hoist](bool on) {
    for (FakeNode* node : std::initializer_list<FakeNode*>{&hoist.tilt_left, &hoist.tilt_right, &hoist.tilt_base, &hoist.drive_left,
                                                           &hoist.drive_right, &hoist.io})
      node->silent = on;
  };
  silence(true);
  hoist.drive_for(1, 0.4, 0.4);
  silence(false);
}

// The nodes sample at SYNC, so what comes one step after the gap has turned for the whole gap.
TEST(LeftOutSteps, EveryRateIsOverTheTimeThatPassed) {
  for (const int left_out : {1, 3, 8, 30}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(mark(hoist, kEight), 0U);
    ASSERT_EQ(hoist.ask_mode(Mode::remote), 0U);
    ASSERT_TRUE(hoist.run_until_powered());
    hoist.drive_for(300, 0.4, 0.4);
    const double speed_m_s = hoist.out.record.speed_m_s, yaw_rate_rad_s = hoist.out.record.yaw_rate_rad_s;
    ASSERT_GT(speed_m_s, 0.1);
    ASSERT_GT(yaw_rate_rad_s, 0.1);
    hoist.drive_left.forced_m_s = hoist.drive_left.wheel_m_s;
    hoist.drive_right.forced_m_s = hoist.drive_right.wheel_m_s;
    leave_out(hoist, left_out);
    for (int i = 0; i < 4; ++i) {
      if (i > 0) hoist.drive_for(1, 0.4, 0.4);
      EXPECT_NEAR(hoist.out.record.speed_m_s, speed_m_s, 0.05 * speed_m_s) << left_out << " left out, step " << i;
      EXPECT_NEAR(hoist.out.record.yaw_rate_rad_s, yaw_rate_rad_s, 0.05 * yaw_rate_rad_s) << left_out << " left out, step " << i;
      EXPECT_EQ(hoist.out.record.slip_state & 1, 0) << "the wheels grip: " << left_out << " left out, step " << i;
    }
    EXPECT_FALSE(hoist.has_fault(contract::Fault::overspeed));
  }
}

}  // namespace
}  // namespace hoist::core::test
