// The track corrected by the gyroscope (H10), with computed wheels and gyroscope, so that the true values are known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "control/contract/can_dictionary.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/types.hpp"

namespace hoist::core::test {
namespace {

constexpr double kDeg_rad = std::numbers::pi / 180.0;

// Encoder and gyroscope readings from true values. Frames are those of the bus, with real rounding and counters.
struct Bench {
  contract::Params params;
  Derived derived = derive(params);
  Estimate sensed;
  double left_m = 0, right_m = 0;  // as the wheels turned
  double psi_rad = 0;              // as the hoist turned
  double gyro_bias_deg_s = 0;
  double seconds = 0;
  std::uint8_t counter = 0;
  std::uint32_t noise = 12345;
  bool gyro = true, gyro_valid = true, drives = true;

  double random() {
    noise = noise * 1664525U + 1013904223U;
    return static_cast<double>(noise >> 8) / 8388608.0 - 1.0;
  }
  /// One step: what the wheels do, and how much the hoist truly turns beyond that.
  void step(double speed_m_s, double wheel_turn_deg_s, double slip_deg_s = 0) {
    const double half_m_s = wheel_turn_deg_s * kDeg_rad * params.track_width_m / 2;
    left_m += (speed_m_s - half_m_s) * kTick_s;
    right_m += (speed_m_s + half_m_s) * kTick_s;
    const double true_deg_s = wheel_turn_deg_s + slip_deg_s;
    psi_rad += true_deg_s * kDeg_rad * kTick_s;
    seconds += kTick_s;
    sensed.next_tick();
    using contract::Node;
    using contract::Pdo;
    contract::CanFrame angles{contract::pdo_cob_id(Pdo::tilt_tx1, Node::tilt_base), 6, 0, {}};
    contract::write_slot(angles, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), gyro_valid ? 3 : 2);
    contract::write_slot(angles, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), ++counter);
    sensed.base.take_angles(angles);
    if (gyro) {
      contract::CanFrame rates{contract::pdo_cob_id(Pdo::tilt_tx2, Node::tilt_base), 6, 0, {}};
      const double shown_deg_s = true_deg_s + gyro_bias_deg_s + 0.17 * random();  // 0.1 deg/s, evenly spread
      contract::write_slot(rates, contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1), std::lround(shown_deg_s * 100));
      sensed.base.take_rates(rates, derived.base_yaw_bias_rad_s);
    }
    if (drives) {
      take(Node::drive_left, sensed.left_drive, left_m / derived.odometry.left_m_per_count);
      take(Node::drive_right, sensed.right_drive, right_m / derived.odometry.right_m_per_count);
    }
    sensed.odometry.update(sensed.left_drive, sensed.right_drive, derived, kTick_s);
    sensed.fused.update(sensed.odometry, sensed.left_drive, sensed.right_drive, sensed.base, derived, kTick_s);
  }
  void take(contract::Node node, DriveSensor& drive, double counts) {
    contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::drive_tx1, node), 8, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx1, 0x6041), 0x27);
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx1, 0x6064), std::llround(counts));
    EXPECT_TRUE(drive.take_state(frame, 1e9));
  }
  void run(double for_s, double speed_m_s, double wheel_turn_deg_s, double slip_deg_s = 0) {
    for (double left_s = for_s; left_s > kTick_s / 2; left_s -= kTick_s) step(speed_m_s, wheel_turn_deg_s, slip_deg_s);
  }
  [[nodiscard]] double error_deg() const { return std::fabs(sensed.pose().psi_rad - psi_rad) / kDeg_rad; }
  [[nodiscard]] double encoder_error_deg() const { return std::fabs(sensed.odometry.pose.psi_rad - psi_rad) / kDeg_rad; }
};

TEST(FusedOdometry, H10WithoutSlipItIsTheEncodersTrack) {
  Bench bench;
  bench.run(3, 0, 0);
  for (int lap = 0; lap < 10; ++lap) {
    bench.run(5, 0.4, 0);
    for (int i = 0; i < 300; ++i) bench.step(0.4, 40 * std::sin(i * 0.02));
    EXPECT_FALSE(bench.sensed.slipping());
  }
  EXPECT_LT(bench.encoder_error_deg(), 0.02);
  EXPECT_LT(bench.error_deg(), 0.1);
  EXPECT_NEAR(bench.sensed.pose().x_m, bench.sensed.odometry.pose.x_m, 0.05);
}

TEST(FusedOdometry, H10ASlipIsNoticedWithin200msAndTheHeadingKept) {
  for (const double slip_deg_s : {8.0, 15.0, -40.0}) {
    SCOPED_TRACE(slip_deg_s);
    Bench bench;
    bench.run(3, 0, 0);
    bench.run(4, 0.4, 5);
    const double before_deg = bench.error_deg();
    int noticed = 0;
    while (!bench.sensed.slipping() && noticed < 100) {
      bench.step(0.4, 5, slip_deg_s);
      ++noticed;
    }
    EXPECT_LE(noticed, 20);
    bench.run(1, 0.4, 5, slip_deg_s);
    EXPECT_TRUE(bench.sensed.slipping());
    bench.run(3, 0.4, 5);
    EXPECT_FALSE(bench.sensed.slipping());
    EXPECT_GT(bench.encoder_error_deg(), 8.0);
    EXPECT_LT(bench.error_deg(), before_deg + 0.3);
  }
}

TEST(FusedOdometry, H10AWrongTrackWidthIsNoSlipAndTeachesNoBias) {
  Bench bench;
  bench.run(5, 0, 0);
  // The track parameter is 3 % too wide, for minutes of bends.
  for (int i = 0; i < 12'000; ++i) {
    const double turn_deg_s = 45 * std::sin(i * 0.01);
    bench.step(0.3, turn_deg_s, 0.03 * turn_deg_s);
    ASSERT_FALSE(bench.sensed.slipping()) << i;
  }
  EXPECT_LT(std::fabs(bench.sensed.fused.gyro_bias_rad_s()) / kDeg_rad, 0.05);
}

// What calibration found is taken off the rate itself; what is learnt here is the rest, also when a calibration comes later.
TEST(FusedOdometry, H10WhatCalibrationFoundIsTakenOffOnce) {
  Bench bench;
  bench.gyro_bias_deg_s = 2.5;
  bench.params.base_yaw_bias_rad_s = 2.5 * kDeg_rad;
  bench.derived = derive(bench.params);
  bench.run(1, 0.4, 0);  // no time to learn anything
  EXPECT_FALSE(bench.sensed.slipping());
  EXPECT_NEAR(bench.sensed.base.yaw_rate_rad_s() / kDeg_rad, 0, 0.2);
  EXPECT_NEAR(bench.sensed.base.sent_yaw_rate_rad_s() / kDeg_rad, 2.5, 0.2);
  EXPECT_NEAR(bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad, 0, 0.1);
  bench.gyro_bias_deg_s = 3.3;
  bench.run(3, 0, 0);
  const double rest_deg_s = bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad;
  EXPECT_NEAR(rest_deg_s, 0.8, 0.2);
  bench.params.base_yaw_bias_rad_s = 2.9 * kDeg_rad;
  bench.derived = derive(bench.params);
  bench.step(0, 0);
  EXPECT_NEAR(bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad, rest_deg_s - 0.4, 0.02);
  bench.run(3, 0.4, 0);
  EXPECT_FALSE(bench.sensed.slipping());
}

TEST(FusedOdometry, H10TheBiasIsLearntStandingAndKeptUpWalking) {
  Bench bench;
  bench.gyro_bias_deg_s = 0.4;
  bench.run(3, 0, 0);
  EXPECT_NEAR(bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad, 0.4, 0.05);
  bench.gyro_bias_deg_s = 0.6;  // it warms up
  bench.run(60, 0.3, 0);
  EXPECT_NEAR(bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad, 0.6, 0.05);
  EXPECT_FALSE(bench.sensed.slipping());
  EXPECT_LT(bench.error_deg(), 0.3);
  bench.run(1, 0.3, 0, 20);
  bench.run(2, 0.3, 0);
  EXPECT_LT(bench.error_deg(), 0.6);
}

TEST(FusedOdometry, H10AJumpOfTheBiasIsTakenBackOnceTheHoistStands) {
  Bench bench;
  bench.run(3, 0, 0);
  bench.run(5, 0.3, 0);
  bench.gyro_bias_deg_s = 2.5;
  bench.run(1, 0.3, 0);
  EXPECT_TRUE(bench.sensed.slipping()) << "any doubt is told";
  bench.run(5, 0, 0);
  EXPECT_FALSE(bench.sensed.slipping());
  EXPECT_NEAR(bench.sensed.fused.gyro_bias_rad_s() / kDeg_rad, 2.5, 0.2);
  EXPECT_LT(bench.error_deg(), 0.5) << "nobody has turned";
  // A rate beyond any gyroscope's bias must not be learnt.
  bench.gyro_bias_deg_s = 12;
  bench.run(20, 0, 0);
  EXPECT_TRUE(bench.sensed.slipping());
}

TEST(FusedOdometry, H10WithoutTheGyroscopeTheEncodersLeadAndItSaysSo) {
  Bench bench;
  bench.run(3, 0, 0);
  bench.run(2, 0.4, 10, 20);
  ASSERT_TRUE(bench.sensed.slipping());
  bench.gyro = false;
  bench.run(0.1, 0.4, 10);
  EXPECT_FALSE(bench.sensed.fused.gyro_used());
  EXPECT_FALSE(bench.sensed.slipping()) << "nothing is known about slip any more";
  const double before_rad = bench.sensed.pose().psi_rad, encoder_rad = bench.sensed.odometry.pose.psi_rad;
  bench.run(3, 0.4, 10, 20);
  EXPECT_NEAR(bench.sensed.pose().psi_rad - before_rad, bench.sensed.odometry.pose.psi_rad - encoder_rad, 1e-9);
  EXPECT_NEAR(bench.sensed.fused.yaw_rate_rad_s(), bench.sensed.odometry.yaw_rate_rad_s, 1e-12);
  // And recovers; samples marked invalid by the sensor do not count.
  bench.gyro = true;
  bench.run(0.1, 0.4, 10);
  EXPECT_TRUE(bench.sensed.fused.gyro_used());
  bench.gyro_valid = false;
  bench.run(0.1, 0.4, 10);
  EXPECT_FALSE(bench.sensed.fused.gyro_used());
}

TEST(FusedOdometry, H10LostFramesOfADriveAreNoSlip) {
  Bench bench;
  bench.run(3, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    bench.drives = i % 10 < 6;  // 40 ms of silence again and again, in a bend
    bench.step(0.4, 30);
    ASSERT_FALSE(bench.sensed.slipping()) << i;
  }
  bench.drives = true;
  bench.run(1, 0.4, 30);
  EXPECT_LT(bench.error_deg(), 0.5);
}

}  // namespace
}  // namespace hoist::core::test
