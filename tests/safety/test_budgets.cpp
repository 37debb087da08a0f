// Falls (H15, H16), distances, and what holds in every step of any run.
#include <gtest/gtest.h>

#include <random>

#include "control/core/modes/mode_list.hpp"
#include "control/core/record.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// The struts driven by a function of time from the present lean; the time of the first step beyond `angle_deg` and of the stop.
struct Fall {
  int beyond_tick = -1, stop_tick = -1;
};
template <typename F>
Fall fall(ScriptedHoist& hoist, F&& angle, double angle_deg, int ticks) {
  Fall result;
  hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 5;
  for (int i = 0; i < ticks && result.stop_tick < 0; ++i) {
    hoist.lean(angle(i * kTick_s));
    if (result.beyond_tick < 0 && hoist.tilt_left.alpha_deg > angle_deg) result.beyond_tick = i;
    hoist.step();
    if (hoist.state.mode == Mode::protective_stop) result.stop_tick = i;
  }
  return result;
}

// The therapist may drive as fast as the hoist goes.
contract::Params full_remote_speed() {
  contract::Params params;
  params.remote_speed_m_s_max = 0.6;
  return params;
}

TEST(Falls, H15AFallingPatientIsCaughtWithin30Ms) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(5, 200);
  // An inverted pendulum of 1 m from 5 degrees: 27 deg/s at 10 degrees (SOURCES 2.1).
  const Fall result = fall(
      hoist, [](double t) { return 5 * std::cosh(3.13 * t); }, 10, 100);
  ASSERT_GE(result.beyond_tick, 0);
  ASSERT_GE(result.stop_tick, 0);
  EXPECT_LE(result.stop_tick - result.beyond_tick, 3);
  EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
  EXPECT_EQ(contract::fault_info(Fault::fall_detected).hazard(), "H15");
  hoist.step(100);
  EXPECT_EQ(hoist.drive_left.status, 0x27) << "held by the drives, never let roll";
}

TEST(Falls, H15SidewaysAndBackwardCountToo) {
  for (int way = 0; way < 3; ++way) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    for (int i = 0; i < 60 && hoist.state.mode == Mode::user; ++i) {
      const double tilt_deg = 0.4 * i;
      if (way == 0) hoist.lean(-tilt_deg);
      if (way > 0) hoist.tilt_left.beta_deg = hoist.tilt_right.beta_deg = way == 1 ? tilt_deg : -tilt_deg;
      hoist.step();
    }
    EXPECT_TRUE(hoist.has_fault(Fault::fall_detected)) << way;
    EXPECT_LT(std::abs(way == 0 ? hoist.tilt_left.alpha_deg : hoist.tilt_left.beta_deg), 11.0);
  }
}

// At 40 degrees a second out to 9.8: along the way that is a wish, sideways a lean asks for nothing.
TEST(Falls, H15SidewaysHalfADegreeLessIsAFall) {
  for (const bool aside : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    for (int i = 0; i < 40 && hoist.state.mode == Mode::user; ++i) {
      const double tilt_deg = std::min(9.8, 0.4 * i);
      if (aside)
        hoist.tilt_left.beta_deg = hoist.tilt_right.beta_deg = tilt_deg;
      else
        hoist.lean(tilt_deg);
      hoist.step();
    }
    EXPECT_EQ(hoist.has_fault(Fault::fall_detected), aside);
  }
}

// A hoist that speeds up throws the body back, up to 11.5 degrees; who goes on falling is not left to the resting lean.
TEST(Falls, H15WhoFallsBackWhileTheHoistSpeedsUpIsCaught) {
  for (const double out_deg : {11.2, 14.0}) {
    SCOPED_TRACE(out_deg);
    ScriptedHoist hoist(full_remote_speed());
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(40, 1.0);
    ASSERT_GT(hoist.command_m_s(), 0.05);
    double at_deg = 0;
    for (int i = 0; i < 60 && !hoist.has_fault(Fault::fall_detected); ++i) {
      at_deg = std::min(out_deg, 0.4 * i);
      hoist.lean(-at_deg);
      hoist.drive_for(1, 1.0);
    }
    EXPECT_EQ(hoist.has_fault(Fault::fall_detected), out_deg > 13);
    EXPECT_LT(at_deg, 13.0);
  }
}

TEST(Falls, H15SlowLeaningToTheLimitOfIntentIsNoFall) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(9.9, 300);
  EXPECT_EQ(hoist.state.mode, Mode::user);
  // Quick, but not far.
  ScriptedHoist quick;
  ASSERT_TRUE(quick.start(Mode::user));
  for (int i = 0; i < 300; ++i) {
    quick.lean(4.5 + 4.5 * std::sin(2 * std::numbers::pi * 1.5 * i * kTick_s));  // 42 deg/s, up to 9 degrees
    quick.step();
  }
  EXPECT_EQ(quick.state.mode, Mode::user);
}

TEST(Falls, H15ComingBackFromBeyondTheLimitIsNoFall) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(9.5, 50);
  for (int i = 0; i < 100; ++i) {  // 20 deg/s out to 11.5
    hoist.lean(std::min(11.5, 9.5 + 0.2 * i));
    hoist.step();
  }
  ASSERT_EQ(hoist.state.mode, Mode::user);
  for (int i = 0; i < 20; ++i) {  // 60 deg/s back
    hoist.lean(11.5 - 0.6 * i);
    hoist.step();
  }
  EXPECT_EQ(hoist.state.mode, Mode::user);
}

// Leans from 9 degrees on at 40 degrees per second up to 12; whether that was called a fall.
bool quick_lean_trips(ScriptedHoist& hoist, double way) {
  for (int i = 0; i <= 8; ++i) {
    hoist.lean(way * (9.0 + 0.375 * i));
    hoist.step();
  }
  return hoist.has_fault(Fault::fall_detected);
}

// A hoist that brakes throws the body forward; that is no fall, and braking harder would throw it farther.
TEST(Falls, H15WhatTheHoistsOwnBrakingExplainsIsNoFall) {
  struct Case {
    const char* name;
    double way;           // of the lean
    double braking_m_s2;  // of the stick's ramp
    int wait_ticks;       // from letting go to the lean
    bool trips;
  };
  for (const Case& c : {Case{"thrown forward by the ramp", 1, 0.5, 15, false}, Case{"backward against it", -1, 0.5, 15, true},
                        Case{"a ramp too soft to throw anybody", 1, 0.3, 15, true}, Case{"just after the stop", 1, 0.5, 138, false},
                        Case{"a good while after it", 1, 0.5, 164, true}}) {
    SCOPED_TRACE(c.name);
    contract::Params params = full_remote_speed();
    params.acceleration_m_s2_max = c.braking_m_s2;
    ScriptedHoist hoist(params);
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(300, 1.0);
    ASSERT_NEAR(hoist.command_m_s(), 0.6, 1e-3);
    for (int i = 0; i <= 30; ++i) {
      hoist.lean(c.way * 0.3 * i);
      hoist.drive_for(1, 1.0);
    }
    hoist.drive_for(1, 0.0);
    hoist.drive_for(c.wait_ticks, 0.0);
    EXPECT_EQ(quick_lean_trips(hoist, c.way), c.trips);
    // But a body at the mechanical stop is a fall, for any cause.
    for (int i = 0; i < 85; ++i) {
      hoist.lean(c.way * std::min(14.0, 12.0 + 0.2 * i));
      hoist.drive_for(1, 0.0);
    }
    EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
  }
}

// Found in a random session: the therapist halved the speed of a walk, and the swing of the body ended just after the
// time allowed for it.
TEST(Falls, H15ASwingThatTheBrakeBeganMayEndAfterIt) {
  for (const int out_ticks : {30, 75}) {
    SCOPED_TRACE(out_ticks);
    ScriptedHoist hoist(full_remote_speed());
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(300, 1.0);
    for (int i = 0; i < 140; ++i) {  // the ramp takes 1.2 s and somewhat more, and 0.3 s count as the swing
      hoist.lean(std::min(12.5, 0.1 * i));
      hoist.drive_for(1, 0.0);
    }
    ASSERT_FALSE(hoist.has_fault(Fault::fall_detected));
    for (int i = 0; i < out_ticks; ++i) {
      hoist.lean(13.3);
      hoist.drive_for(1, 0.0);
    }
    EXPECT_EQ(hoist.has_fault(Fault::fall_detected), out_ticks > 60);
    if (out_ticks > 60) continue;
    // Back, and out again: no longer a swing caused by the brake.
    for (int i = 0; i < 30; ++i) {
      hoist.lean(i < 15 ? 12.5 : 13.3);
      hoist.drive_for(1, 0.0);
    }
    EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
  }
}

TEST(Falls, H16HangingBeyondTheRestingLeanStops) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(9.5, 50);
  int ticks_beyond = 0;
  for (int i = 0; i < 400 && hoist.state.mode == Mode::user; ++i) {
    hoist.lean(std::min(13.6, 9.5 + 0.15 * i));
    hoist.step();
    if (hoist.tilt_left.alpha_now_deg > 13.0) ++ticks_beyond;
  }
  EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
  EXPECT_NEAR(ticks_beyond, 10, 2) << "0.1 s in the preset walk";
}

TEST(Falls, H16ThePresetPaperWaitsTwoSeconds) {
  contract::Params paper;
  for (const auto& value : contract::kPresetValues)
    if (value.preset == "paper") contract::set_param_unchecked(paper, contract::param_index(value.param), value.value);
  ScriptedHoist hoist(paper);
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(9.5, 20);
  int ticks_beyond = 0;
  for (int i = 0; i < 600 && hoist.state.mode == Mode::user; ++i) {
    hoist.lean(std::min(14.5, 9.5 + 0.15 * i));
    hoist.step();
    if (hoist.tilt_left.alpha_now_deg > 14.0) ++ticks_beyond;
  }
  EXPECT_TRUE(hoist.has_fault(Fault::fall_detected));
  EXPECT_NEAR(ticks_beyond, 200, 3);
}

TEST(Falls, AFallenPatientIsNotAcknowledgedAwayBeforeStandingAgain) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  fall(
      hoist, [](double t) { return std::min(14.0, 40 * t); }, 10, 100);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  hoist.lean(14);
  hoist.step(200);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), refusal_bit(Refusal::cause_not_cleared));
  hoist.lean(2);
  hoist.step(20);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
}

TEST(Falls, TheBlowAtTheStopIsNotCalledABrokenSensor) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  fall(
      hoist, [](double t) { return std::min(14.0, 40 * t); }, 10, 100);
  ASSERT_TRUE(hoist.has_fault(Fault::fall_detected));
  hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 9;
  hoist.lean(17.5);
  hoist.step(2);
  hoist.lean(9);
  hoist.step(200);
  EXPECT_FALSE(hoist.has_fault(Fault::tilt_implausible));
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  hoist.tilt_left.alpha_deg = 17.5;
  hoist.step(5);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible)) << "afterwards it counts again";
}

TEST(Falls, ATwistIsATurnAndNoFall) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  for (int i = 0; i < 200; ++i) {
    hoist.lean(0, std::min(22.0, 0.6 * i));  // each strut at 11 degrees, 30 deg/s
    hoist.step();
    ASSERT_EQ(hoist.state.mode, Mode::user) << i;
  }
}

TEST(Distances, TheShownStopDistanceIsNotTooShort) {
  for (const double stick : {0.3, 0.7, 1.0}) {
    ScriptedHoist hoist(full_remote_speed());
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(400, stick);
    const double promised = hoist.out.record.stop_distance_m;
    const double from = hoist.out.record.x_m;
    hoist.step(300);  // no command comes any more
    const double rolled = hoist.out.record.x_m - from;
    EXPECT_LE(rolled, promised + 0.005) << stick;
    EXPECT_GE(rolled, 0.8 * promised) << "nor far too long";
  }
}

TEST(Distances, H13ABumperStopAtFullSpeedNeeds14Cm) {
  ScriptedHoist hoist(full_remote_speed());
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(400, 1.0);
  ASSERT_NEAR(hoist.command_m_s(), 0.6, 0.01);
  const double from = hoist.out.record.x_m;
  hoist.io.bumpers = 1;
  hoist.step(150);
  EXPECT_LE(hoist.out.record.x_m - from, 0.16) << "0.12 m of ramp plus the lag of the script's wheels";
}

// Anything may happen, in any order: the invariants of SOURCES 2.4 (I1, I2, I4, I5, I13) hold in every step.
TEST(Chaos, InvariantsHoldUnderRandomFaultsAndRequests) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto one_in = [&](std::uint64_t n) { return random() % n == 0; };
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    FakeNode* const nodes[] = {&hoist.tilt_left, &hoist.tilt_right, &hoist.tilt_base, &hoist.drive_left, &hoist.drive_right, &hoist.io};
    double lean = 0, stick = 0;
    bool held = false;
    for (int i = 0; i < 4000; ++i) {
      if (one_in(100)) lean = static_cast<double>(random() % 240) / 10.0 - 12.0;
      hoist.lean(hoist.tilt_left.alpha_deg + std::clamp(lean - hoist.tilt_left.alpha_deg, -0.15, 0.15));
      if (one_in(60)) {
        stick = static_cast<double>(random() % 200) / 100.0 - 1.0;
        held = !one_in(4);
      }
      if (i % 4 == 0 && !one_in(9)) hoist.hold(stick, stick / 2, held);
      if (one_in(900)) nodes[random() % 6]->silent = true;
      if (one_in(100))
        for (FakeNode* node : nodes) node->silent = false;
      if (one_in(1500)) hoist.io.bumpers = 1;
      if (one_in(100)) hoist.io.bumpers = 0;
      if (one_in(1500)) hoist.drive_left.fault = true;
      if (one_in(700)) hoist.server_up = !hoist.server_up;
      if (one_in(2000)) hoist.bus_up = false;
      if (one_in(60)) hoist.bus_up = true;
      if (one_in(300)) hoist.lateness_s = 0.012F;
      if (one_in(2500)) hoist.io.switches = 1;
      if (one_in(100)) hoist.io.switches = 0;
      if (one_in(40)) hoist.send(CommandKind::acknowledge, 7, 0, one_in(4) ? 2 : 1);
      if (one_in(40)) hoist.send(CommandKind::take_lease);
      if (one_in(60)) hoist.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(random() % contract::kModes.size()));
      if (one_in(800)) hoist.send(CommandKind::stop, 3);
      const Mode before = hoist.state.mode;
      const double v = hoist.state.limiter.speed_m_s();
      hoist.step();
      const Mode now = hoist.state.mode;
      hoist.events.clear();
      ASSERT_FALSE(hoist.ever_not_finite);
      ASSERT_LE(std::abs(hoist.command_m_s()), hoist.state.params.speed_m_s_max + 1e-3);
      ASSERT_LE(std::abs(hoist.state.limiter.speed_m_s() - v), 1.5 * kTick_s + 1e-9);
      if (is_moving(now) && !is_moving(before)) {
        ASSERT_EQ(before, Mode::standby);
      }
      if (before == Mode::protective_stop && now != before) {
        // INIT: only silent nodes are left, and acknowledged.
        ASSERT_TRUE(now == Mode::standby || now == Mode::fault || now == Mode::emergency_stop || now == Mode::init);
      }
      if ((before == Mode::fault || before == Mode::emergency_stop) && now != before) {
        // Through INIT within the step: out of service before the button was pressed and again after, or STOP right after the acknowledgement.
        const bool again = now == Mode::fault && (hoist.state.latched & faults_with(contract::Reaction::out_of_service)) != 0;
        const bool stopped = now == Mode::protective_stop && hoist.has_fault(Fault::stop_pressed);
        ASSERT_TRUE(now == Mode::init || now == Mode::emergency_stop || again || stopped);
      }
      if (!is_moving(now) && now != Mode::protective_stop) {
        ASSERT_EQ(hoist.command_m_s(), 0.0);
      }
      if (now == Mode::protective_stop) {
        ASSERT_LE(std::abs(hoist.state.limiter.speed_m_s()), std::abs(v) + 1e-9);
      }
      ASSERT_FALSE(hoist.has_fault(Fault::gate_refused)) << "step " << i;
    }
  }
}

}  // namespace
}  // namespace hoist::core::test
