// GUIDED: who may begin it and how, hold-to-run, what ends it, and the figures' limits (hazards H17 to H21, table 2.3).
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "control/contract/guided_path.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::GuidedEnd;
using contract::GuidedField;
using contract::GuidedPath;
using contract::GuidedShape;

constexpr GuidedPath kLong{GuidedShape::straight, false, 10.0, 0, 0.3, 1};

/// In GUIDED, drives on, the hand not yet on the button.
ScriptedHoist begun(const GuidedPath& path = kLong, const contract::Params& params = {}) {
  ScriptedHoist hoist(params);
  EXPECT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.ask_guided(path), 0U);
  EXPECT_TRUE(hoist.run_until_powered());
  return hoist;
}
void hold_for(ScriptedHoist& hoist, int n) { hoist.drive_for(n, 0, 0); }
GuidedEnd told_end(const ScriptedHoist& hoist) {
  for (const contract::Event& e : hoist.events)
    if (e.kind == EventKind::guided_ended) return static_cast<GuidedEnd>(e.code);
  return GuidedEnd::none;
}

TEST(Guided, NothingMovesBeforeTheHandHolds) {
  ScriptedHoist hoist = begun();
  hoist.step(300);
  EXPECT_EQ(hoist.state.mode, Mode::guided);
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_EQ(hoist.out.record.distance_m, 0);
  hold_for(hoist, 200);
  EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
}

TEST(Guided, LettingGoStopsAndStaysAndHoldingGoesOn) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 300);
  ASSERT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
  hoist.worst_deceleration_m_s2 = 0;
  hoist.hold(0, 0, false);
  hoist.step(60);  // 0.3 m/s at 0.8 m/s2
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_NEAR(hoist.worst_deceleration_m_s2, kRemoteDeceleration_m_s2, 1e-6);
  hoist.step(1000);
  EXPECT_EQ(hoist.state.mode, Mode::guided) << "silence with the button let go is no loss";
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_FALSE(hoist.has_fault(Fault::remote_command_lost));
  const auto done = hoist.out.record.guided_progress_norm;
  hold_for(hoist, 20);
  EXPECT_LT(hoist.command_m_s(), 0.12) << "again with the normal ramp";
  hold_for(hoist, 200);
  EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
  EXPECT_GT(hoist.out.record.guided_progress_norm, done) << "from where it was";
}

TEST(Guided, TheStickIsNotLookedAtExceptThatItMustBeginInTheMiddle) {
  ScriptedHoist hoist = begun();
  hoist.drive_for(100, 0.0, 0.0);
  hoist.drive_for(100, -1.0, 1.0);
  EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3) << "a stick that wanders neither turns nor stops it";
  EXPECT_LT(std::fabs(hoist.out.record.yaw_rate_command_rad_s), 0.01F);
}

TEST(Guided, H17AgeSlowsThenStopsAndEnds) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 401);
  const double cruise = hoist.command_m_s();
  ASSERT_NEAR(cruise, 0.30, 1e-3);
  // The command has seen the record of the step before it: it is one step old when it is taken.
  for (int i = 2; i <= 15; ++i) {
    hoist.step();
    EXPECT_NEAR(hoist.command_m_s(), cruise, 1e-4) << "up to 150 ms nothing changes: " << i;
  }
  for (int i = 16; i < 25; ++i) hoist.step();
  EXPECT_LT(hoist.command_m_s(), cruise);
  hoist.step(2);
  EXPECT_TRUE(hoist.has_fault(Fault::remote_command_lost)) << "270 ms after the last command";
  EXPECT_EQ(hoist.state.in_mode.braking, Braking::remote);
  EXPECT_TRUE(hoist.reach(Mode::standby, 100));
  EXPECT_EQ(told_end(hoist), GuidedEnd::commands_lost);
  // Returning commands move nothing.
  hold_for(hoist, 100);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(hoist.command_m_s(), 0);
}

TEST(Guided, H18OldCommandsDoNotHold) {
  ScriptedHoist hoist = begun();
  for (int i = 0; i < 100; ++i) {
    hoist.hold(0, 0);
    hoist.drive_command.echo_time_ns = hoist.time_ns - 270'000'000;
    hoist.step();
    ASSERT_EQ(hoist.command_m_s(), 0);
  }
}

TEST(Guided, H20OnlyTheDriversHandCounts) {
  ScriptedHoist hoist = begun();
  for (int i = 0; i < 100; ++i) {
    hoist.hold(0, 0);
    hoist.drive_command.client = 8;
    hoist.step();
    ASSERT_EQ(hoist.command_m_s(), 0);
  }
  ScriptedHoist other = begun();
  hold_for(other, 200);
  EXPECT_EQ(other.ask(CommandKind::take_lease, 8, 1), refusal_bit(Refusal::moving));
  EXPECT_EQ(other.ask(CommandKind::release_lease), 0U);
  EXPECT_TRUE(other.reach(Mode::standby, 100));
  EXPECT_EQ(told_end(other), GuidedEnd::driver_gone);
}

TEST(Guided, H21ServerLostEndsIt) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 200);
  hoist.server_up = false;
  int steps = 0;
  for (; !hoist.state.in_mode.leaving && steps < 100; ++steps) hold_for(hoist, 1);
  EXPECT_LE(steps, 27);
  EXPECT_TRUE(hoist.reach(Mode::standby, 100));
}

TEST(Guided, TheButtonIsPressedAnewForEveryExercise) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hold_for(hoist, 8);
  EXPECT_EQ(hoist.ask_guided(kLong), refusal_bit(Refusal::release_first));
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  hoist.hold(0, 0, false);
  hoist.step(2);
  EXPECT_EQ(hoist.ask_guided(kLong), 0U);
}

TEST(Guided, AsksForEverythingThatAnyMotionAsksFor) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.lean(4);
  hoist.io.bumpers = 0;
  hoist.step(20);
  EXPECT_EQ(hoist.ask_guided(kLong), refusal_bit(Refusal::not_neutral));
  // All reasons together, also those of the exercise and of the client.
  GuidedPath bad = kLong;
  bad.speed_m_s = 5;
  const std::uint32_t bits = hoist.ask_guided(bad, 8);
  for (const Refusal reason : {Refusal::not_neutral, Refusal::no_lease, Refusal::exercise_limits, Refusal::out_of_range})
    EXPECT_NE(bits & refusal_bit(reason), 0U) << static_cast<int>(reason);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

TEST(Guided, WithoutAnExerciseThereIsNoGuided) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.ask(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::guided)), refusal_bit(Refusal::no_exercise));
  // One that was refused, or is over, is not begun later by the bare request.
  GuidedPath bad = kLong;
  bad.laps = 0;
  EXPECT_NE(hoist.ask_guided(bad), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::guided)), refusal_bit(Refusal::no_exercise));
  EXPECT_EQ(hoist.ask_guided(kLong), 0U);
  EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  EXPECT_EQ(told_end(hoist), GuidedEnd::asked);
  EXPECT_EQ(hoist.ask(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::guided)), refusal_bit(Refusal::no_exercise));
}

TEST(Guided, AnotherExerciseDoesNotReplaceTheOneThatRuns) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 200);
  EXPECT_NE(hoist.ask_guided({GuidedShape::circle, false, 0.5, 0, 0.3, 1}) & refusal_bit(Refusal::not_standby), 0U);
  EXPECT_NE(hoist.ask(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::user)) & refusal_bit(Refusal::not_standby), 0U);
  hold_for(hoist, 100);
  EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
  EXPECT_LT(std::fabs(hoist.out.record.yaw_rate_command_rad_s), 0.01F);
}

TEST(Guided, ThePoseStaysPutWhileAnExerciseLiesOnTheFloor) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 100);
  hoist.hold(0, 0, false);
  hoist.step(100);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 5.0, 5.0, 1.0), refusal_bit(Refusal::not_standby));
}

TEST(Guided, ItBeginsWhereTheHoistStands) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 3.0, -2.0, 2.5), 0U);
  ASSERT_EQ(hoist.ask_guided({GuidedShape::straight, false, 1.0, 0, 0.3, 1}), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  for (int i = 0; i < 1500 && hoist.state.mode == Mode::guided; ++i) hold_for(hoist, 1);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(told_end(hoist), GuidedEnd::finished);
  EXPECT_NEAR(hoist.out.record.x_m, 3.0 + std::cos(2.5), 0.03);
  EXPECT_NEAR(hoist.out.record.y_m, -2.0 + std::sin(2.5), 0.03);
  EXPECT_NEAR(hoist.out.record.psi_rad, 2.5, 0.035);
  EXPECT_EQ(hoist.out.record.guided_progress_norm, 1.0F);
}

/// The struts move there at 10 degrees a second, below the fall monitor's rate, while hold-to-run is held.
void lean_held(ScriptedHoist& hoist, double lean_deg, double twist_deg, int n) {
  hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 0.1;
  hoist.lean(lean_deg, twist_deg);
  hold_for(hoist, n);
}
GuidedPhase told_phase(const ScriptedHoist& hoist) { return static_cast<GuidedPhase>(hoist.out.record.guided_phase); }
contract::SpeedCause cause(const ScriptedHoist& hoist) { return static_cast<contract::SpeedCause>(hoist.out.record.speed_cause); }

// H16. From 2.5 degrees of lag slower, from 9 not at all.
TEST(Guided, H16APatientWhoLagsIsWaitedFor) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 200);
  for (const double lean_deg : {-2.4, 8.0}) {
    lean_held(hoist, lean_deg, 0, 150);
    EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3) << lean_deg;
    EXPECT_EQ(told_phase(hoist), GuidedPhase::following);
    EXPECT_EQ(cause(hoist), contract::SpeedCause::none);
  }
  lean_held(hoist, -4.0, 0, 200);
  EXPECT_NEAR(hoist.command_m_s(), 0.3 * 5.0 / 6.5, 0.005);
  EXPECT_EQ(told_phase(hoist), GuidedPhase::following) << "a little slower is no waiting";
  EXPECT_EQ(cause(hoist), contract::SpeedCause::patient_lag);
  lean_held(hoist, -7.0, 0, 150);
  EXPECT_NEAR(hoist.command_m_s(), 0.3 * 2.0 / 6.5, 0.005);
  EXPECT_EQ(told_phase(hoist), GuidedPhase::for_patient);
  // Shorter than what the hanging alarm allows, whenever the last step was.
  lean_held(hoist, -9.5, 0, 100);
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_EQ(told_phase(hoist), GuidedPhase::for_patient);
  lean_held(hoist, 0, 0, 150);
  EXPECT_EQ(told_phase(hoist), GuidedPhase::for_patient) << "goes on slowly";
  hold_for(hoist, 300);
  EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
  EXPECT_EQ(told_phase(hoist), GuidedPhase::following);
  EXPECT_EQ(hoist.state.latched, 0U);

  // Measured from where this patient stands upright.
  contract::Params back;
  back.neutral_lean_m = -0.02;
  ScriptedHoist other = begun(kLong, back);
  hold_for(other, 100);
  lean_held(other, -3.5, 0, 150);
  EXPECT_NEAR(other.command_m_s(), 0.3, 1e-3);
}

TEST(Guided, H16ATurnOnTheSpotSlowsForAPelvisThatLagsBehindIt) {
  for (const bool clockwise : {false, true})
    for (const bool lags : {true, false}) {
      SCOPED_TRACE(testing::Message() << (clockwise ? "right" : "left") << (lags ? ", lags" : ", leads"));
      ScriptedHoist hoist = begun({GuidedShape::square, clockwise, 0.6, 0, 0.3, 1});
      const auto turns = [&hoist] { return told_phase(hoist) == GuidedPhase::turning; };
      for (int i = 0; i < 1000 && !turns(); ++i) hold_for(hoist, 1);
      ASSERT_TRUE(turns());
      const double behind = clockwise ? 1.0 : -1.0;
      lean_held(hoist, 0, lags ? behind * 14 : -behind * 14, 110);
      const double rate_rad_s = std::fabs(static_cast<double>(hoist.out.record.yaw_rate_command_rad_s));
      EXPECT_NEAR(rate_rad_s, 0.8 * 0.523598776 * (lags ? 2.0 / 6.5 : 1.0), 0.01);
      EXPECT_EQ(told_phase(hoist), lags ? GuidedPhase::for_patient : GuidedPhase::turning);
      if (!lags) continue;
      lean_held(hoist, 0, behind * 19, 100);
      EXPECT_NEAR(std::fabs(static_cast<double>(hoist.out.record.yaw_rate_command_rad_s)), 0.05, 0.001) << "it creeps on";
    }
}

TEST(Guided, AHoistThatIsPulledOffItsLineStopsSoftly) {
  contract::Params narrow;
  narrow.guided_deviation_m_max = 0.1;
  ScriptedHoist hoist = begun(kLong, narrow);
  hold_for(hoist, 300);
  // Something turns the hoist away: more than the law can correct within 10 cm, less than the overspeed monitor's limit.
  hoist.worst_deceleration_m_s2 = 0;
  bool left = false;
  for (int i = 0; i < 1500 && !left; ++i) {
    hoist.drive_left.forced_m_s = hoist.drive_left.target_m_s - 0.12;
    hoist.drive_right.forced_m_s = hoist.drive_right.target_m_s + 0.12;
    hold_for(hoist, 1);
    left = hoist.state.in_mode.leaving;
  }
  EXPECT_TRUE(left);
  EXPECT_EQ(hoist.state.mode, Mode::guided);
  EXPECT_EQ(hoist.state.in_mode.braking, Braking::soft);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = NAN;
  for (int i = 0; i < 200 && hoist.state.mode == Mode::guided; ++i) hold_for(hoist, 1);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(told_end(hoist), GuidedEnd::off_path);
  EXPECT_LE(hoist.worst_deceleration_m_s2, kSoftDeceleration_m_s2 + 1e-9);
}

TEST(Guided, H13ABumperStopsItAsItStopsEverything) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 300);
  hoist.io.bumpers = 1;
  hold_for(hoist, 3);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.state.in_mode.braking, Braking::bumper);
  EXPECT_EQ(told_end(hoist), GuidedEnd::stopped);
}

TEST(Guided, H15AFallStopsIt) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 300);
  hoist.lean(14);
  hold_for(hoist, 40);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
}

TEST(Guided, H4ALostStrutSensorStopsIt) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 300);
  hoist.tilt_left.silent = true;
  hold_for(hoist, 7);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

TEST(Guided, ALeaningPatientDoesNotChangeTheSpeed) {
  ScriptedHoist hoist = begun();
  hold_for(hoist, 300);
  for (int i = 0; i < 200; ++i) {
    hoist.lean(i * 0.03);
    hold_for(hoist, 1);
    EXPECT_NEAR(hoist.command_m_s(), 0.3, 1e-3);
  }
  EXPECT_GT(hoist.out.record.lean_norm, 0.3F) << "but it is shown";
}

// Each field of an exercise, one wrong at a time.
TEST(Guided, EveryFieldIsHeldAgainstItsRange) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    const char* name;
    GuidedPath path;
    GuidedField field;
  };
  const Case cases[] = {
      {"no such shape", {static_cast<GuidedShape>(7), false, 2, 0, 0.3, 1}, GuidedField::shape},
      {"an own line, which no command carries", {GuidedShape::own, false, 0, 0.5, 0.3, 1}, GuidedField::shape},
      {"shape zero", {static_cast<GuidedShape>(0), false, 2, 0, 0.3, 1}, GuidedField::shape},
      {"too short", {GuidedShape::straight, false, 0.4, 0, 0.3, 1}, GuidedField::size},
      {"size no number", {GuidedShape::square, false, kNan, 0, 0.3, 1}, GuidedField::size},
      {"size infinite", {GuidedShape::circle, false, HUGE_VAL, 0, 0.3, 1}, GuidedField::size},
      {"straight with a radius", {GuidedShape::straight, false, 2, 1, 0.3, 1}, GuidedField::radius},
      {"corners wider than the square", {GuidedShape::square, false, 2, 1.1, 0.3, 1}, GuidedField::radius},
      {"corners no number", {GuidedShape::square, false, 2, kNan, 0.3, 1}, GuidedField::radius},
      {"loops that overlap", {GuidedShape::eight, false, 0.8, 0.9, 0.3, 1}, GuidedField::radius},
      {"too fast", {GuidedShape::circle, false, 1, 0, 0.66, 1}, GuidedField::speed},
      {"speed no number", {GuidedShape::circle, false, 1, 0, kNan, 1}, GuidedField::speed},
      {"backward", {GuidedShape::straight, false, 2, 0, -0.3, 1}, GuidedField::speed},
      {"no lap", {GuidedShape::circle, false, 1, 0, 0.3, 0}, GuidedField::laps},
      {"straight twice", {GuidedShape::straight, false, 2, 0, 0.3, 2}, GuidedField::laps},
      {"too many laps", {GuidedShape::circle, false, 0.5, 0, 0.3, 51}, GuidedField::laps},
      {"too long altogether", {GuidedShape::circle, false, 1, 0, 0.3, 40}, GuidedField::length},
  };
  for (const Case& c : cases) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    const std::uint32_t bits = hoist.ask_guided(c.path);
    EXPECT_NE(bits & refusal_bit(Refusal::exercise_limits), 0U) << c.name;
    EXPECT_EQ(bits & ~(refusal_bit(Refusal::exercise_limits) | refusal_bit(Refusal::out_of_range) | refusal_bit(Refusal::not_finite)), 0U)
        << c.name;
    EXPECT_EQ(hoist.events.back().item, static_cast<std::uint32_t>(c.field)) << c.name;
    EXPECT_EQ(hoist.state.mode, Mode::standby) << c.name;
  }
}

TEST(Guided, ACurveTheTurningLimitDoesNotAllowAtAnySpeedIsRefused) {
  contract::Params params;
  params.remote_yaw_rate_rad_s_max = 0.05;
  ScriptedHoist hoist(params);
  ASSERT_TRUE(hoist.ready());
  EXPECT_NE(hoist.ask_guided({GuidedShape::circle, false, 0.5, 0, 0.3, 1}) & refusal_bit(Refusal::exercise_limits), 0U);
  EXPECT_EQ(hoist.events.back().item, static_cast<std::uint32_t>(GuidedField::curve));
  EXPECT_EQ(hoist.ask_guided({GuidedShape::circle, false, 2.0, 0, 0.3, 1}), 0U);
}

TEST(Guided, TheCapPerPatientHoldsForExercises) {
  contract::Params params;
  params.speed_cap_norm = 0.5;
  ScriptedHoist hoist(params);
  ASSERT_TRUE(hoist.ready());
  GuidedPath fast = kLong;
  fast.speed_m_s = 0.4;
  EXPECT_NE(hoist.ask_guided(fast), 0U);
  EXPECT_EQ(hoist.events.back().item, static_cast<std::uint32_t>(GuidedField::speed));
}

}  // namespace
}  // namespace hoist::core::test
