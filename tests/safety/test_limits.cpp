// Limits that the tables of test_monitors.cpp would not miss if they were twice as lax (tests/mutants): each is approached from where it alone
// decides.
#include <gtest/gtest.h>

#include "control/core/modes/mode_list.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::Fault;
using contract::Mode;

// Steps until the fault is in force; `most` when it never came. `each` runs before every step.
template <typename F>
int steps_to(ScriptedHoist& hoist, Fault fault, int most, F&& each) {
  int steps = 0;
  while (!hoist.has_fault(fault) && steps < most) {
    each(steps);
    hoist.step();
    ++steps;
  }
  return steps;
}
const auto kNothing = [](int) {};

TEST(Limits, H16DrawnAlongSlowlyCounts) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.sway_deg = 0;
  hoist.lean_gently(3, 100);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 1.5 * hoist.state.params.hang_speed_m_s;
  EXPECT_LE(steps_to(hoist, Fault::patient_hanging, 400, kNothing), 300);
  EXPECT_TRUE(hoist.has_fault(Fault::patient_hanging));
}

TEST(Limits, H6BothStrutsStandingCountsFromTenCentimetresASecond) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 0.5);
  ASSERT_GT(hoist.command_m_s(), 0.11);
  ASSERT_LT(hoist.command_m_s(), 0.19);
  hoist.tilt_left.dither = hoist.tilt_right.dither = false;
  EXPECT_LE(steps_to(hoist, Fault::tilt_frozen, 100, [&](int) { hoist.hold(0.5); }), 32);
}

TEST(Limits, H6AStuckChipMayJumpOnceInAWhile) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 250);
  hoist.tilt_right.dither = false;
  // One jump in every 29 samples is two bends in every thirty.
  EXPECT_LE(steps_to(hoist, Fault::tilt_frozen, 300,
                     [&](int i) {
                       if (i % 29 == 0) hoist.tilt_right.alpha_deg += 0.01;
                     }),
            70);
}

TEST(Limits, H7TheStopOfTheBallJointsIsTheEndHoweverSlowlyItIsReached) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto lean_all = [&](double deg) {
    for (FakeTilt* tilt : {&hoist.tilt_left, &hoist.tilt_right, &hoist.tilt_base}) tilt->alpha_deg = deg;
  };
  for (double deg = 0; deg < 16.5; deg += 0.1) {
    lean_all(deg);
    hoist.step();
  }
  hoist.step(20);
  EXPECT_FALSE(hoist.has_fault(Fault::tilt_implausible));
  for (double deg = 16.5; deg < 17.5; deg += 0.1) {
    lean_all(deg);
    hoist.step();
  }
  hoist.step(20);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible));
}

TEST(Limits, H2ADriveThatIsNeverEnabledIsToldAfterHalfASecond) {
  for (const bool is_left : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    FakeDrive& drive = is_left ? hoist.drive_left : hoist.drive_right;
    ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
    const int steps = steps_to(hoist, is_left ? Fault::drive_left_fault : Fault::drive_right_fault, 200, [&](int) { drive.status = 0x40; });
    EXPECT_GE(steps, 45) << is_left;
    EXPECT_LE(steps, 55) << is_left;
  }
}

TEST(Limits, H2ADriveThatDropsOutIsNoticedWithinFiftyMilliseconds) {
  for (const bool is_left : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(6, 250);
    FakeDrive& drive = is_left ? hoist.drive_left : hoist.drive_right;
    EXPECT_LE(steps_to(hoist, is_left ? Fault::drive_left_fault : Fault::drive_right_fault, 50, [&](int) { drive.status = 0x40; }), 8);
    EXPECT_FALSE(hoist.has_fault(Fault::gate_refused)) << "the other wheel may go on until then";
  }
}

TEST(Limits, H12EmptyBatteriesAreKnownAfterASecondAndABit) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.io.battery_a_v = hoist.io.battery_b_v = 10.0;  // from 25.6 V to 20: 22 V are passed after 1.03 time constants
  const int steps = steps_to(hoist, Fault::battery_empty, 400, kNothing);
  EXPECT_GE(steps, 90);
  EXPECT_LE(steps, 125);
}

}  // namespace
}  // namespace hoist::core::test
