// From power-up to standby, and the two motion modes.
#include <gtest/gtest.h>

#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::Node;

// H23: every start of the control program, also after a crash, begins in INIT.
TEST(Start, ComesUpByItselfWhenAllNodesAnswer) {
  ScriptedHoist hoist;
  EXPECT_EQ(hoist.state.mode, Mode::init);
  ASSERT_TRUE(hoist.to_standby());
  EXPECT_LT(hoist.tick_number, 200U) << "two seconds are enough for twenty SDO transfers";
  EXPECT_EQ(hoist.out.record.simulated, 1);
  EXPECT_EQ(hoist.state.latched, 0U);
  EXPECT_EQ(hoist.events.front().kind, EventKind::core_started);
  EXPECT_EQ(hoist.count(EventKind::node_changed), 6);
  EXPECT_EQ(hoist.out.record.bus_refused, 0U);
  EXPECT_FALSE(hoist.ever_not_finite);
}

TEST(Start, StaysInInitWhileOneNodeIsMissing) {
  for (int missing = 0; missing < 6; ++missing) {
    ScriptedHoist hoist;
    FakeNode* const nodes[] = {&hoist.tilt_left, &hoist.tilt_right, &hoist.tilt_base, &hoist.drive_left, &hoist.drive_right, &hoist.io};
    nodes[missing]->silent = true;
    hoist.step(400);
    EXPECT_EQ(hoist.state.mode, Mode::init) << missing;
    EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(Refusal::nodes_missing), 0U);
    nodes[missing]->silent = false;
    EXPECT_TRUE(hoist.to_standby()) << missing;
  }
}

TEST(Start, PatientLeadsAndStopsWhenUpright) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 500);
  EXPECT_EQ(hoist.state.mode, Mode::user);
  const double walking = hoist.command_m_s();
  EXPECT_GT(walking, 0.2);
  EXPECT_NEAR(hoist.out.record.speed_m_s, walking, 0.02);
  hoist.lean_gently(0, 2000);
  EXPECT_NEAR(hoist.command_m_s(), 0, 0.002);
  EXPECT_EQ(hoist.state.mode, Mode::user);
  EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby));
  EXPECT_EQ(hoist.state.latched, 0U);
}

TEST(Start, PatientTurnsLeftWithTheRightStrutAhead) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  for (int i = 1; i <= 60; ++i) {
    hoist.lean(0, 0.1 * i);
    hoist.step();
  }
  hoist.step(200);
  EXPECT_GT(hoist.out.record.turn_norm, 0.2F);
  EXPECT_GT(hoist.out.record.yaw_rate_command_rad_s, 0.05F);
  EXPECT_GT(hoist.out.record.wheel_right_command_m_s, hoist.out.record.wheel_left_command_m_s);
  EXPECT_GT(hoist.out.record.psi_rad, 0.05F);
}

TEST(Start, TherapistDrivesAndLetsGo) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(300, 1.0);
  EXPECT_EQ(hoist.state.mode, Mode::remote);
  EXPECT_NEAR(hoist.command_m_s(), 0.30, 1e-3);
  EXPECT_GT(hoist.out.record.x_m, 0.5F);
  hoist.hold(0, 0, false);
  hoist.step(200);
  EXPECT_EQ(hoist.state.mode, Mode::remote) << "letting go stops and stays";
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_LE(hoist.worst_deceleration_m_s2, kRemoteDeceleration_m_s2 + 1e-9);
  hoist.drive_for(100, -0.5);
  EXPECT_LT(hoist.command_m_s(), -0.1);
}

}  // namespace
}  // namespace hoist::core::test
