// Each monitor: trips in time, stays quiet below its threshold, and its fault names the hazard. One test per hazard id.
#include <gtest/gtest.h>

#include <functional>

#include "control/core/modes/mode_list.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::Reaction;

struct Trip {
  const char* name;
  Fault fault;
  const char* hazard;
  Mode mode;
  int budget_ticks;                               // from the cause to braking
  std::function<void(ScriptedHoist&)> cause;      // once, before the first step
  std::function<void(ScriptedHoist&, int)> each;  // before every step
};

void nothing(ScriptedHoist&, int) {}

const std::vector<Trip>& trips() {
  static const std::vector<Trip> table = {
      {"left strut unplugged", Fault::tilt_left_lost, "H4", Mode::user, 6, [](ScriptedHoist& h) { h.tilt_left.silent = true; }, nothing},
      {"right strut unplugged", Fault::tilt_right_lost, "H4", Mode::user, 6, [](ScriptedHoist& h) { h.tilt_right.silent = true; }, nothing},
      {"chassis sensor unplugged", Fault::tilt_base_lost, "H4", Mode::remote, 6, [](ScriptedHoist& h) { h.tilt_base.silent = true; },
       nothing},
      {"left drive unplugged", Fault::drive_left_lost, "H3", Mode::user, 6, [](ScriptedHoist& h) { h.drive_left.silent = true; }, nothing},
      {"right drive unplugged", Fault::drive_right_lost, "H3", Mode::remote, 6, [](ScriptedHoist& h) { h.drive_right.silent = true; },
       nothing},
      {"input node unplugged", Fault::io_lost, "H14", Mode::user, 6, [](ScriptedHoist& h) { h.io.silent = true; }, nothing},
      {"batteries not told any more", Fault::io_lost, "H14", Mode::user, 262, [](ScriptedHoist& h) { h.io.battery_silent = true; },
       nothing},
      {"bus cut", Fault::bus_down, "H5", Mode::user, 1, [](ScriptedHoist& h) { h.bus_up = false; }, nothing},
      {"cable cut behind the interface", Fault::bus_down, "H5", Mode::user, 6,
       [](ScriptedHoist& h) {
         h.drive_left.silent = h.drive_right.silent = h.io.silent = true;
         h.tilt_left.silent = h.tilt_right.silent = h.tilt_base.silent = true;
       },
       nothing},
      {"left drive in fault", Fault::drive_left_fault, "H2", Mode::user, 3, [](ScriptedHoist& h) { h.drive_left.fault = true; }, nothing},
      {"right drive in fault", Fault::drive_right_fault, "H2", Mode::remote, 3, [](ScriptedHoist& h) { h.drive_right.fault = true; },
       nothing},
      {"right drive drops out", Fault::drive_right_fault, "H2", Mode::remote, 8, nullptr,
       [](ScriptedHoist& h, int) { h.drive_right.status = 0x40; }},
      {"drive drops out", Fault::drive_left_fault, "H2", Mode::user, 8, nullptr, [](ScriptedHoist& h, int) { h.drive_left.status = 0x40; }},
      {"strut beyond its stop", Fault::tilt_implausible, "H7", Mode::remote, 2,
       [](ScriptedHoist& h) {
         h.tilt_left.slew_deg = 99;
         h.tilt_left.alpha_deg = 19.0;
       },
       nothing},
      {"strut creeps beyond its stop", Fault::tilt_implausible, "H7", Mode::remote, 16,
       [](ScriptedHoist& h) {
         h.tilt_left.slew_deg = 1.5;
         h.tilt_left.alpha_deg = 18.8;
       },
       nothing},
      {"chassis beyond belief", Fault::tilt_implausible, "H7", Mode::user, 2,
       [](ScriptedHoist& h) {
         h.tilt_base.slew_deg = 99;
         h.tilt_base.beta_deg = -19.5;
       },
       nothing},
      {"strut jumps", Fault::tilt_implausible, "H7", Mode::user, 2,
       [](ScriptedHoist& h) {
         h.tilt_right.slew_deg = 99;
         h.tilt_right.alpha_deg = h.tilt_right.alpha_now_deg - 2.2;
       },
       nothing},
      {"struts lean apart sideways", Fault::tilt_implausible, "H7", Mode::user, 20,
       [](ScriptedHoist& h) {
         h.tilt_left.beta_deg = 2.2;
         h.tilt_right.beta_deg = -2.2;
       },
       nothing},
      {"struts twisted", Fault::tilt_implausible, "H7", Mode::remote, 24, [](ScriptedHoist& h) { h.lean(0, 26); }, nothing},
      {"counter stands", Fault::tilt_frozen, "H6", Mode::user, 4, [](ScriptedHoist& h) { h.tilt_left.frozen = true; }, nothing},
      {"angles stand while rolling", Fault::tilt_frozen, "H6", Mode::remote, 32,
       [](ScriptedHoist& h) { h.tilt_left.dither = h.tilt_right.dither = false; }, nothing},
      {"one strut's chip stands while its twin moves", Fault::tilt_frozen, "H6", Mode::user, 34,
       [](ScriptedHoist& h) { h.tilt_right.dither = false; }, nothing},
      {"one strut's chip all but stands", Fault::tilt_frozen, "H6", Mode::user, 48,
       [](ScriptedHoist& h) {
         h.sway_deg = 0;
         h.tilt_right.dither = false;
       },
       // Two lively samples in thirty: one for each lonely bump of two digits.
       [](ScriptedHoist& h, int i) { h.tilt_right.alpha_deg = i % 15 == 7 ? 6.002 : 6.0; }},
      {"the chassis' gyroscopes stand", Fault::tilt_frozen, "H6", Mode::user, 22, [](ScriptedHoist& h) { h.tilt_base.dither = false; },
       nothing},
      {"self-test failed", Fault::tilt_sensor_fault, "H8", Mode::user, 2, [](ScriptedHoist& h) { h.tilt_base.status = 3 | 16; }, nothing},
      {"samples invalid", Fault::tilt_sensor_fault, "H8", Mode::user, 6, [](ScriptedHoist& h) { h.tilt_right.status = 2; }, nothing},
      {"gyro saturated", Fault::tilt_sensor_fault, "H8", Mode::user, 6, [](ScriptedHoist& h) { h.tilt_right.status = 3 | 8; }, nothing},
      {"a gyroscope of the chassis that has lost its zero", Fault::tilt_sensor_fault, "H8", Mode::user, 700,
       [](ScriptedHoist& h) { h.tilt_base.pitch_rate_deg_s = 6; }, nothing},
      {"chassis on a steep ramp", Fault::base_tilted, "H9", Mode::user, 20, nullptr,
       [](ScriptedHoist& h, int) {
         for (FakeTilt* t : {&h.tilt_base, &h.tilt_left, &h.tilt_right}) t->slew_deg = 1.5, t->beta_deg = 8.1;
       }},
      {"chassis on a steep ramp, head down", Fault::base_tilted, "H9", Mode::remote, 20, nullptr,
       [](ScriptedHoist& h, int) {
         for (FakeTilt* t : {&h.tilt_base, &h.tilt_left, &h.tilt_right}) t->slew_deg = 1.5, t->alpha_deg = 5.8, t->beta_deg = -5.8;
       }},
      {"front bumper", Fault::bumper_pressed, "H13", Mode::user, 1, [](ScriptedHoist& h) { h.io.bumpers = 1; }, nothing},
      {"right bumper", Fault::bumper_pressed, "H13", Mode::remote, 1, [](ScriptedHoist& h) { h.io.bumpers = 8; }, nothing},
      {"wheel runs away", Fault::overspeed, "H1", Mode::remote, 25, [](ScriptedHoist& h) { h.drive_left.forced_m_s = 0.6; }, nothing},
      {"wheel stands against its command", Fault::overspeed, "H1", Mode::remote, 25, [](ScriptedHoist& h) { h.drive_right.forced_m_s = 0; },
       nothing},
      {"faster than allowed", Fault::overspeed, "H1", Mode::user, 8,
       [](ScriptedHoist& h) { h.drive_left.forced_m_s = h.drive_right.forced_m_s = 0.8; }, nothing},
      {"a second strut sensor with the same number", Fault::node_duplicate, "H30", Mode::user, 8, nullptr,
       [](ScriptedHoist& h, int) {
         h.extra.push_back({0x191, 6, 0, {0, 0, 0, 0, 3, h.tilt_left.counter}});
       }},
      {"a second drive with the same number", Fault::node_duplicate, "H30", Mode::remote, 8, nullptr,
       [](ScriptedHoist& h, int) {
         h.extra.push_back({0x182, 8, 0, {0x27, 0}});
       }},
      {"a second input node with the same number", Fault::node_duplicate, "H30", Mode::user, 40, nullptr,
       [](ScriptedHoist& h, int i) {
         if (i % 10 == 4) h.extra.push_back({0x708, 1, 0, {5}});
       }},
      {"a sensor floods the bus", Fault::node_babbling, "H30", Mode::user, 6, nullptr,
       [](ScriptedHoist& h, int) {
         for (int k = 0; k < 15; ++k) h.extra.push_back({0x292, 6, 0, {}});
       }},
      {"a stranger floods the bus", Fault::node_babbling, "H30", Mode::remote, 4, nullptr,
       [](ScriptedHoist& h, int) {
         for (int k = 0; k < 15; ++k) h.extra.push_back({0x010, 8, 0, {}});
       }},
      {"one step far too late", Fault::loop_overrun, "H22", Mode::user, 1, [](ScriptedHoist& h) { h.lateness_s = 0.031F; }, nothing},
      {"two late steps in a second", Fault::loop_overrun, "H22", Mode::remote, 60, nullptr,
       [](ScriptedHoist& h, int i) {
         if (i == 0 || i == 50) h.lateness_s = 0.006F;
       }},
  };
  return table;
}

// Walking or driving at about 0.25 m/s.
void set_going(ScriptedHoist& hoist, Mode mode) {
  ASSERT_TRUE(hoist.start(mode));
  if (mode == Mode::user) {
    hoist.lean_gently(6, 250);
  } else {
    hoist.drive_for(200, 0.9);
  }
  ASSERT_GT(hoist.command_m_s(), 0.15);
}

TEST(Monitors, EachTripsInTimeStopsAndNamesItsHazard) {
  for (const Trip& trip : trips()) {
    SCOPED_TRACE(trip.name);
    ScriptedHoist hoist;
    set_going(hoist, trip.mode);
    if (HasFatalFailure()) return;
    if (trip.cause) trip.cause(hoist);
    int ticks = 0;
    while (hoist.state.mode != Mode::protective_stop && ticks < trip.budget_ticks + 100) {
      trip.each(hoist, ticks);
      if (trip.mode == Mode::remote) hoist.hold(0.9);
      hoist.step();
      ++ticks;
    }
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
    EXPECT_LE(ticks, trip.budget_ticks);
    EXPECT_TRUE(hoist.has_fault(trip.fault));
    EXPECT_EQ(hoist.out.record.stop_cause, static_cast<int>(trip.fault) + 1);
    EXPECT_EQ(contract::fault_info(trip.fault).hazard(), trip.hazard);
    EXPECT_EQ(contract::fault_info(trip.fault).reaction, Reaction::protective_stop);
    // I4: after the ramp nothing is commanded, independent of the cause.
    hoist.worst_deceleration_m_s2 = 0;
    hoist.step(120);
    EXPECT_EQ(hoist.state.limiter.speed_m_s(), 0);
    EXPECT_LE(hoist.worst_deceleration_m_s2, trip.fault == Fault::bumper_pressed ? 1.5 + 1e-9 : 1.0 + 1e-9);
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
    EXPECT_FALSE(hoist.ever_not_finite);
    EXPECT_FALSE(hoist.has_fault(Fault::gate_refused)) << "the gate has nothing to add to a stop that works";
  }
}

TEST(Monitors, QuietJustBelowEveryThreshold) {
  struct Near {
    const char* name;
    Mode mode;
    std::function<void(ScriptedHoist&, int)> each;
  };
  const Near table[] = {
      {"two frames of a strut missing", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_left.silent = i % 10 < 2; }},
      {"four frames of a strut missing", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_left.silent = i % 20 < 4; }},
      {"four frames of a drive missing", Mode::user, [](ScriptedHoist& h, int i) { h.drive_left.silent = i % 40 < 4; }},
      {"a counter that repeats twice", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_left.frozen = i % 10 < 2; }},
      {"sideways apart for 80 ms", Mode::user,
       [](ScriptedHoist& h, int i) {
         h.tilt_left.slew_deg = h.tilt_right.slew_deg = 1.9;
         h.tilt_left.beta_deg = i % 30 < 8 ? 2.2 : 0;
         h.tilt_right.beta_deg = -h.tilt_left.beta_deg;
       }},
      {"sideways apart by 3.8 degrees", Mode::user,
       [](ScriptedHoist& h, int) {
         h.tilt_left.beta_deg = 1.9;
         h.tilt_right.beta_deg = -1.9;
       }},
      {"chassis on a gentle ramp", Mode::remote,
       [](ScriptedHoist& h, int) { h.tilt_base.alpha_deg = h.tilt_left.alpha_deg = h.tilt_right.alpha_deg = 4.9; }},
      {"chassis tips by ten degrees for 80 ms", Mode::user,
       [](ScriptedHoist& h, int i) {
         for (FakeTilt* t : {&h.tilt_base, &h.tilt_left, &h.tilt_right}) {
           t->slew_deg = 1.8;
           t->beta_deg = i % 60 < 6 ? 10 : 0;
         }
       }},
      {"a gyroscope of the chassis off by 2.9 degrees per second", Mode::user,
       [](ScriptedHoist& h, int) { h.tilt_base.pitch_rate_deg_s = 2.9; }},
      {"strut just before its stop", Mode::remote,
       [](ScriptedHoist& h, int) {
         h.tilt_left.alpha_deg = 16.8;
         h.tilt_right.alpha_deg = -8.0;
       }},
      {"invalid for 40 ms", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_right.status = i % 50 < 4 ? 2 : 3; }},
      {"acceleration out of range", Mode::user, [](ScriptedHoist& h, int) { h.tilt_right.status = 7; }},
      {"a wheel 0.13 off", Mode::remote, [](ScriptedHoist& h, int) { h.drive_left.forced_m_s = h.drive_left.target_m_s + 0.13; }},
      {"a wheel far off for 100 ms", Mode::remote,
       [](ScriptedHoist& h, int i) { h.drive_left.forced_m_s = i % 60 < 10 ? h.drive_left.target_m_s + 0.3 : NAN; }},
      {"a late step every 1.1 s", Mode::user,
       [](ScriptedHoist& h, int i) {
         if (i % 110 == 0) h.lateness_s = 0.02F;
       }},
      {"4.9 ms late in every step", Mode::user, [](ScriptedHoist& h, int) { h.lateness_s = 0.0049F; }},
      {"a stranger speaks 20 times a second", Mode::user,
       [](ScriptedHoist& h, int i) {
         if (i % 5 == 0) h.extra.push_back({0x1A5, 8, 0, {}});
       }},
      {"both struts send their rates too", Mode::user,
       [](ScriptedHoist& h, int i) {
         h.extra.push_back({0x291, 6, 0, {static_cast<std::uint8_t>(i % 2)}});
         h.extra.push_back({0x292, 6, 0, {static_cast<std::uint8_t>(i % 3)}});
       }},
      {"a strut's chip that stands for 200 ms", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_right.dither = i % 40 >= 20; }},
      {"gyroscopes that stand for 180 ms", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_base.dither = i % 30 >= 18; }},
      {"two quiet struts on a hoist that rolls slowly", Mode::remote,
       [](ScriptedHoist& h, int i) { h.tilt_left.dither = h.tilt_right.dither = i % 20 == 0; }},
      {"a strut livelier than its twin", Mode::user, [](ScriptedHoist& h, int i) { h.tilt_left.dither = i % 10 < 5; }},
      {"one frame in a hundred of every node missing", Mode::user,
       [](ScriptedHoist& h, int i) {
         h.tilt_left.silent = i % 100 == 3;
         h.tilt_right.silent = i % 100 == 17;
         h.tilt_base.silent = i % 100 == 40;
         h.drive_left.silent = i % 100 == 55;
         h.drive_right.silent = i % 100 == 71;
         h.io.silent = i % 100 == 90;
       }},
      {"a bumper node that speaks with every step", Mode::user,
       [](ScriptedHoist& h, int) {
         h.extra.push_back({0x188, 2, 0, {}});
       }},
      {"batteries told every two seconds", Mode::user, [](ScriptedHoist& h, int i) { h.io.battery_silent = i % 200 >= 15; }},
      {"batteries at 23.1 V", Mode::user, [](ScriptedHoist& h, int) { h.io.battery_a_v = h.io.battery_b_v = 11.55; }},
      {"batteries 0.48 V apart", Mode::user, [](ScriptedHoist& h, int) { h.io.battery_a_v = h.io.battery_b_v + 0.48; }},
  };
  for (const Near& near : table) {
    SCOPED_TRACE(near.name);
    ScriptedHoist hoist;
    set_going(hoist, near.mode);
    if (HasFatalFailure()) return;
    for (int i = 0; i < 400; ++i) {
      near.each(hoist, i);
      if (near.mode == Mode::remote && i % 4 == 0) hoist.hold(0.9);
      hoist.step();
      ASSERT_EQ(hoist.state.mode, near.mode) << i << " faults " << hoist.state.latched;
    }
    EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
  }
}

// The tilt nodes remove what a turn adds to their angles, so the limit of 4 degrees is the same in every turn.
TEST(Monitors, H7ATurnExcusesNoSideLean) {
  for (const double yaw_deg_s : {0.0, 20.0, -20.0}) {
    for (const double beta_deg : {1.9, 2.1}) {  // each strut: 3.8 and 4.2 degrees apart
      SCOPED_TRACE(testing::Message() << yaw_deg_s << " deg/s, " << beta_deg << " deg");
      contract::Params params;
      params.slip_stop_s = 10;  // a chassis that turns without its wheels slips; here only the sensor is tested
      ScriptedHoist hoist(params);
      set_going(hoist, Mode::user);
      if (HasFatalFailure()) return;
      hoist.floor_grips = false;
      hoist.tilt_base.yaw_rate_deg_s = yaw_deg_s;
      hoist.lean(6, 10);
      hoist.step(100);
      ASSERT_EQ(hoist.state.mode, Mode::user);
      hoist.tilt_left.beta_deg = beta_deg;
      hoist.tilt_right.beta_deg = -beta_deg;
      const bool trips = beta_deg > 2;
      EXPECT_EQ(hoist.reach(Mode::protective_stop, trips ? 20 : 120), trips);
      EXPECT_EQ(hoist.has_fault(Fault::tilt_implausible), trips);
    }
  }
}

TEST(Monitors, H2AStopThatDoesNotStopLetsGoOfBothDrives) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::remote);
  if (HasFatalFailure()) return;
  hoist.drive_left.forced_m_s = 0.6;  // its servo has lost the wheel
  ASSERT_TRUE(hoist.reach(Mode::protective_stop, 30));
  hoist.drive_left.forced_m_s = 0.1;  // and lets it creep: too slow for a runaway (test_runaway.cpp)
  hoist.drive_left.current_a = 0;
  int ticks = 0;
  while (hoist.drive_right.last_control != 0x00 && ticks < 500) {
    EXPECT_EQ(hoist.drive_right.last_control, 0x0F) << "until then the other wheel brakes under its servo";
    hoist.step();
    ++ticks;
  }
  const int ramp_ticks = 70;  // 0.65 m/s at 1 m/s2, and a little
  EXPECT_GT(ticks, 100);
  EXPECT_LE(ticks, ramp_ticks + 100);
  EXPECT_EQ(hoist.drive_left.last_control, 0x00);
  for (int i = 0; i < 300; ++i) {
    hoist.step();
    ASSERT_EQ(hoist.drive_left.last_control, 0x00) << "and never again by itself";
    ASSERT_EQ(hoist.drive_right.last_control, 0x00);
  }
  EXPECT_TRUE(hoist.has_fault(Fault::overspeed));
  EXPECT_NE(hoist.ask(CommandKind::acknowledge), 0U) << "it still rolls";
  hoist.drive_left.forced_m_s = NAN;
  hoist.step(150);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  hoist.step(5);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(hoist.drive_left.last_control, 0x06);
}

TEST(Monitors, H2AWheelThatNoEncoderShowsIsSeenByTheGyro) {
  for (const double yaw_deg_s : {3.0, 6.0}) {
    SCOPED_TRACE(yaw_deg_s);
    ScriptedHoist hoist;
    set_going(hoist, Mode::user);
    if (HasFatalFailure()) return;
    static_cast<void>(hoist.ask(CommandKind::stop));
    ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
    hoist.step(200);
    EXPECT_EQ(hoist.drive_left.last_control, 0x0F) << "a stop that works holds by servo";
    hoist.tilt_base.yaw_rate_deg_s = yaw_deg_s;
    hoist.step(20);
    EXPECT_EQ(hoist.drive_left.last_control, 0x0F) << "a shove is over sooner";
    hoist.step(20);
    const bool cut = yaw_deg_s > 4;
    EXPECT_EQ(hoist.drive_left.last_control, cut ? 0x00 : 0x0F);
    EXPECT_EQ(hoist.drive_right.last_control, cut ? 0x00 : 0x0F);
  }
}

TEST(Monitors, H4AStaleTiltMeansNoIntentAndNeverTheLastOne) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.tilt_left.silent = true;
  hoist.step(2);
  EXPECT_GT(hoist.out.record.lean_norm, 0.4F);
  hoist.step();
  EXPECT_EQ(hoist.out.record.lean_norm, 0.0F) << "30 ms after the last sample";
  EXPECT_EQ(hoist.out.record.tilt_left_age_ticks, 3);
  EXPECT_EQ(hoist.state.mode, Mode::user);
}

TEST(Monitors, H5ReconnectingTheBusAsksForAnAcknowledgementAndNothingMore) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.bus_up = false;
  hoist.step(100);
  EXPECT_EQ(hoist.state.latched & ~contract::fault_bit(Fault::bus_down), 0U) << "one alarm for one cable";
  hoist.bus_up = true;
  hoist.lean(0);
  hoist.step(250);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

TEST(Monitors, AReplugedNodeIsConfiguredAgainBeforeItCounts) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.tilt_left.silent = true;
  hoist.step(40);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  hoist.tilt_left.written.clear();
  hoist.tilt_left.silent = false;
  hoist.tilt_left.booted = false;  // it lost its power
  hoist.step(150);
  EXPECT_EQ(hoist.tilt_left.written.size(), 2U);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
}

// Within two seconds.
void expect_soft_stop_without_a_new_start(ScriptedHoist& hoist) {
  hoist.worst_deceleration_m_s2 = 0;
  int ticks = 0;
  while (!hoist.state.in_mode.leaving && ticks < 300) {
    hoist.step();
    ++ticks;
  }
  EXPECT_LE(ticks, 200);
  EXPECT_TRUE(hoist.reach(Mode::standby, 300));
  EXPECT_LE(hoist.worst_deceleration_m_s2, 0.5 + 1e-9);
  hoist.lean(0);
  hoist.step(120);
  EXPECT_NE(hoist.ask_mode(Mode::user), 0U);
}

TEST(Monitors, H12BatteryWarnsThenStopsGentlyAndBlocksTheStart) {
  EXPECT_EQ(contract::fault_info(Fault::battery_empty).hazard(), "H12");
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 11.2;  // 22.4 V together
  hoist.step(300);
  EXPECT_TRUE(hoist.has_fault(Fault::battery_low));
  EXPECT_EQ(hoist.state.mode, Mode::user) << "a warning moves nothing";
  hoist.io.battery_a_v = hoist.io.battery_b_v = 10.0;
  expect_soft_stop_without_a_new_start(hoist);
}

// A failed charger: from 30 V on the drives brake less.
TEST(Monitors, H12ASupplyAtWhichTheBrakesGrowWeakStopsGentlyAndBlocksTheStart) {
  EXPECT_EQ(contract::fault_info(Fault::supply_high).hazard(), "H12");
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 14.7;  // on a charger, in the cold
  hoist.step(500);
  EXPECT_EQ(hoist.state.mode, Mode::user);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 14.95;
  expect_soft_stop_without_a_new_start(hoist);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 14.2;
  hoist.step(300);
  EXPECT_FALSE(hoist.has_fault(Fault::supply_high)) << "it ends with its cause";
  EXPECT_EQ(hoist.ask_mode(Mode::user), 0U);
}

// H12: the filter's second, exactly.
TEST(Monitors, H12ADeepSagIsFoundInASecond) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 10.0;
  int low_ticks = 0, empty_ticks = 0;
  for (int i = 1; i <= 300 && empty_ticks == 0; ++i) {
    hoist.step();
    if (low_ticks == 0 && hoist.has_fault(Fault::battery_low)) low_ticks = i;
    if (hoist.has_fault(Fault::battery_empty)) empty_ticks = i;
  }
  EXPECT_NEAR(low_ticks, 62, 12) << "25.6 V to 20 V passes 23 V after 0.62 s, and frames come every 0.1 s";
  EXPECT_NEAR(empty_ticks, 103, 12);
}

// H2
TEST(Monitors, H2ADriveThatDoesNotEnableIsGivenHalfASecond) {
  for (const bool left : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
    int ticks = 0;
    while (hoist.state.mode == Mode::user && ticks < 200) {
      (left ? hoist.drive_left : hoist.drive_right).status = 0x21;
      hoist.step();
      ++ticks;
    }
    EXPECT_NEAR(ticks, 50, 3);
    EXPECT_TRUE(hoist.has_fault(left ? Fault::drive_left_fault : Fault::drive_right_fault));
  }
}

TEST(Monitors, H2ADriveThatDropsOutIsNoticedWithinFiftyMilliseconds) {
  for (const bool is_left : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(6, 250);
    FakeDrive& drive = is_left ? hoist.drive_left : hoist.drive_right;
    const Fault fault = is_left ? Fault::drive_left_fault : Fault::drive_right_fault;
    int steps = 0;
    for (; !hoist.has_fault(fault) && steps < 50; ++steps) {
      drive.status = 0x40;
      hoist.step();
    }
    EXPECT_LE(steps, 8);
    EXPECT_FALSE(hoist.has_fault(Fault::gate_refused)) << "the other wheel may go on until then";
  }
}

// A hoist that may go no faster than this.
ScriptedHoist slow_hoist(double top_m_s) {
  contract::Params slow;
  slow.speed_m_s_max = top_m_s;
  slow.remote_speed_m_s_max = top_m_s;
  return ScriptedHoist(slow);
}

// H6: from 0.1 m/s on.
TEST(Monitors, H6BothStrutsStandingAreFoundOnASlowHoistToo) {
  ScriptedHoist hoist = slow_hoist(0.15);
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 1.0);
  ASSERT_NEAR(hoist.command_m_s(), 0.15, 1e-3);
  hoist.tilt_left.dither = hoist.tilt_right.dither = false;
  hoist.drive_for(36, 1.0);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_frozen));
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

TEST(Monitors, H6AStuckChipMayJumpOnceInAWhile) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 250);
  hoist.tilt_right.dither = false;
  // One jump in every 29 samples is two bends in every thirty.
  int steps = 0;
  for (; !hoist.has_fault(Fault::tilt_frozen) && steps < 300; ++steps) {
    if (steps % 29 == 0) hoist.tilt_right.alpha_deg += 0.01;
    hoist.step();
  }
  EXPECT_LE(steps, 70);
}

TEST(Monitors, H7TheStopOfTheBallJointsIsTheEndHoweverSlowlyItIsReached) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto lean_all = [&](double deg) {
    for (FakeTilt* tilt : {&hoist.tilt_left, &hoist.tilt_right, &hoist.tilt_base}) tilt->alpha_deg = deg;
  };
  for (double deg = 0; deg < 18.0; deg += 0.1) {
    lean_all(deg);
    hoist.step();
  }
  hoist.step(20);
  EXPECT_FALSE(hoist.has_fault(Fault::tilt_implausible));
  for (double deg = 18.0; deg < 19.0; deg += 0.1) {
    lean_all(deg);
    hoist.step();
  }
  hoist.step(20);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible));
}

TEST(Monitors, H12AShortSagDoesNotCount) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 11.1;  // 22.2 V together, for 0.3 s
  hoist.step(30);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 12.8;
  hoist.step(300);
  EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
}

TEST(Monitors, H12UnevenBatteriesWarnWithinTwoSecondsAndMoveNothing) {
  for (const double other_v : {12.25, 13.35}) {
    ScriptedHoist hoist;
    set_going(hoist, Mode::user);
    hoist.io.battery_b_v = other_v;
    int ticks = 0;
    while (!hoist.has_fault(Fault::battery_uneven) && ticks < 400) {
      hoist.step();
      ++ticks;
    }
    EXPECT_LE(ticks, 260) << "0.55 V apart: the filter needs 2.4 s; a volt is there in 0.7 s";
    hoist.io.battery_b_v = 12.8;
    hoist.step(300);
    EXPECT_FALSE(hoist.has_fault(Fault::battery_uneven));
    hoist.io.battery_b_v = 11.8;
    hoist.step(100);
    EXPECT_TRUE(hoist.has_fault(Fault::battery_uneven));
    EXPECT_EQ(hoist.state.mode, Mode::user);
    EXPECT_EQ(hoist.state.stop_cause, 0);
  }
}

// H9: between 5 and 8 degrees the hoist continues slowly, with a warning.
TEST(Monitors, H9ASlopeSlowsGentlyAndLevelFloorFreesAgain) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::remote);
  if (HasFatalFailure()) return;
  ASSERT_GT(hoist.command_m_s(), 0.25);
  const auto floor = [&hoist](double deg) {
    for (FakeTilt* t : {&hoist.tilt_base, &hoist.tilt_left, &hoist.tilt_right}) t->beta_deg = deg;
  };
  floor(5.1);
  hoist.worst_deceleration_m_s2 = 0;
  hoist.drive_for(20, 0.9);
  EXPECT_TRUE(hoist.has_fault(Fault::base_tilt_high));
  hoist.drive_for(100, 0.9);
  EXPECT_NEAR(hoist.command_m_s(), 0.2, 1e-3);
  EXPECT_LE(hoist.worst_deceleration_m_s2, 0.5 + 1e-9);
  EXPECT_EQ(hoist.out.record.speed_cause, static_cast<int>(contract::SpeedCause::slope));
  hoist.drive_for(300, -1.0);
  EXPECT_NEAR(hoist.command_m_s(), -0.2, 1e-3) << "backward too";
  floor(4.5);
  hoist.drive_for(100, -1.0);
  EXPECT_TRUE(hoist.has_fault(Fault::base_tilt_high)) << "it does not come and go";
  floor(3.9);
  hoist.drive_for(200, -1.0);
  EXPECT_FALSE(hoist.has_fault(Fault::base_tilt_high));
  EXPECT_LT(hoist.command_m_s(), -0.25);
  EXPECT_EQ(hoist.out.record.speed_cause, static_cast<int>(contract::SpeedCause::none));
  EXPECT_EQ(hoist.state.mode, Mode::remote);
}

TEST(Monitors, H9NothingStartsOnASteepRampAndASilentSensorIsNoSlope) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (FakeTilt* t : {&hoist.tilt_base, &hoist.tilt_left, &hoist.tilt_right}) t->alpha_deg = -8.3;
  hoist.step(60);
  EXPECT_TRUE(hoist.has_fault(Fault::base_tilted));
  EXPECT_NE(hoist.ask_mode(Mode::user), 0U);
  EXPECT_NE(hoist.ask(CommandKind::acknowledge), 0U) << "it still stands there";
  for (FakeTilt* t : {&hoist.tilt_base, &hoist.tilt_left, &hoist.tilt_right}) t->alpha_deg = -2;
  hoist.step(150);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);

  ScriptedHoist other;
  set_going(other, Mode::user);
  other.tilt_base.slew_deg = 99;
  other.tilt_base.beta_deg = 9;
  other.step(3);
  other.tilt_base.silent = true;
  other.step(100);
  EXPECT_TRUE(other.has_fault(Fault::tilt_base_lost));
  EXPECT_FALSE(other.has_fault(Fault::base_tilted)) << "a held value is no reading";
}

int ticks_until_leaving(ScriptedHoist& hoist, int limit) {
  int ticks = 0;
  while (hoist.state.mode == Mode::user && !hoist.state.in_mode.leaving && ticks < limit) {
    hoist.step();
    ++ticks;
  }
  return ticks;
}

TEST(Monitors, H16APatientDrawnAlongWithoutAStepStopsGently) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  if (HasFatalFailure()) return;
  hoist.step(1000);
  ASSERT_EQ(hoist.state.mode, Mode::user) << "a swaying patient walks";
  hoist.sway_deg = 0;
  const int ticks = ticks_until_leaving(hoist, 400);
  EXPECT_GT(ticks, 100);
  EXPECT_LE(ticks, 210);
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
  EXPECT_EQ(contract::fault_info(Fault::patient_hanging).hazard(), "H16");
  EXPECT_EQ(contract::fault_info(Fault::patient_hanging).priority, contract::Priority::high);
  hoist.worst_deceleration_m_s2 = 0;
  ASSERT_TRUE(hoist.reach(Mode::standby, 300));
  EXPECT_LE(hoist.worst_deceleration_m_s2, 0.5 + 1e-9);
  // The alarm stays while the patient hangs, and some time after, so that it can be read; until then nothing starts.
  hoist.lean(6);
  hoist.step(1000);
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
  EXPECT_NE(hoist.ask_mode(Mode::user), 0U);
  hoist.lean(1);
  hoist.step(480);
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
  hoist.step(50);
  EXPECT_FALSE(hoist.has_fault(Fault::patient_hanging));
}

TEST(Monitors, H16ALeanPastTenDegreesMayLastTwoSeconds) {
  for (const double lean_deg : {9.8, 10.2}) {
    SCOPED_TRACE(lean_deg);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(lean_deg, 0);
    const int ticks = ticks_until_leaving(hoist, 3000);
    EXPECT_EQ(hoist.has_fault(Fault::patient_hanging), lean_deg > 10);
    if (lean_deg > 10) {
      EXPECT_NEAR(ticks, 200, 8);
    }
  }
}

TEST(Monitors, H16SmallSwayIsNoStepAndSlowRollingNoDrawing) {
  // 5 mm from side to side at 0.8 m: 0.18 degrees either way.
  ScriptedHoist small;
  set_going(small, Mode::user);
  small.sway_deg = 0.18;
  EXPECT_LE(ticks_until_leaving(small, 600), 400);
  EXPECT_TRUE(small.has_fault(Fault::patient_hanging));
  // 8 mm: a step.
  ScriptedHoist step;
  set_going(step, Mode::user);
  step.sway_deg = 0.29;
  EXPECT_EQ(ticks_until_leaving(step, 3000), 3000);
  // From 0.1 m/s on the patient may be dragged; below, the rule does not apply.
  ScriptedHoist stroll = slow_hoist(0.15);
  ASSERT_TRUE(stroll.start(Mode::user));
  stroll.sway_deg = 0;
  stroll.lean_gently(6, 700);
  EXPECT_TRUE(stroll.has_fault(Fault::patient_hanging));
  ScriptedHoist crawl = slow_hoist(0.095);
  ASSERT_TRUE(crawl.start(Mode::user));
  crawl.sway_deg = 0;
  crawl.lean_gently(6, 1000);
  EXPECT_GT(crawl.command_m_s(), 0.09);
  EXPECT_EQ(crawl.state.mode, Mode::user);
  EXPECT_FALSE(crawl.has_fault(Fault::patient_hanging));
}

// The harness moves evenly to and fro. 6 mm at 0.8 m, 0.43 degrees, back within 0.8 s are a step. Each way lasts less than the two seconds in
// which a step is due.
TEST(Monitors, H16ADriftIsNoStep) {
  constexpr int kSwingTicks = 80, kWayTicks = 185;
  for (const bool drifts : {true, false}) {
    SCOPED_TRACE(drifts);
    const double deg_per_tick = 0.4297 / (kSwingTicks + (drifts ? 5 : -5));
    ScriptedHoist hoist;
    set_going(hoist, Mode::user);
    if (HasFatalFailure()) return;
    hoist.sway_deg = 0;
    double aside_deg = -deg_per_tick * kWayTicks / 2;
    int ticks = 0;
    while (hoist.state.mode == Mode::user && !hoist.state.in_mode.leaving && ticks < 2000) {
      aside_deg += ticks / kWayTicks % 2 == 0 ? deg_per_tick : -deg_per_tick;
      hoist.tilt_left.beta_deg = hoist.tilt_right.beta_deg = aside_deg;
      hoist.step();
      ++ticks;
    }
    EXPECT_EQ(hoist.has_fault(Fault::patient_hanging), drifts);
    EXPECT_EQ(ticks < 300, drifts) << "one more step may end the walk before it; then two seconds";
  }
}

// Steps until REMOTE is being left, with the stick held; -1 when it is not within `limit` steps.
int driven_until_leaving(ScriptedHoist& hoist, int limit) {
  for (int i = 0; i < limit; i += 4) {
    hoist.drive_for(4, 0.9);
    if (hoist.state.in_mode.leaving) return i;
  }
  return -1;
}

TEST(Monitors, H16WhoIsDrivenAndNeitherWalksNorStandsUprightIsDragged) {
  for (const double lean_deg : {4.0, -4.0, 7.5}) {
    SCOPED_TRACE(lean_deg);
    ScriptedHoist hoist;
    set_going(hoist, Mode::remote);
    hoist.lean(lean_deg);
    hoist.drive_for(1000, 0.9);
    ASSERT_EQ(hoist.state.mode, Mode::remote) << "who sways walks";
    hoist.sway_deg = 0;
    const int ticks = driven_until_leaving(hoist, 400);
    EXPECT_GT(ticks, 100);
    EXPECT_LE(ticks, 210);
    EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
  }
}

TEST(Monitors, H16AnEmptyHoistThatIsDrivenDoesNotHang) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::remote);
  hoist.sway_deg = 0;
  hoist.lean(2.8);  // its springs, its zeros and the sensors' error together
  hoist.drive_for(2000, 0.9);
  EXPECT_EQ(hoist.state.mode, Mode::remote);
  EXPECT_FALSE(hoist.has_fault(Fault::patient_hanging));
  // But a large lean for two seconds means being dragged, whatever the sway.
  hoist.sway_deg = 0.4;
  hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 0.1;
  hoist.lean(11);
  for (int i = 0; i < 360 && !hoist.state.in_mode.leaving; i += 4) hoist.drive_for(4, 0.9);
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
  EXPECT_TRUE(hoist.state.in_mode.leaving);
}

// An empty hoist leans for a moment when it starts or brakes. A patient who takes no steps and begins to lean is found one second later.
TEST(Monitors, H16ALeanOfLessThanASecondOnAnEmptyHoistStopsNobody) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::remote);
  hoist.sway_deg = 0;
  hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 1.5;
  const auto lean_for = [&hoist](double lean_deg, int ticks) {
    hoist.lean(lean_deg);
    int driven = 0;
    for (; driven < ticks && !hoist.state.in_mode.leaving; ++driven) hoist.drive_for(1, 0.9);
    return driven;
  };
  for (int moment = 0; moment < 4; ++moment) {
    ASSERT_EQ(lean_for(2.9, 300), 300);
    ASSERT_EQ(lean_for(3.2, 99), 99);
    ASSERT_FALSE(hoist.has_fault(Fault::patient_hanging));
  }
  ASSERT_EQ(lean_for(2.9, 1), 1);
  EXPECT_EQ(lean_for(3.2, 200), 100) << "the time without steps counts from before the lean";
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
}

// An exercise that waits for a lagging patient rolls slower than 0.1 m/s, or stands: the alarm ends it too.
TEST(Monitors, H16NobodyIsWaitedForWithoutEnd) {
  struct Case {
    double lean_deg, sway_deg;
    bool held, ends;
  };
  for (const auto& [lean_deg, sway_deg, held, ends] :
       {Case{-8.0, 0.0, true, true}, Case{-8.0, 0.4, true, false}, Case{-9.6, 0.4, true, true}, Case{-9.6, 0.4, false, false}}) {
    SCOPED_TRACE(testing::Message() << lean_deg << " deg, sway " << sway_deg << (held ? "" : ", let go"));
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(hoist.ask_guided({contract::GuidedShape::straight, false, 10.0, 0, 0.3, 1}), 0U);
    ASSERT_TRUE(hoist.run_until_powered());
    hoist.drive_for(200, 0);
    ASSERT_GT(hoist.command_m_s(), 0.25);
    hoist.sway_deg = sway_deg;
    hoist.tilt_left.slew_deg = hoist.tilt_right.slew_deg = 0.1;
    hoist.lean(lean_deg);
    const auto goes_on = [&hoist] { return hoist.state.mode == Mode::guided && !hoist.state.in_mode.leaving; };
    for (int i = 0; i < 600 && goes_on(); ++i) {
      // Steps on the spot while the wheels stand do not count.
      if (lean_deg < -9) hoist.tilt_left.beta_deg = hoist.tilt_right.beta_deg = i / 50 % 2 == 0 ? sway_deg : -sway_deg;
      hoist.hold(0, 0, held);
      hoist.step();
    }
    EXPECT_EQ(hoist.has_fault(Fault::patient_hanging), ends);
    EXPECT_EQ(goes_on(), !ends);
  }
}

// A chassis that turns at 15 deg/s while its wheels go straight (H10's own figure), in both directions and both modes.
TEST(Monitors, H10ASlipIsMarkedAtOnceAndStopsGentlyWhenItLasts) {
  EXPECT_EQ(contract::fault_info(Fault::wheel_slip).hazard(), "H10");
  for (const double yaw_deg_s : {15.0, -15.0}) {
    for (const Mode mode : {Mode::user, Mode::remote}) {
      SCOPED_TRACE(yaw_deg_s);
      ScriptedHoist hoist;
      set_going(hoist, mode);
      if (HasFatalFailure()) return;
      hoist.tilt_base.yaw_rate_deg_s = yaw_deg_s;
      hoist.worst_deceleration_m_s2 = 0;
      int marked = -1, stopping = -1;
      for (int i = 1; i <= 140 && stopping < 0; ++i) {
        if (mode == Mode::remote) hoist.hold(0.9);
        hoist.step();
        if (marked < 0 && (hoist.out.record.slip_state & 1U) != 0) marked = i;
        if (hoist.state.in_mode.leaving) stopping = i;
      }
      EXPECT_GT(marked, 0);
      EXPECT_LE(marked, 20) << "noticed within 200 ms";
      EXPECT_GE(stopping, marked + 98) << "a shorter slip stops nobody";
      EXPECT_LE(stopping, marked + 100);
      EXPECT_TRUE(hoist.has_fault(Fault::wheel_slip));
      for (int i = 0; i < 200 && hoist.state.mode != Mode::standby; ++i) {
        if (mode == Mode::remote) hoist.hold(0.9);
        hoist.step();
      }
      EXPECT_EQ(hoist.state.mode, Mode::standby);
      EXPECT_LE(hoist.worst_deceleration_m_s2, 0.5 + 1e-9) << "R1: the gentle ramp";
      hoist.step();
      EXPECT_FALSE(hoist.has_fault(Fault::wheel_slip)) << "with the drives off nothing slips";
    }
  }
}

// Struts that send their rates (research switch) feel the hoist's turn as pitch and roll while they lean: 20 s of one bend are no lost zero.
TEST(Monitors, H8ALongTurnWithALeanIsNoLostZero) {
  for (const double turn_deg_s : {34.0, -34.0})
    for (const double lost_deg_s : {0.0, 6.0}) {
      SCOPED_TRACE(turn_deg_s);
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      hoist.lean_gently(10, 100);
      hoist.tilt_left.beta_deg = hoist.tilt_right.beta_deg = 3;
      hoist.tilt_base.yaw_rate_deg_s = turn_deg_s;
      for (int i = 0; i < 2000; ++i) {
        contract::CanFrame rates{contract::pdo_cob_id(contract::Pdo::tilt_tx2, contract::Node::tilt_left), 6, 0, {}};
        constexpr contract::PdoSlot kYaw = contract::pdo_slot(contract::Pdo::tilt_tx2, 0x2110, 1),
                                    kPitch = contract::pdo_slot(contract::Pdo::tilt_tx2, 0x2110, 2),
                                    kRoll = contract::pdo_slot(contract::Pdo::tilt_tx2, 0x2110, 3);
        // As firmware/sim/plant.cpp turns a sensor that leans forward and right.
        contract::write_slot(rates, kYaw, std::lround(turn_deg_s * std::cos(10 * kDeg) * 100));
        contract::write_slot(rates, kPitch, std::lround(turn_deg_s * std::sin(3 * kDeg) * 100));
        contract::write_slot(rates, kRoll, std::lround((lost_deg_s - turn_deg_s * std::sin(10 * kDeg)) * 100));
        hoist.extra.push_back(rates);
        hoist.step();
      }
      EXPECT_EQ(hoist.has_fault(Fault::tilt_sensor_fault), lost_deg_s != 0);
    }
}

// Slower slips, straight on and in a bend of 40 deg/s, are noticed within 200 ms too.
TEST(Monitors, H10ASlowSlipIsNoticedWithin200ms) {
  for (const double slip_deg_s : {8.0, -14.0}) {
    SCOPED_TRACE(slip_deg_s);
    ScriptedHoist hoist;
    set_going(hoist, Mode::remote);
    if (HasFatalFailure()) return;
    const bool bend = slip_deg_s < 0;
    if (bend) hoist.drive_for(300, 0.3, 1.0);
    hoist.tilt_base.yaw_rate_deg_s = slip_deg_s;
    for (int i = 0; i < 20; ++i) hoist.drive_for(1, bend ? 0.3 : 0.9, bend ? 1.0 : 0.0);
    EXPECT_NE(hoist.out.record.slip_state & 1U, 0U);
  }
}

TEST(Monitors, H10AShortSlipMarksTheTrackAndNothingElse) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  for (int burst = 0; burst < 5; ++burst) {
    hoist.tilt_base.yaw_rate_deg_s = burst % 2 == 0 ? 15.0 : -15.0;
    hoist.step(80);  // with the 200 ms in which both must agree again: just under a second
    EXPECT_NE(hoist.out.record.slip_state & 1U, 0U);
    hoist.tilt_base.yaw_rate_deg_s = 0;
    hoist.step(60);
    EXPECT_EQ(hoist.out.record.slip_state & 1U, 0U);
  }
  EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
  EXPECT_EQ(hoist.state.mode, Mode::user);
}

TEST(Monitors, H22ALateStepInStandbyIsCountedOnly) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.lateness_s = 0.2F;
  hoist.step();
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(hoist.out.record.overruns, 1U);
  hoist.lateness_s = 0.0019F;
  hoist.step();
  EXPECT_EQ(hoist.out.record.overruns, 1U);
  hoist.lateness_s = 0.0021F;
  hoist.step();
  EXPECT_EQ(hoist.out.record.overruns, 2U) << "more than 2 ms is counted";
}

TEST(Monitors, EveryFaultOfTheTableIsTestedHereOrNamed) {
  contract::FaultBits covered = 0;
  for (const Trip& trip : trips()) covered |= contract::fault_bit(trip.fault);
  // Tested by name: fall in test_budgets.cpp, the driver and the server in unit/core/test_remote.cpp, its console in unit/core/test_alarm.cpp, batteries above, STOP in
  // unit/core/test_modes.cpp, the gate in unit/core/test_gate.cpp and below, what ends in FAULT or
  // EMERGENCY_STOP in test_out_of_service.cpp.
  for (const Fault fault :
       {Fault::fall_detected, Fault::remote_command_lost, Fault::server_lost, Fault::battery_low, Fault::battery_empty, Fault::stop_pressed,
        Fault::gate_refused, Fault::wheel_slip, Fault::battery_uneven, Fault::base_tilt_high, Fault::patient_hanging, Fault::emergency_stop,
        Fault::parameters_corrupt, Fault::control_fault, Fault::console_lost, Fault::supply_high})
    covered |= contract::fault_bit(fault);
  for (const auto& fault : contract::kFaults) EXPECT_NE(covered & contract::fault_bit(fault), 0U) << fault.name;
}

TEST(Monitors, H1TheGateStopsAControllerThatGoesWrong) {
  ScriptedHoist hoist;
  set_going(hoist, Mode::user);
  const double going_m_s = hoist.drive_left.target_m_s;
  // Damaged memory of the controller: from one step to the next it commands full speed.
  hoist.state.limiter.start_from(hoist.state.params, 0.65, 0);
  hoist.step();
  EXPECT_TRUE(hoist.has_fault(Fault::gate_refused));
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  const double before_m_s = hoist.drive_left.target_m_s;
  EXPECT_LT(before_m_s, going_m_s) << "neither wheel gets it";
  EXPECT_GE(before_m_s, going_m_s - 0.0101) << "nor a jolt";
  EXPECT_NEAR(hoist.drive_right.target_m_s, before_m_s, 1e-3) << "nor a turn";
  hoist.worst_deceleration_m_s2 = 0;
  for (int i = 0; i < 80; ++i) {
    hoist.step();
    EXPECT_NEAR(hoist.drive_right.target_m_s, hoist.drive_left.target_m_s, 1e-3);
  }
  EXPECT_EQ(hoist.drive_left.target_m_s, 0);
  EXPECT_LE(hoist.worst_deceleration_m_s2, 1.0 + 1e-9);
}

// A delayed serial line delivers the answers to several SYNCs at once: one late step, not a frozen sensor.
TEST(TiltSensorTest, H6AHeldUpLineIsNoFrozenSensor) {
  TiltSensor sensor;
  contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::tilt_tx1, contract::Node::tilt_left), 6, 0, {}};
  contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2120), tilt_status::kValid | tilt_status::kConverged);
  const auto hand_over = [&](int counter, int frames) {
    sensor.next_tick();
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2121), counter);
    for (int i = 0; i < frames; ++i) sensor.take_angles(frame);
  };
  hand_over(1, 1);
  hand_over(1, 6);
  EXPECT_EQ(sensor.repeated_frames(), 1);
  hand_over(2, 6);
  EXPECT_LE(sensor.repeated_frames(), 1);
  for (int i = 0; i < 3; ++i) hand_over(2, 1);
  EXPECT_GE(sensor.repeated_frames(), 3) << "a counter that stands over steps still counts";
}

}  // namespace
}  // namespace hoist::core::test
