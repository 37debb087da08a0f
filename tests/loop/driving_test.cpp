// The therapist drives: the stick moves the hoist, and a lost connection stops it (hazards H17, H18, H20, H21).
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/closed_loop.hpp"

namespace hoist::tests {
namespace {

using contract::Fault;
using contract::Mode;

ClosedLoopOptions standing() {
  ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  return options;
}
double speed_m_s(ClosedLoop& loop) { return loop.world().plant().platform().speed_m_s; }

TEST(Driving, TheStickMovesTheHoistAndThePatientFollows) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start(Mode::remote));
  loop.hold_stick(0.0, 0.0);
  loop.run(0.1);
  loop.hold_stick(1.0, 0.0);
  loop.run(4.0);
  EXPECT_NEAR(speed_m_s(loop), 0.30, 0.02);
  EXPECT_EQ(loop.world().patient().state(), sim::PatientState::following);
  loop.hold_stick(0.0, 0.5);
  loop.run(4.0);
  EXPECT_NEAR(speed_m_s(loop), 0.0, 0.02);
  EXPECT_NEAR(loop.world().plant().platform().yaw_rate_rad_s, 0.5 * 0.523598776, 0.03);
  loop.let_go();
  loop.run(2.0);
  EXPECT_EQ(loop.mode(), Mode::remote);
  EXPECT_NEAR(loop.world().plant().platform().yaw_rate_rad_s, 0.0, 0.01);
}

// An uninformed patient sets off after a second, and then the therapist drives.
TEST(Driving, WhoeverWaitsBeforePushingTheStickDrivesAPatientWhoHasSetOff) {
  for (const double fast_m_s : {0.3, 0.45, 0.6}) {
    for (const double wait_s : {0.6, 1.5, 2.5, 4.0}) {
      ClosedLoopOptions options = standing();
      options.params.remote_speed_m_s_max = fast_m_s;
      ClosedLoop loop(options);
      ASSERT_TRUE(loop.start(Mode::remote));
      loop.hold_stick(0.0, 0.0);
      loop.run(wait_s);
      for (int i = 1; i <= 6; ++i) {
        loop.hold_stick(i / 6.0, 0.0);
        loop.run(0.02);
      }
      loop.run(20.0);
      EXPECT_EQ(loop.mode(), Mode::remote) << fast_m_s << " m/s after " << wait_s << " s";
      EXPECT_NEAR(speed_m_s(loop), fast_m_s, 0.03) << wait_s;
      EXPECT_EQ(loop.world().patient().state(), sim::PatientState::following) << fast_m_s << " m/s after " << wait_s << " s";
    }
  }
}

// The same once the patient follows straight on, and the therapist then turns.
TEST(Driving, ATurnAwayFromThePatientsLineIsFollowed) {
  for (const double yaw_norm : {-1.0, -0.6, 0.6, 1.0}) {
    ClosedLoopOptions options = standing();
    options.world.scenario = sim::find_scenario("straight");
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.start(Mode::remote));
    loop.hold_stick(0.0, 0.0);
    loop.run(2.5);
    loop.hold_stick(0.6, 0.0);
    loop.run(6.0);
    loop.hold_stick(0.6, yaw_norm);
    loop.run(8.0);
    EXPECT_EQ(loop.mode(), Mode::remote) << yaw_norm;
    EXPECT_EQ(loop.world().patient().state(), sim::PatientState::following) << yaw_norm;
  }
}

TEST(Driving, H17_SilenceStopsWithinItsDistance) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start(Mode::remote));
  loop.hold_stick(0.0, 0.0);
  loop.run(0.1);
  loop.hold_stick(1.0, 0.0);
  loop.run(4.0);
  const double from_m_s = speed_m_s(loop);
  const sim::PlatformMotion before = loop.world().plant().platform();
  loop.fall_silent();
  const double silent_s = loop.time_s();
  // The last command may be 40 ms old already; from 250 ms on only the ramp acts.
  double at_400_ms = from_m_s, stopped_s = -1.0;
  while (loop.time_s() < silent_s + 3.0) {
    loop.step();
    if (std::fabs(loop.time_s() - silent_s - 0.40) < 0.005) at_400_ms = speed_m_s(loop);
    if (stopped_s < 0.0 && speed_m_s(loop) < 0.01) stopped_s = loop.time_s() - silent_s;
  }
  EXPECT_LT(at_400_ms, 0.8 * from_m_s);
  EXPECT_GT(stopped_s, 0.0);
  EXPECT_LT(stopped_s, 0.25 + from_m_s / 0.8 + 0.25);
  const sim::PlatformMotion& after = loop.world().plant().platform();
  // 0.3 m/s: 0.25 s of rolling and the ramp at 0.8 m/s2 (safety 2.2: 0.39 m at 0.6).
  EXPECT_LT(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m), 0.20);
  EXPECT_TRUE(loop.ever_raised(Fault::remote_command_lost));
  EXPECT_EQ(loop.mode(), Mode::standby);
  // Returning commands move nothing: the driver has to start again.
  loop.hold_stick(1.0, 0.0);
  loop.run(2.0);
  EXPECT_NEAR(speed_m_s(loop), 0.0, 1e-3);
}

TEST(Driving, H21_AServerThatDiesStopsRemoteButNotThePatient) {
  {
    ClosedLoop loop(standing());
    ASSERT_TRUE(loop.start(Mode::remote));
    loop.hold_stick(0.0, 0.0);
    loop.run(0.1);
    loop.hold_stick(1.0, 0.0);
    loop.run(3.0);
    loop.stop_server();
    loop.fall_silent();
    loop.run(2.0);
    EXPECT_NEAR(speed_m_s(loop), 0.0, 0.01);
    EXPECT_EQ(loop.record().lease_holder, 0U);
  }
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(6.0);
  loop.stop_server();
  loop.run(10.0);
  EXPECT_EQ(loop.mode(), Mode::user);
  EXPECT_TRUE(loop.fault(Fault::server_lost));
  EXPECT_GT(speed_m_s(loop), 0.1);
}

TEST(Driving, TurningOnTheSpotFastTripsNothing) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start(Mode::remote));
  loop.hold_stick(0.0, 0.0);
  loop.run(0.1);
  for (int i = 0; i < 6; ++i) {
    loop.hold_stick(0.5, i % 2 == 0 ? 1.0 : -1.0);
    loop.run(3.0);
  }
  EXPECT_EQ(loop.mode(), Mode::remote);
  EXPECT_EQ(loop.record().stop_cause, 0U);
}

// At the fastest settings, with a battery just not empty: the outer wheel would need 0.9 m/s, more than this machine's motors reach.
TEST(Driving, H1_FullSpeedAndFullTurnTogetherTripNothing) {
  ClosedLoopOptions options = standing();
  options.params.remote_speed_m_s_max = 0.60;
  options.params.remote_yaw_rate_rad_s_max = options.params.yaw_rate_rad_s_max;
  ClosedLoop loop(options);
  loop.world().plant().force_battery(options.params.battery_empty_v + 0.1);
  ASSERT_TRUE(loop.start(Mode::remote));
  loop.hold_stick(0.0, 0.0);
  loop.run(0.1);
  for (int i = 0; i < 6; ++i) {
    loop.hold_stick(1.0, 0.0);
    loop.run(3.0);
    EXPECT_NEAR(speed_m_s(loop), 0.60, 0.03);
    loop.hold_stick(i < 4 ? 1.0 : -1.0, i % 2 == 0 ? 1.0 : -1.0);
    loop.run(4.0);
    EXPECT_GT(std::fabs(loop.world().plant().platform().yaw_rate_rad_s), 0.75) << "nearly all of it";
    EXPECT_GT(std::fabs(speed_m_s(loop)), 0.25) << "a curve, no turn on the spot";
    ASSERT_EQ(loop.mode(), Mode::remote);
  }
  EXPECT_EQ(loop.record().stop_cause, 0U);
}

}  // namespace
}  // namespace hoist::tests
