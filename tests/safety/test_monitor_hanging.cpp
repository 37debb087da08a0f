// The hanging patient (H16) by example: which movements of the harness count as steps, and which situations raise and end the alarm
// (control/core/monitor/patient_hanging.hpp, DECISIONS 160). Random patients are in tests/safety/test_tilt_rules.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/safety/monitor_bench.hpp"

namespace hoist::core::test {
namespace {

// Moves the lean of both struts, or leaves all three sensors silent.
class Harness {
 public:
  explicit Harness(Estimate& sensed) : sensed_(sensed) {}
  void step(double forward_deg, double right_deg, bool silent) {
    ++sample_.counter;
    for (TiltSensor* tilt : {&sensed_.left_strut, &sensed_.right_strut, &sensed_.base}) {
      tilt->next_tick();
      sample_.alpha_deg = tilt == &sensed_.base ? 0 : forward_deg;
      sample_.beta_deg = tilt == &sensed_.base ? 0 : right_deg;
      if (!silent) send_angles(*tilt, sample_);
    }
  }

 private:
  Estimate& sensed_;
  TiltSample sample_;
};

// ----- what a step is

struct Leg {
  int ticks;
  double to_mm;  // to the right, at an even pace
  enum Kind { rolls, creeps, waits, silent } kind = rolls;
};
struct Walk {
  const char* name;
  std::vector<Leg> legs;
  std::vector<int> steps;  // counted from 1
};

// 6 mm take 55 ticks at 0.11 mm a tick, 75 at 0.0805. The last 0.8 s are kept in tenths of a second, counted from the last step on: this tenth and
// the seven before it, so 75 ticks ago is remembered only from the middle of a tenth on.
const std::vector<Walk> kWalks = {
    {"one step", {{50, 0}, {60, 6.6}, {200, 6.6}}, {105}},
    {"a step and a long glide", {{50, 0}, {250, 27.5}}, {105}},
    {"a slow drift", {{50, 0}, {350, 24.5}}, {}},
    {"75 ticks, the last in the middle of a tenth", {{50, 0}, {80, 6.44}, {160, 6.44}}, {125}},
    {"75 ticks, the last in the beginning of a tenth", {{56, 0}, {120, 9.66}, {160, 9.66}}, {135}},
    {"tenths begin with the step", {{50, 0}, {55, 6.05}, {26, 6.05}, {120, -3.61}, {160, -3.61}}, {105, 210}},
    {"each way", {{50, 0}, {55, 6.05}, {55, 0}, {55, 6.05}, {55, 0}, {130, 0}}, {105, 160, 215, 270}},
    {"the same way after a turn of half a step", {{50, 0}, {55, 6.05}, {30, 2.9}, {60, 9.5}, {150, 9.5}}, {105, 190}},
    {"the same way after less of a turn", {{50, 0}, {55, 6.05}, {30, 3.2}, {60, 9.8}, {150, 9.8}}, {105}},
    {"a turn counts from the farthest place", {{50, 0}, {85, 9.35}, {30, 6.2}, {60, 12.8}, {150, 12.8}}, {105, 220}},
    {"a turn that nearly was a step", {{50, 0}, {55, 6.05}, {50, 0.55}, {60, 7.15}, {150, 7.15}}, {105, 210}},
    {"only what follows a step counts for the next one", {{50, 0}, {10, 6.5}, {10, 3.2}, {10, 6.4}, {150, 6.4}}, {60}},
    {"a glide back past the place of the step", {{50, 0}, {110, 12.1}, {200, -9.9}, {10, -9.9}}, {105, 215}},
    {"a twitch within a tenth", {{50, 0}, {4, -4}, {4, 2.5}, {150, 2.5}}, {58}},
    {"no sensor is heard meanwhile", {{50, 0}, {30, 3.3}, {60, 3.3, Leg::silent}, {30, 6.6}, {150, 6.6}}, {165}},
    {"the hoist waits meanwhile", {{50, 0}, {30, 3.3}, {90, 3.3, Leg::waits}, {30, 6.6}, {150, 6.6}}, {195}},
    {"the hoist is held back, and creeps", {{50, 0}, {60, 6.6, Leg::creeps}, {200, 6.6, Leg::creeps}}, {105}},
    {"no step ends a wait", {{50, 0}, {200, 22, Leg::waits}, {10, 22}}, {}},
};

TEST(HangingSteps, H16EachWalkHasItsStepsToEitherSide) {
  for (const Walk& walk : kWalks) {
    for (const double side : {1.0, -1.0}) {
      SCOPED_TRACE(testing::Message() << walk.name << (side > 0 ? ", right" : ", left"));
      MonitorBench bench;
      bench.params.strut_length_m = 0.8;
      bench.params.hang_still_s = 1;
      bench.sensed.odometry.speed_m_s = 0.3;
      Harness harness(bench.sensed);
      PatientHanging monitor;
      double at_mm = 0;
      int tick = 0, silent_ticks = 0, without_step_ticks = 0;
      for (const Leg& leg : walk.legs) {
        const double from_mm = at_mm;
        for (int i = 1; i <= leg.ticks; ++i) {
          at_mm = from_mm + (leg.to_mm - from_mm) * i / leg.ticks;
          bench.sensed.odometry.standing_still = leg.kind == Leg::waits;
          bench.held_back = leg.kind == Leg::waits || leg.kind == Leg::creeps;
          harness.step(0, side * at_mm / 800 / kDeg, leg.kind == Leg::silent);
          silent_ticks = leg.kind == Leg::silent ? silent_ticks + 1 : 0;
          const bool stepped = std::find(walk.steps.begin(), walk.steps.end(), ++tick) != walk.steps.end();
          // Without angles nothing is known; 30 ms are no silence yet.
          without_step_ticks = stepped || silent_ticks >= 3 ? 0 : without_step_ticks + 1;
          ASSERT_EQ(monitor.check(bench.view()), without_step_ticks >= 100) << "tick " << tick;
        }
      }
    }
  }
}

// ----- what raises the alarm

constexpr int kNever = 0;

struct Situation {
  const char* name;
  Mode mode;
  double forward_deg, right_deg, speed_m_s;
  int alarm_tick;  // counted from 1
  bool moving = true, held_back = false, silent = false;
};

TEST(HangingSituations, H16EachRaisesTheAlarmInItsTimeOrNever) {
  constexpr int kLean = 120, kStill = 200;
  constexpr double kWalks_m_s = 0.3, kCreeps_m_s = 0.06;
  for (const Situation& one : {
           Situation{"dragged upright", Mode::user, 0, 0, kWalks_m_s, kStill},
           {"dragged backward", Mode::user, 0, 0, -kWalks_m_s, kStill},
           {"creeps", Mode::user, 0, 0, kCreeps_m_s, kNever},
           {"creeps, held back", Mode::guided, 4, 0, kCreeps_m_s, kStill, true, true},
           {"waits", Mode::guided, 4, 0, 0, kStill, true, true},
           {"waits, empty", Mode::guided, 0, 0, 0, kNever, true, true},
           {"led, empty", Mode::remote, 2.9, 0, kWalks_m_s, kNever},
           {"led, loaded", Mode::remote, 0, -3.1, kWalks_m_s, kStill},
           {"led, loaded, in an exercise", Mode::guided, 3.1, 0, kWalks_m_s, kStill},
           {"leans far", Mode::user, 10.2, 0, 0, kLean},
           {"leans far backward, led", Mode::remote, -10.2, 0, 0, kLean},
           {"leans far to both sides", Mode::user, 7.5, 7.5, 0, kLean},
           {"leans less to both sides", Mode::user, 7, -7, 0, kNever},
           {"leans far, off", Mode::standby, 12, 0, kWalks_m_s, kNever, false},
           {"pushed upright, off", Mode::user, 0, 0, kWalks_m_s, kNever, false},
           {"leans far, unheard", Mode::user, 12, 0, kWalks_m_s, kNever, true, false, true},
           {"waits, unheard", Mode::guided, 12, 0, 0, kNever, true, true, true},
       }) {
    SCOPED_TRACE(one.name);
    MonitorBench bench;
    // Between two steps: the nearer one counts.
    bench.params.hang_tilt_s = 0.01 * kLean + 0.004;
    bench.params.hang_still_s = 0.01 * kStill - 0.004;
    bench.mode = one.mode;
    bench.held_back = one.held_back;
    bench.sensed.odometry.speed_m_s = one.speed_m_s;
    bench.sensed.odometry.standing_still = one.speed_m_s == 0;
    Harness harness(bench.sensed);
    PatientHanging monitor;
    // The patient leans before the motion begins, so that the lean is no step.
    bench.moving = false;
    harness.step(one.forward_deg, one.right_deg, false);
    EXPECT_FALSE(monitor.check(bench.view()));
    for (int i = 0; i < 3; ++i) harness.step(one.forward_deg, one.right_deg, one.silent);
    bench.moving = one.moving;
    for (int tick = 1; tick <= 300; ++tick) {
      harness.step(one.forward_deg, one.right_deg, one.silent);
      ASSERT_EQ(monitor.check(bench.view()), one.alarm_tick != kNever && tick >= one.alarm_tick) << "tick " << tick;
    }
  }
}

// The time without a step and the lean of a loaded harness both count, and that which comes last decides.
TEST(HangingSituations, H16ALedHoistIsLoadedForTheLastSecond) {
  for (const int loaded_tick : {20, 100, 101, 150, 260}) {
    SCOPED_TRACE(loaded_tick);
    MonitorBench bench;
    bench.mode = Mode::remote;
    bench.params.hang_still_s = 2;
    bench.sensed.odometry.speed_m_s = 0.3;
    Harness harness(bench.sensed);
    PatientHanging monitor;
    for (int tick = 1; tick <= 400; ++tick) {
      harness.step(tick >= loaded_tick ? 4 : 2, 0, false);
      ASSERT_EQ(monitor.check(bench.view()), tick >= std::max(200, loaded_tick + 99)) << "tick " << tick;
    }
  }
}

// ----- what ends it

TEST(HangingSituations, H16TheAlarmEndsAfterFiveUprightSecondsOnAStandingHoist) {
  struct Rest {
    const char* name;
    double forward_deg, right_deg;
    bool moving, silent, ends;
    double neutral_m = 0;
  };
  for (const Rest& one :
       {Rest{"upright", 0, 0, false, false, true}, Rest{"nearly upright", 4.8, 0, false, false, true},
        Rest{"not quite upright", 3.7, 3.7, false, false, false}, Rest{"upright, moving", 0, 0, true, false, false},
        Rest{"unheard", 0, 0, false, true, false},
        // 0.08 m of 0.8 m are 5.73 degrees.
        Rest{"stooped, at the neutral that was set", 7.5, 0, false, false, true, 0.08},
        Rest{"stooped, aside", 5.7, 1.9, false, false, true, 0.08}, Rest{"stooped, and leaning", 7.9, 0, false, false, false, 0.08},
        Rest{"stooped, upright for once", 1, 0, false, false, true, 0.08}}) {
    SCOPED_TRACE(one.name);
    MonitorBench bench;
    bench.params.hang_tilt_rad = 10 * kDeg;
    bench.params.strut_length_m = 0.8;
    bench.params.neutral_lean_m = one.neutral_m;
    Harness harness(bench.sensed);
    PatientHanging monitor;
    for (int tick = 1; tick <= 600; ++tick) {
      harness.step(one.forward_deg, one.right_deg, one.silent);
      bench.moving = one.moving || tick == 1;
      bench.latched = contract::fault_bit(Fault::patient_hanging);
      const bool alarm = monitor.check(bench.view());
      if (tick == 501 || tick == 502) continue;  // rounding decides in which of these
      ASSERT_EQ(alarm, !one.ends || tick < 501) << "tick " << tick;
    }
    bench.latched = contract::fault_bit(Fault::io_lost);
    harness.step(one.forward_deg, one.right_deg, one.silent);
    EXPECT_FALSE(monitor.check(bench.view()));
  }
}

}  // namespace
}  // namespace hoist::core::test
