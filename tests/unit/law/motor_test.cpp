// The simulator's motor against what can be worked out by hand.
#include "firmware/sim/motor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hoist::sim {
namespace {

TEST(Motor, RunsAtTheSpeedTheEquationsGive) {
  Motor motor;
  const auto& c = motor.config();
  for (int k = 0; k < 3000; ++k) motor.step(12.0, 0.05, 1e-3);
  // Steady: K i = B w + Tc + load and V = R i + K w.
  const double speed = (12.0 * c.constant_v_s_rad / c.resistance_ohm - c.coulomb_n_m - 0.05) /
                       (c.constant_v_s_rad * c.constant_v_s_rad / c.resistance_ohm + c.viscous_n_m_s);
  EXPECT_NEAR(motor.speed_rad_s(), speed, 1e-6);
  EXPECT_NEAR(motor.current_a(), (12.0 - c.constant_v_s_rad * speed) / c.resistance_ohm, 1e-6);
}

TEST(Motor, BlockedDrawsTheStallCurrentWithTheWindingsTimeConstant) {
  Motor motor;
  motor.lock(true);
  motor.step(12.0, 0.0, 1.25e-3);
  EXPECT_NEAR(motor.current_a(), 10.0 * (1.0 - std::exp(-1.0)), 1e-9);
  for (int k = 0; k < 100; ++k) motor.step(12.0, 0.0, 1e-3);
  EXPECT_NEAR(motor.current_a(), 10.0, 1e-9);
  EXPECT_EQ(motor.speed_rad_s(), 0.0);
  EXPECT_EQ(motor.encoder_counts(), 0);
}

TEST(Motor, FrictionHoldsAndNeverDrives) {
  Motor motor;
  for (int k = 0; k < 1000; ++k) motor.step(0.0, 0.019, 1e-3);
  EXPECT_EQ(motor.speed_rad_s(), 0.0);
  for (int k = 0; k < 1000; ++k) motor.step(0.0, 0.05, 1e-3);
  EXPECT_LT(motor.speed_rad_s(), 0.0) << "a load beyond friction turns the shaft backward";
  Motor coasting;
  for (int k = 0; k < 1000; ++k) coasting.step(24.0, 0.0, 1e-3);
  double before = coasting.speed_rad_s();
  for (int k = 0; k < 2000; ++k) {
    coasting.step(0.0, 0.0, 1e-3);
    ASSERT_LE(coasting.speed_rad_s(), before);
    ASSERT_GE(coasting.speed_rad_s(), -1.0) << "only the winding's rest may pull it past zero";
    before = std::fabs(coasting.speed_rad_s()) + 1e-9;
  }
  EXPECT_EQ(coasting.speed_rad_s(), 0.0);
}

TEST(Motor, SubStepsMakeTheResultIndependentOfTheCallersStep) {
  Motor fine;
  Motor coarse;
  for (int k = 0; k < 1000; ++k) fine.step(10.0, 0.02, 1e-4);
  for (int k = 0; k < 10; ++k) coarse.step(10.0, 0.02, 1e-2);
  EXPECT_NEAR(fine.speed_rad_s(), coarse.speed_rad_s(), 1e-9);
  EXPECT_NEAR(fine.angle_rad(), coarse.angle_rad(), 1e-9);
}

TEST(Motor, ImposedSpeedGivesTorqueFromTheSameWinding) {
  Motor motor;
  double torque = 0.0;
  for (int k = 0; k < 100; ++k) torque = motor.step_imposed(12.0, 50.0, 1e-3);
  const auto& c = motor.config();
  EXPECT_NEAR(torque, c.constant_v_s_rad * (12.0 - c.constant_v_s_rad * 50.0) / c.resistance_ohm, 1e-9);
  EXPECT_NEAR(motor.angle_rad(), 50.0 * 0.1, 0.05);
}

TEST(Motor, NeverBecomesNonFinite) {
  Motor motor;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, -inf, 0.0, -1.0, 1e6}) {
    motor.step(bad, bad, 1e-3);
    motor.step(1.0, 0.0, bad == 1e6 ? 1.0 : bad);
    static_cast<void>(motor.step_imposed(bad, bad, 1e-3));
    ASSERT_TRUE(std::isfinite(motor.speed_rad_s()) && std::isfinite(motor.current_a()) && std::isfinite(motor.angle_rad())) << bad;
  }
}

}  // namespace
}  // namespace hoist::sim
