// H1: a motor that turns without a command. First a protective stop, then, if that has no effect, the supply is cut.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

namespace canopen = contract::canopen;

// The last step's command to the relay, if any, without the synchronisation output.
std::optional<std::uint8_t> told_relay(const ScriptedHoist& hoist) {
  for (const contract::CanFrame& frame : hoist.sent)
    if (frame.id == contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io))
      return static_cast<std::uint8_t>(frame.data[0] & ~canopen::kSyncOutput);
  return std::nullopt;
}
// Steps until the relay is commanded open; -1 if not within `limit` steps.
int ticks_until_released(ScriptedHoist& hoist, int limit) {
  for (int i = 1; i <= limit; ++i) {
    hoist.step();
    if ((told_relay(hoist).value_or(0) & canopen::kRelayRelease) != 0) return i;
  }
  return -1;
}
bool fed(ScriptedHoist& hoist) {
  std::uint8_t levels = 0;
  for (int i = 0; i < 20; ++i) {
    hoist.step();
    if (const auto told = told_relay(hoist))
      levels |= static_cast<std::uint8_t>((*told & canopen::kRelayRelease) != 0 ? 0x80 : 1U << *told);
  }
  return levels == 3;  // it was on and off, and never released
}

void run_away(FakeDrive& drive, double wheel_m_s, double current_a) {
  drive.forced_m_s = wheel_m_s;
  drive.current_a = current_a;
}

TEST(Runaway, H1AMotorOfASleepingDriveIsStoppedThenLosesItsSupply) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  run_away(hoist.drive_right, -0.08, -1.5);
  int ticks = 0;
  while (hoist.state.mode == Mode::standby && ticks < 50) hoist.step(), ++ticks;
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_LE(ticks, 7);
  EXPECT_TRUE(hoist.has_fault(Fault::overspeed));
  EXPECT_FALSE(hoist.state.relay.is_cut()) << "a stop comes first";
  const int released = ticks_until_released(hoist, 100);
  EXPECT_GT(ticks + released, 25);
  EXPECT_LE(ticks + released, 32) << "0.3 s";
  EXPECT_TRUE(hoist.has_fault(Fault::control_fault));
  EXPECT_EQ(hoist.drive_left.last_control, canopen::drive::kDisableVoltage);
  std::uint8_t last = 0xFF;
  for (int i = 0; i < 200; ++i) {
    hoist.step();
    const auto told = told_relay(hoist);
    if (!told) continue;
    EXPECT_NE(*told & canopen::kRelayRelease, 0);
    EXPECT_TRUE(last == 0xFF || last == *told) << "not fed";
    last = *told;
  }
}

// Its encoder has failed, or something holds the wheel.
TEST(Runaway, H1ACurrentThroughABridgeThatIsOffNeedsNoMotionToBeSeen) {
  for (const double current_a : {1.5, -1.5}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    run_away(hoist.drive_left, 0, current_a);
    EXPECT_TRUE(hoist.reach(Mode::protective_stop, 7));
    EXPECT_TRUE(hoist.has_fault(Fault::overspeed));
    // A real drive finds the current, too, and does not hold its wheel.
    hoist.drive_left.fault = hoist.drive_left.ignores_reset = true;
    const int released = ticks_until_released(hoist, 100);
    EXPECT_GT(released, 18);
    EXPECT_LE(released, 32);
  }
}

// An encoder that counts backwards shows a motor that drives its wheel as one that is pushed. At this speed a wheel generates 21 of 25.6 V, and
// nothing that it could feed.
TEST(Runaway, H1AMotorOfASleepingDriveIsSeenBehindAReversedEncoder) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.fault = hoist.drive_left.ignores_reset = true;
  EXPECT_TRUE(hoist.reach(Mode::protective_stop, 20));
  hoist.step(100);
  EXPECT_FALSE(hoist.has_fault(Fault::overspeed));
  run_away(hoist.drive_left, 0.6, -5);
  const int released = ticks_until_released(hoist, 100);
  EXPECT_GT(released, 25);
  EXPECT_LE(released, 33) << "0.3 s";
  EXPECT_TRUE(hoist.has_fault(Fault::control_fault));
}

TEST(Runaway, H1OnlyAnEngineerGivesTheSupplyBack) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  run_away(hoist.drive_left, 0.3, 2.6);
  ASSERT_GT(ticks_until_released(hoist, 100), 0);
  // The relay opens: no supply, no current, and the drives call that their fault.
  run_away(hoist.drive_left, NAN, 0);
  hoist.drive_left.supply_v = hoist.drive_right.supply_v = 0;
  hoist.drive_left.fault = hoist.drive_right.fault = true;
  ASSERT_TRUE(hoist.reach(Mode::fault, 200)) << "as soon as it has stood for a second";
  hoist.step(150);
  EXPECT_EQ(hoist.state.mode, Mode::fault) << "what the core has opened itself is no emergency stop";
  EXPECT_FALSE(hoist.has_fault(Fault::emergency_stop));
  EXPECT_FALSE(hoist.has_fault(Fault::drive_right_fault)) << "a drive without supply is a consequence";
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kTherapist), refusal_bit(Refusal::not_allowed));
  // Nor does the emergency stop lead around the engineer.
  hoist.io.switches = 1;
  ASSERT_TRUE(hoist.reach(Mode::emergency_stop, 10));
  hoist.io.switches = 0;
  hoist.step(10);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kTherapist), 0U);
  ASSERT_TRUE(hoist.reach(Mode::fault, 10));
  EXPECT_TRUE(hoist.state.relay.is_cut());
  hoist.step(150);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kEngineer), 0U);
  EXPECT_TRUE(fed(hoist));
  hoist.drive_left.supply_v = hoist.drive_right.supply_v = 25;
  hoist.drive_left.fault = hoist.drive_right.fault = false;
  EXPECT_TRUE(hoist.reach(Mode::standby));
  EXPECT_EQ(hoist.state.latched, 0U);
}

// STOP, a wheel runs on, and the button and the main switch are what a therapist reaches for next.
TEST(Runaway, H1H22WhoSwitchesOffAtOnceDoesNotGiveTheSupplyBack) {
  StopHistory stored;
  {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(7, 300);
    ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
    run_away(hoist.drive_left, 0.4, 3.0);
    for (int i = 0; i < 60; ++i) {
      hoist.step();
      if (hoist.out.stops_changed) stored = stop_history(hoist.state);
    }
    ASSERT_TRUE(hoist.state.relay.is_cut());
    hoist.io.switches = 1;
    hoist.step(20);
    ASSERT_EQ(hoist.state.mode, Mode::emergency_stop);
  }
  ScriptedHoist hoist;
  restore_stops(hoist.state, stored);
  hoist.step(300);
  EXPECT_EQ(hoist.state.mode, Mode::fault);
  EXPECT_TRUE(hoist.state.relay.is_cut());
}

TEST(Runaway, H1TheMotorsGetNoSupplyBeforeTheirDrivesAreHeard) {
  ScriptedHoist hoist;
  hoist.drive_left.silent = true;
  for (int i = 0; i < 300; ++i) {
    hoist.step();
    // Frames with the alarm come all the same; without a change the relay stays open.
    ASSERT_EQ(told_relay(hoist).value_or(0), 0);
  }
  EXPECT_EQ(hoist.state.mode, Mode::init);
  hoist.drive_left.silent = false;
  ASSERT_TRUE(hoist.reach(Mode::standby));
  EXPECT_TRUE(fed(hoist));
}

// What is out of service, without power or still starting has no protective stop before it.
TEST(Runaway, H1IsWatchedInEveryModeThatIsNotMeantToMove) {
  for (const Mode mode : {Mode::init, Mode::standby, Mode::calibrate, Mode::protective_stop, Mode::fault, Mode::emergency_stop}) {
    SCOPED_TRACE(static_cast<int>(mode));
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    hoist.state.mode = mode;
    if (mode == Mode::init) hoist.tilt_left.silent = true;  // and it stays there
    if (mode == Mode::emergency_stop) hoist.io.switches = 1;
    run_away(hoist.drive_left, 0.6, 2.6);
    const int released = ticks_until_released(hoist, 100);
    EXPECT_GT(released, 0);
    EXPECT_LE(released, 40);
    EXPECT_TRUE(hoist.has_fault(Fault::control_fault));
    hoist.step(300);
    EXPECT_TRUE(hoist.state.relay.is_cut()) << "for good";
  }
}

TEST(Runaway, H1WhatHandsAndSlopesDoIsNoRunaway) {
  struct Push {
    const char* name;
    double wheel_m_s, current_a;
  };
  for (const Push& push : {Push{"pushed quickly, with a current sensor that is off", 1.2, 0.9}, Push{"pushed back", -1.2, -0.9},
                           Push{"pushed until it feeds the supply", 0.75, -12}}) {
    for (const Mode mode : {Mode::standby, Mode::calibrate}) {
      SCOPED_TRACE(push.name);
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      hoist.state.mode = mode;
      hoist.server_up = true;
      run_away(hoist.drive_left, push.wheel_m_s, push.current_a);
      run_away(hoist.drive_right, push.wheel_m_s, push.current_a);
      hoist.step(300);
      EXPECT_NE(hoist.state.mode, Mode::protective_stop);
      EXPECT_FALSE(hoist.has_fault(Fault::overspeed));
      EXPECT_FALSE(hoist.state.relay.is_cut());
    }
  }
  // A motor that coasts briefly after its drive reports off.
  ScriptedHoist late;
  ASSERT_TRUE(late.ready());
  run_away(late.drive_left, 0.3, 3);
  late.step(4);
  run_away(late.drive_left, NAN, 0);
  late.step(100);
  EXPECT_EQ(late.state.mode, Mode::standby);
}

// A stop from 0.25 m/s in which one wheel continues, without current to explain it.
ScriptedHoist stopping(double left_m_s) {
  ScriptedHoist hoist;
  EXPECT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 0.9);
  hoist.drive_left.fault = true;
  hoist.drive_left.ignores_reset = true;
  run_away(hoist.drive_left, left_m_s, 0);
  EXPECT_TRUE(hoist.reach(Mode::protective_stop, 30));
  return hoist;
}

TEST(Runaway, H1AStopThatDoesNotSlowAWheelNeedsNoCurrentToBeSeen) {
  ScriptedHoist fast = stopping(0.5);
  const int at_once = ticks_until_released(fast, 100);
  EXPECT_GT(at_once, 0);
  EXPECT_LE(at_once, 32) << "beside its ramp from the beginning";
  ScriptedHoist slow = stopping(0.2);
  const int later = ticks_until_released(slow, 150);
  EXPECT_GT(later, 0);
  EXPECT_LE(later, 65) << "0.15 m/s beside a ramp that ends after 0.25 s";
  // Slower than its ramp, but it does brake: a brake alone, down a slope, with a patient on it.
  ScriptedHoist brakes = stopping(0.5);
  for (int i = 0; i < 120; ++i) {
    brakes.drive_left.forced_m_s = std::max(0.0, 0.5 - 0.4 * i * kTick_s);
    brakes.step();
    ASSERT_FALSE(brakes.state.relay.is_cut()) << i;
  }
  EXPECT_NE(ticks_until_released(fast, 100), -1);
}

TEST(Runaway, H1AHoistThatHasStoodMayBePushedInAStop) {
  ScriptedHoist hoist = stopping(0.1);
  hoist.drive_left.forced_m_s = 0;
  hoist.step(200);
  hoist.drive_left.forced_m_s = 0.5;  // its brake was released by hand, to free the patient
  EXPECT_EQ(ticks_until_released(hoist, 100), -1);
}

// The brake holds 89 N at a wheel; beside a body that pushes it with 75 N the motor needs 0.4 A (seed 19819 of tests/chaos).
TEST(Runaway, H1ABodyThatHelpsAShortedBridgeDoesNotHideIt) {
  for (const double current_a : {0.25, -0.25, 0.35, -0.35}) {
    SCOPED_TRACE(current_a);
    ScriptedHoist hoist = stopping(0.1);
    hoist.drive_left.forced_m_s = 0;
    hoist.step(200);
    run_away(hoist.drive_left, 0.45, current_a);
    const int released = ticks_until_released(hoist, 100);
    EXPECT_EQ(released > 0, std::fabs(current_a) > 0.3);
    EXPECT_LE(released, 60);
  }
}

// A serial line has no checksum. One damaged current of a wheel that hands push away cuts no supply, however large; nor does one of 0.16 s.
TEST(Runaway, H1_H22ACurrentThatDoesNotLastCutsNothing) {
  for (const auto& [current_a, ticks] : {std::pair{12.0, 1}, {70.0, 1}, {196.0, 1}, {-196.0, 1}, {2.5, 16}, {2.5, 40}}) {
    SCOPED_TRACE(::testing::Message() << current_a << " A for " << ticks << " steps");
    ScriptedHoist hoist = stopping(0.1);
    hoist.drive_left.forced_m_s = 0;
    hoist.step(200);
    run_away(hoist.drive_left, 0.3, current_a);
    hoist.step(ticks);
    hoist.drive_left.current_a = 0;
    const bool before = hoist.state.relay.is_cut();
    EXPECT_EQ(before || ticks_until_released(hoist, 100) >= 0, ticks > 30);
  }
}

// A body that falls into the stops may push harder than the motors hold. Without them it would push the hoist faster.
TEST(Runaway, H1H2H15MotorsThatBrakeHarderThanTheBrakesAreLeftTo) {
  for (const double wheel_m_s : {0.5, -0.5, 0.1}) {
    for (const double against_a : {2.9, 3.1}) {
      SCOPED_TRACE(::testing::Message() << wheel_m_s << " m/s, " << against_a << " A");
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.start(Mode::remote));
      hoist.drive_for(200, 0.9);
      ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
      ASSERT_TRUE(hoist.reach(Mode::protective_stop, 30));
      for (FakeDrive* drive : {&hoist.drive_left, &hoist.drive_right}) run_away(*drive, wheel_m_s, std::copysign(against_a, -wheel_m_s));
      bool off = false, released = false;
      for (int i = 0; i < 300; ++i) {
        hoist.step();
        released = released || hoist.state.relay.is_cut();
        off = off || hoist.state.in_mode.hold.cut();
        if (off || released) hoist.drive_left.current_a = hoist.drive_right.current_a = 0;
      }
      const bool fast = std::fabs(wheel_m_s) > 0.2, weaker = against_a < 3;
      EXPECT_EQ(released, fast && weaker) << "the last resort is for what runs away";
      EXPECT_EQ(off, !fast && weaker) << "what creeps is switched off";
    }
  }
}

TEST(Runaway, H1ASilentDriveThatRunsOnIsSeenByTheGyroscope) {
  for (const double spin_deg_s : {10.0, 20.0, -20.0}) {
    SCOPED_TRACE(spin_deg_s);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(200, 0.9);
    hoist.drive_left.silent = true;
    hoist.tilt_base.yaw_rate_deg_s = spin_deg_s;
    ASSERT_TRUE(hoist.reach(Mode::protective_stop, 30));
    const int released = ticks_until_released(hoist, 100);
    EXPECT_EQ(released > 0, std::abs(spin_deg_s) > 15);
    EXPECT_LE(released, 60);
  }
}

TEST(Runaway, H1AHoistThatTellsNothingHasNotStood) {
  for (const bool gyro_silent : {false, true}) {
    SCOPED_TRACE(gyro_silent);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(200, 0.9);
    hoist.drive_left.silent = hoist.drive_right.silent = true;
    hoist.tilt_base.silent = gyro_silent;
    ASSERT_TRUE(hoist.reach(Mode::protective_stop, 30));
    hoist.step(20);
    // A hoist that rolls straight does not turn: its gyroscope alone cannot tell that it stands.
    hoist.drive_left.silent = hoist.drive_right.silent = hoist.tilt_base.silent = false;
    run_away(hoist.drive_left, 0.6, 0);
    run_away(hoist.drive_right, 0.6, 0);
    const int released = ticks_until_released(hoist, 100);
    EXPECT_GT(released, 0);
    EXPECT_LE(released, 40);
  }
}

}  // namespace
}  // namespace hoist::core::test
