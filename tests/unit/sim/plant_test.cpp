// The machine's physics against sums done by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "firmware/sim/plant.hpp"

namespace hoist::sim {
namespace {

constexpr double kTick_s = 0.001;

void run(Plant& plant, const HarnessMotion& harness, double seconds) {
  const int ticks = static_cast<int>(std::lround(seconds / kTick_s));
  for (int i = 0; i < ticks; ++i) plant.step(harness, kTick_s);
}
void enable(Plant& plant, double left_duty, double right_duty) {
  plant.set_bridge(Side::left, true, left_duty);
  plant.set_bridge(Side::right, true, right_duty);
}
double moved_m(const Plant& plant, std::int32_t from_left, std::int32_t from_right) {
  const double per_count_m = 2.0 * kPi * plant.params().wheel_radius_m / 60000.0;
  return 0.5 * per_count_m * ((plant.encoder_counts(Side::left) - from_left) + (plant.encoder_counts(Side::right) - from_right));
}

TEST(Plant, SteadySpeedIsWhatTheMotorEquationSays) {
  Plant plant({}, 1);
  const double duty = 0.4;
  enable(plant, duty, duty);
  run(plant, {}, 4.0);
  const PlantParams& p = plant.params();
  const double supply_v = plant.supply_v();
  // duty V = R i + K w, and K i carries Coulomb, viscous and rolling friction.
  const double shaft_rad_s = plant.platform().speed_m_s / p.wheel_radius_m * p.gear_ratio;
  const double friction_n_m = p.motor.coulomb_n_m + p.motor.viscous_n_m_s * shaft_rad_s + p.rolling_n * p.wheel_radius_m / p.gear_ratio;
  const double expected_rad_s =
      (duty * supply_v - p.motor.resistance_ohm * friction_n_m / p.motor.constant_v_s_rad) / p.motor.constant_v_s_rad;
  EXPECT_NEAR(shaft_rad_s, expected_rad_s, 0.01 * expected_rad_s);
  EXPECT_NEAR(plant.motor_current_a(Side::left), friction_n_m / p.motor.constant_v_s_rad, 0.01);
  EXPECT_NEAR(plant.platform().y_m, 0.0, 1e-9);
}

TEST(Plant, RightWheelAheadTurnsLeftOnTheSpot) {
  Plant plant({}, 1);
  enable(plant, -0.2, 0.2);
  run(plant, {}, 1.0);
  EXPECT_GT(plant.platform().psi_rad, 0.3);  // 0.13 m/s at each wheel, 0.35 m from the middle
  EXPECT_NEAR(std::hypot(plant.platform().x_m, plant.platform().y_m), 0.0, 1e-6);
}

TEST(Plant, EncodersCountTheTrueWayAsLongAsTheWheelsGrip) {
  Plant plant({}, 1);
  enable(plant, 0.3, 0.35);
  run(plant, {}, 5.0);
  EXPECT_FALSE(plant.slipping());
  // 60000 counts a wheel turn (2000 at the motor, gear 30). The mean of both wheels is the length of the curve driven.
  const double per_count_m = 2.0 * kPi * 0.10 / 60000.0;
  const double left_m = plant.encoder_counts(Side::left) * per_count_m, right_m = plant.encoder_counts(Side::right) * per_count_m;
  EXPECT_NEAR(plant.platform().psi_rad, (right_m - left_m) / 0.70, 2e-3);
  const double radius_m = 0.5 * (left_m + right_m) / plant.platform().psi_rad;
  EXPECT_GT(radius_m, 0.5);
}

TEST(Plant, OnIceTheWheelsRunAwayAndTheEncodersLie) {
  Plant plant({}, 1);
  plant.set_grip(Side::left, 0.01);
  plant.set_grip(Side::right, 0.01);
  enable(plant, 0.8, 0.8);
  run(plant, {}, 0.5);
  EXPECT_TRUE(plant.slipping());
  EXPECT_GT(moved_m(plant, 0, 0), 2.0 * plant.platform().x_m);
  // The floor pushes with its friction, not more: F = mu * load, to which the push itself adds.
  const PlantParams& p = plant.params();
  const double limit_m_s2 = 0.01 * p.driven_load_norm * kGravity_m_s2 / (1.0 - 0.01 * p.cg_height_m / p.caster_ahead_m);
  EXPECT_LE(plant.platform().speed_m_s, 0.5 * limit_m_s2 * 1.001);
  EXPECT_GT(plant.platform().speed_m_s, 0.5 * limit_m_s2 * 0.9);
  // Back on the floor it grips again, wheels and platform as one.
  plant.set_grip(Side::left, 0.7);
  plant.set_grip(Side::right, 0.7);
  run(plant, {}, 1.0);
  EXPECT_FALSE(plant.slipping());
  EXPECT_NEAR(plant.wheel_speed_m_s(Side::left), plant.platform().speed_m_s, 1e-9);
}

TEST(Plant, TheClosedBrakeHoldsALeaningPatient) {
  Plant plant({}, 1);
  HarnessMotion lean;
  lean.dx_m = 0.14;  // 10 degrees: 42 N
  run(plant, lean, 5.0);
  EXPECT_NEAR(plant.platform().x_m, 0.0, 1e-6);
  EXPECT_NEAR(plant.platform().speed_m_s, 0.0, 1e-9);
  // With the bridges on and no voltage the winding is shorted: the push moves it, slowly.
  enable(plant, 0.0, 0.0);
  run(plant, lean, 2.0);
  EXPECT_GT(plant.platform().x_m, 0.001);
  EXPECT_LT(plant.platform().speed_m_s, 0.1);
}

// Moments about the casters' points: a pull forward takes h / L of itself off the driven wheels.
TEST(Plant, APullAtTheHarnessTakesLoadOffTheDrivenWheels) {
  PlantParams p;
  p.driven_load_norm = 0.7;
  p.cg_height_m = 0.0;
  p.brake_n_m = 100.0;  // holds the wheels against any pull of this test
  HarnessMotion pull;
  pull.dx_m = 0.6;
  p.stop_rad = 1.2;  // springs alone: 180 N
  for (const double ahead_m : {0.5, 0.7}) {
    p.caster_ahead_m = ahead_m;
    Plant plant(p, 1);
    const double pull_n = plant.harness_force(pull).forward_n;
    ASSERT_NEAR(pull_n, 180.0, 1e-6);
    const double held_n = p.grip_norm * (p.driven_load_norm * p.mass_kg * kGravity_m_s2 - pull_n * p.pull_height_m / ahead_m);
    run(plant, pull, 1.0);
    EXPECT_NEAR(plant.wheel_speed_m_s(Side::left), 0.0, 1e-9);
    if (pull_n < held_n) {
      EXPECT_NEAR(plant.platform().speed_m_s, 0.0, 1e-9) << ahead_m;
    } else {
      EXPECT_NEAR(plant.platform().speed_m_s, (pull_n - held_n) / p.mass_kg, 0.01) << ahead_m;
    }
  }
}

TEST(Plant, ABrakeThatClosesLateLetsTheMachineRollSoMuchFurther) {
  PlantParams p;
  p.rotor_inertia_kg_m2 = 1.0e-4;
  std::array<double, 2> way_m{};
  for (const bool late : {false, true}) {
    p.brake_close_s = late ? 0.05 : 0.0;
    Plant plant(p, 1);
    enable(plant, 0.9, 0.9);
    run(plant, {}, 3.0);
    const double before_m_s = plant.platform().speed_m_s, x_m = plant.platform().x_m;
    plant.cut_power(true);
    run(plant, {}, 1.0);
    way_m[late ? 1 : 0] = plant.platform().x_m - x_m;
    if (late) continue;
    // Brake, gear and rolling act on the machine and its two wheels with their rotors.
    const double force_n = 2.0 * (p.brake_n_m / p.wheel_radius_m + p.gear_ratio * p.motor.coulomb_n_m / p.wheel_radius_m + p.rolling_n);
    const double inertia_kg_m2 = p.wheel_inertia_kg_m2 + p.rotor_inertia_kg_m2 * p.gear_ratio * p.gear_ratio;
    const double mass_kg = p.mass_kg + 2.0 * inertia_kg_m2 / (p.wheel_radius_m * p.wheel_radius_m);
    EXPECT_NEAR(way_m[0], before_m_s * before_m_s / 2.0 * mass_kg / force_n, 0.05 * way_m[0]);
  }
  EXPECT_NEAR(way_m[1] - way_m[0], 0.05 * 0.45, 0.006);
}

TEST(Plant, ALateGyroscopeTellsTheRateOfBefore) {
  PlantParams p;
  p.imu = {0, 0, 0, 0, 0, 0.0049};
  Plant plant(p, 1);
  HarnessMotion lean;
  double last_rad_s = 0;
  for (int step = 0; step < 50; ++step) {
    const double now_rad_s = 0.002 * step * step;
    lean.dx_rate_m_s = now_rad_s * p.strut_length_m;
    run(plant, lean, 0.01);
    const double told_rad_s = plant.read_imu(Place::left_strut).alpha_rate_rad_s;
    if (step > 0) {
      EXPECT_NEAR(told_rad_s, now_rad_s - 0.49 * (now_rad_s - last_rad_s), 0.01 + 0.01 * now_rad_s) << step;
    }
    last_rad_s = now_rad_s;
  }
}

TEST(Plant, PowerCutClosesTheBrakesAndStopsWithinTheirTorque) {
  Plant plant({}, 1);
  enable(plant, 0.9, 0.9);
  run(plant, {}, 3.0);
  const double before_m_s = plant.platform().speed_m_s;
  ASSERT_GT(before_m_s, 0.4);
  plant.cut_power(true);
  EXPECT_EQ(plant.supply_v(), 0.0);
  EXPECT_FALSE(plant.bridge_enabled(Side::left));
  const double x_m = plant.platform().x_m;
  run(plant, {}, 2.0);
  EXPECT_EQ(plant.platform().speed_m_s, 0.0);
  EXPECT_LT(plant.platform().x_m - x_m, 0.5 * before_m_s * before_m_s / 0.8);
  // Current decays with the winding's time constant.
  EXPECT_NEAR(plant.motor_current_a(Side::left), 0.0, 1e-6);
}

TEST(Plant, FrictionNeverTurnsTheMachineRound) {
  Plant plant({}, 1);
  enable(plant, 0.5, 0.5);
  run(plant, {}, 1.0);
  plant.set_bridge(Side::left, false, 0.0);
  plant.set_bridge(Side::right, false, 0.0);
  double last_m_s = plant.platform().speed_m_s;
  for (int i = 0; i < 3000; ++i) {
    plant.step({}, kTick_s);
    EXPECT_LE(plant.platform().speed_m_s, last_m_s + 1e-10);
    EXPECT_GE(plant.platform().speed_m_s, -1e-12);
    last_m_s = plant.platform().speed_m_s;
  }
}

TEST(Plant, SpringsAndStopPushAsTheirFiguresSay) {
  const Plant plant({}, 1);
  HarnessMotion lean;
  lean.dx_m = 0.10;
  HarnessForce force = plant.harness_force(lean);
  EXPECT_NEAR(force.forward_n, 30.0, 1e-9);  // 300 N/m
  EXPECT_NEAR(force.turn_n_m, 0.0, 1e-12);
  lean.dx_m = -0.10;
  EXPECT_NEAR(plant.harness_force(lean).forward_n, -30.0, 1e-9);
  HarnessMotion turn;
  turn.yaw_rad = 0.2;
  force = plant.harness_force(turn);
  EXPECT_NEAR(force.forward_n, 0.0, 1e-9);
  // Two springs of 150 N/m, 0.3 m from the middle, each stretched by 0.3 sin(0.2).
  EXPECT_NEAR(force.turn_n_m, 2.0 * 150.0 * 0.3 * std::sin(0.2) * 0.3 * std::cos(0.2), 1e-9);
  // One millimetre past the stop at 15 degrees adds 2 x 8 N.
  const double stop_m = 0.80 * std::tan(15.0 * kDegree_rad);
  lean.dx_m = stop_m + 0.001;
  EXPECT_NEAR(plant.harness_force(lean).forward_n, 300.0 * lean.dx_m + 16.0, 1e-6);
  // Rubber never pulls: leaving the stop quickly gives spring and damping only.
  lean.dx_rate_m_s = -2.0;
  EXPECT_NEAR(plant.harness_force(lean).forward_n, 300.0 * lean.dx_m - 60.0 * 2.0, 1e-6);
}

TEST(Plant, SensorsAtRestShowGravityAndTheLean) {
  PlantParams params;
  params.imu = {0.0, 0.0, 0.0, 0.0, 0.0};  // an ideal chip: what is left is geometry
  Plant plant(params, 1);
  HarnessMotion lean;
  lean.dx_m = 0.8 * std::tan(8.0 * kDegree_rad);
  lean.dy_m = 0.8 * std::tan(3.0 * kDegree_rad);  // to the left: beta is negative
  run(plant, lean, 1.0);
  for (const Place place : {Place::left_strut, Place::right_strut}) {
    (void)plant.read_imu(place);
    run(plant, lean, 0.01);
    const ImuReading r = plant.read_imu(place);
    EXPECT_NEAR(std::sqrt(r.ax_m_s2 * r.ax_m_s2 + r.ay_m_s2 * r.ay_m_s2 + r.az_m_s2 * r.az_m_s2), kGravity_m_s2, 1e-6);
    // The chassis tilts by 0.1 degree under 42 N; both axes lean, which adds up to 0.1 degree.
    EXPECT_NEAR(std::atan2(-r.ax_m_s2, r.az_m_s2) / kDegree_rad, 8.0, 0.25);
    EXPECT_NEAR(std::atan2(r.ay_m_s2, r.az_m_s2) / kDegree_rad, -3.0, 0.1);
    EXPECT_NEAR(r.alpha_rate_rad_s, 0.0, 1e-6);
  }
}

TEST(Plant, AnAccelerationOfTheChassisShowsInAllThreeSensorsAlike) {
  PlantParams params;
  params.imu = {0.0, 0.0, 0.0, 0.0, 0.0};
  Plant plant(params, 1);
  std::vector<ImuReading> readings;
  for (const Place place : {Place::left_strut, Place::right_strut, Place::chassis}) (void)plant.read_imu(place);
  enable(plant, 0.25, 0.25);
  run(plant, {}, 0.05);
  const double acceleration_m_s2 = plant.platform().speed_m_s / 0.05;
  for (const Place place : {Place::left_strut, Place::right_strut, Place::chassis}) readings.push_back(plant.read_imu(place));
  ASSERT_GT(acceleration_m_s2, 0.3);
  for (const ImuReading& r : readings) EXPECT_NEAR(r.ax_m_s2, acceleration_m_s2, 0.3 * acceleration_m_s2);
  EXPECT_NEAR(readings[0].ax_m_s2, readings[1].ax_m_s2, 1e-6);
}

TEST(Plant, GyroscopesIntegrateToTheLean) {
  PlantParams params;
  params.imu = {0.0, 0.0, 0.0, 0.0, 0.0};
  Plant plant(params, 1);
  double integral_rad = 0.0;
  HarnessMotion harness;
  harness.dx_rate_m_s = 0.1;
  for (int i = 0; i < 1000; ++i) {
    harness.dx_m = 0.0001 * i;
    plant.step(harness, kTick_s);
    integral_rad += plant.read_imu(Place::left_strut).alpha_rate_rad_s * kTick_s;
  }
  EXPECT_NEAR(integral_rad, std::atan(0.1 / 0.8), 3e-3);
}

TEST(Plant, SameSeedSameNoiseOtherSeedOtherNoise) {
  Plant one(PlantParams{}, 7), same(PlantParams{}, 7), other(PlantParams{}, 8);
  bool differs = false;
  for (int i = 0; i < 100; ++i) {
    const ImuReading a = one.read_imu(Place::chassis), b = same.read_imu(Place::chassis), c = other.read_imu(Place::chassis);
    EXPECT_EQ(a.ax_m_s2, b.ax_m_s2);
    EXPECT_EQ(a.yaw_rate_rad_s, b.yaw_rate_rad_s);
    differs = differs || a.ax_m_s2 != c.ax_m_s2;
  }
  EXPECT_TRUE(differs);
}

TEST(Plant, NoiseHasTheDeviationItIsSaidToHave) {
  Plant plant(PlantParams{}, 3);
  double sum = 0.0, square = 0.0;
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const double rate = plant.read_imu(Place::chassis).alpha_rate_rad_s;
    sum += rate;
    square += rate * rate;
  }
  const double mean = sum / kSamples;
  const ImuParams imu;
  EXPECT_NEAR(std::sqrt(square / kSamples - mean * mean), imu.gyro_noise_rad_s, 0.05 * imu.gyro_noise_rad_s);
  EXPECT_LT(std::fabs(mean), imu.gyro_bias_rad_s * 1.1);
}

TEST(Plant, BatteriesSagUnderLoadRunDownAndCanBeForced) {
  Plant plant({}, 1);
  run(plant, {}, 0.1);
  const double idle_v = plant.supply_v();
  enable(plant, 1.0, 1.0);
  plant.step({}, kTick_s);
  run(plant, {}, 0.02);
  EXPECT_LT(plant.supply_v(), idle_v - 0.1);
  EXPECT_NEAR(plant.battery_v(0) + plant.battery_v(1), plant.supply_v(), 1e-9);
  EXPECT_GT(plant.battery_v(0), plant.battery_v(1));
  plant.force_battery(21.5);
  EXPECT_NEAR(plant.supply_v(), 21.5, 1e-9);
  plant.force_battery(std::nullopt);
  EXPECT_GT(plant.supply_v(), 22.0);

  Battery battery;
  for (int hour = 0; hour < 18; ++hour) battery.step(1.0, 3600.0);
  EXPECT_LT(battery.charge_norm(), 0.01);
  EXPECT_LT(battery.both_v(), 23.0);
}

TEST(Plant, APostStopsTheMachineAndPressesTheRightStrip) {
  Plant plant({}, 1);
  ASSERT_TRUE(plant.add_obstacle({1.4, 0.0, 0.05}));
  enable(plant, 0.2, 0.2);
  EXPECT_EQ(plant.bumpers(), 0);
  run(plant, {}, 6.0);
  EXPECT_EQ(plant.bumpers(), 0x01);
  EXPECT_LT(plant.platform().x_m + plant.params().bumper_middle_m + plant.params().bumper_half_length_m, 1.4);
  EXPECT_NEAR(plant.platform().psi_rad, 0.0, 1e-6);
  enable(plant, -0.2, -0.2);
  run(plant, {}, 2.0);
  EXPECT_EQ(plant.bumpers(), 0);

  Plant beside({}, 1);
  ASSERT_TRUE(beside.add_obstacle({0.0, 0.44, 0.05}));
  ASSERT_TRUE(beside.add_obstacle({-0.08, 0.0, 0.05}));
  beside.step({}, kTick_s);
  EXPECT_EQ(beside.bumpers(), 0x04 | 0x02);

  // One beside the middle holds that side: the machine turns about it.
  Plant turns({}, 1);
  ASSERT_TRUE(turns.add_obstacle({1.4, 0.3, 0.05}));
  enable(turns, 0.2, 0.2);
  run(turns, {}, 6.0);
  EXPECT_GT(turns.platform().psi_rad, 0.05);
}

TEST(Plant, ForcedBumpersAndRefusedObstacles) {
  Plant plant({}, 1);
  for (int bit = 0; bit < 4; ++bit) {
    plant.force_bumper(bit, true);
    EXPECT_EQ(plant.bumpers(), 1 << bit);
    plant.force_bumper(bit, false);
  }
  plant.force_bumper(4, true);
  plant.force_bumper(-1, true);
  EXPECT_EQ(plant.bumpers(), 0);
  EXPECT_FALSE(plant.add_obstacle({0.0, 0.0, 0.0}));
  EXPECT_FALSE(plant.add_obstacle({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.1}));
  for (std::size_t i = 0; i < kObstacleLimit; ++i) EXPECT_TRUE(plant.add_obstacle({50.0, 50.0, 0.1}));
  EXPECT_FALSE(plant.add_obstacle({50.0, 50.0, 0.1}));
}

TEST(Plant, ASillIsClimbedByItsHeightAndGivesItBack) {
  Plant plant({}, 1);
  const double height_m = 0.015;
  EXPECT_FALSE(plant.lay_edge({0.6, 0.0, 0.0, 0.05, 0.1}));
  EXPECT_FALSE(plant.lay_edge({std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0, height_m, 0.1}));
  ASSERT_TRUE(plant.lay_edge({0.6, 0.0, 0.0, height_m, 0.1}));
  enable(plant, 0.5, 0.5);
  double most_rad = 0.0, least_rad = 0.0, work_j = 0.0, highest_j = 0.0, hardest_n = 0.0;
  for (int i = 0; i < 6000; ++i) {
    plant.step({}, kTick_s);
    most_rad = std::max(most_rad, plant.chassis_alpha_rad());
    least_rad = std::min(least_rad, plant.chassis_alpha_rad());
    if (plant.on_edge() && i % 50 == 0) {
      EXPECT_FALSE(plant.lay_edge({5.0, 0.0, 0.0, height_m, 0.1}));
    }
    work_j -= plant.edge_force().forward_n * plant.platform().speed_m_s * kTick_s;
    highest_j = std::max(highest_j, work_j);
    hardest_n = std::max(hardest_n, std::fabs(plant.edge_force().forward_n));
  }
  EXPECT_GT(plant.platform().x_m, 0.8) << "the motors take it";
  EXPECT_FALSE(plant.on_edge());
  // 15 mm on 0.8 m, with the chassis' own lag; the casters first.
  EXPECT_NEAR(least_rad, -height_m / 0.8, 0.006);
  EXPECT_NEAR(most_rad, height_m / 0.8, 0.006);
  // The wheels bear 0.85 of 60 kg: m g h, less a tenth at the tyre, and the same back.
  EXPECT_NEAR(highest_j, 0.85 * 60.0 * kGravity_m_s2 * height_m, 0.85);
  EXPECT_NEAR(work_j, 0.0, 0.3);
  // The steepest piece of a wheel of 100 mm: 53 mm over 85.
  EXPECT_NEAR(hardest_n, 0.85 * 60.0 * kGravity_m_s2 * 0.62, 40.0);
}

TEST(Plant, AWheelThatDropsOverAnEdgeRollsTheChassisAndLosesItsGripForAMoment) {
  Plant plant({}, 1);
  ASSERT_TRUE(plant.lay_edge({0.6, 0.0, 0.0, -0.03, 0.0, true, false}));
  enable(plant, 0.5, 0.5);
  double hardest_left_n_m = 0.0;
  for (int i = 0; i < 6000; ++i) {
    plant.step({}, kTick_s);
    hardest_left_n_m = std::min(hardest_left_n_m, plant.edge_force().turn_n_m);
  }
  EXPECT_NEAR(plant.chassis_beta_rad(), -0.03 / 0.7, 1e-3) << "left wheel and caster stand lower";
  EXPECT_NEAR(plant.chassis_alpha_rad(), 0.0, 1e-3);
  EXPECT_LT(hardest_left_n_m, -30.0) << "the wheel that drops pulls ahead: to the right";
  EXPECT_TRUE(plant.on_edge());
}

TEST(Plant, AStrutWhoseStrapIsCutSpringsUprightAndPushesNothing) {
  Plant plant({}, 1);
  const HarnessMotion leant{0.10, 0.02, 0.0};
  run(plant, leant, 1.0);
  const double both_n = plant.harness_force(leant).forward_n;
  plant.cut_strap(Side::right, true);
  EXPECT_NEAR(plant.strut_alpha_rad(Side::right), std::atan(0.10 / 0.80), 1e-9) << "from where it was";
  run(plant, leant, 1.0);
  EXPECT_NEAR(plant.strut_alpha_rad(Side::right), 0.0, 1e-3);
  EXPECT_NEAR(plant.strut_beta_rad(Side::right), 0.0, 1e-3);
  EXPECT_NEAR(plant.body_alpha_rad(Side::right), std::atan(0.10 / 0.80), 1e-9);
  EXPECT_NEAR(plant.strut_alpha_rad(Side::left), std::atan(0.10 / 0.80), 1e-9);
  EXPECT_NEAR(plant.harness_force(leant).forward_n, both_n / 2.0, 1e-9);
  EXPECT_NEAR(plant.harness_force(leant).turn_n_m, -0.3 * both_n / 2.0, 1e-9) << "the left one alone turns it to the right";
  EXPECT_TRUE(plant.holds_body());
  plant.cut_strap(Side::left, true);
  EXPECT_FALSE(plant.holds_body());
  EXPECT_EQ(plant.harness_force(leant).forward_n, 0.0);
  for (const Side side : {Side::left, Side::right}) plant.cut_strap(side, false);
  run(plant, leant, 1.0);
  EXPECT_EQ(plant.strut_alpha_rad(Side::left), plant.body_alpha_rad(Side::left)) << "it follows again";
}

TEST(Plant, ALooseTiltBoxShowsMoreLeanThanItsStrutHas) {
  Plant plant({}, 1);
  const double play_rad = 8.0 * kDegree_rad;
  plant.loosen_box(Place::left_strut, play_rad);
  for (const double dx_m : {0.05, -0.05}) {
    double lean_rad = 0.0, tipped_rad = 0.0;
    for (int i = 0; i < 100; ++i) {
      run(plant, {dx_m, 0.0, 0.0}, 0.01);
      const ImuReading seen = plant.read_imu(Place::left_strut);
      tipped_rad += seen.alpha_rate_rad_s * 0.01;
      if (i >= 50) lean_rad += std::atan2(-seen.ax_m_s2, seen.az_m_s2) / 50.0;
    }
    EXPECT_NEAR(lean_rad, std::copysign(std::atan(0.05 / 0.8) + play_rad, dx_m), 0.01);
    EXPECT_NEAR(tipped_rad, std::copysign(dx_m > 0.0 ? play_rad : 2.0 * play_rad, dx_m), 0.03) << "its gyroscope tips with it";
  }
  plant.loosen_box(Place::left_strut, 0.0);
  run(plant, {}, 1.0);
  for (int i = 0; i < 100; ++i) (void)plant.read_imu(Place::left_strut), run(plant, {}, 0.01);
  EXPECT_NEAR(plant.read_imu(Place::left_strut).ax_m_s2, 0.0, 0.2);
}

TEST(Plant, ARampLeansAllSensorsAlikeAndDrawsDownhill) {
  Plant plant({}, 1);
  plant.tilt_floor(6.0 * kDegree_rad, kPi);  // falls behind the machine
  run(plant, {}, 3.0);
  EXPECT_NEAR(plant.chassis_alpha_rad(), -6.0 * kDegree_rad, 1e-3);
  EXPECT_NEAR(plant.chassis_beta_rad(), 0.0, 1e-3);
  for (const Place place : {Place::left_strut, Place::right_strut, Place::chassis}) {
    double ax_m_s2 = 0.0;
    for (int i = 0; i < 200; ++i) {
      run(plant, {}, 0.01);
      ax_m_s2 += plant.read_imu(place).ax_m_s2 / 200.0;
    }
    EXPECT_NEAR(ax_m_s2, kGravity_m_s2 * std::sin(6.0 * kDegree_rad), 0.15);
  }
  EXPECT_NEAR(plant.platform().speed_m_s, 0.0, 1e-6) << "the brakes hold: 61 N of 160";
  // Let roll: 60 kg x g x sin(6 deg) against the motors' short circuit.
  enable(plant, 0.0, 0.0);
  run(plant, {}, 2.0);
  EXPECT_LT(plant.platform().speed_m_s, -0.005);
  // To the left: it leans left and does not roll.
  plant.place(0.0, 0.0, kPi / 2.0);
  plant.set_bridge(Side::left, false, 0.0);
  plant.set_bridge(Side::right, false, 0.0);
  run(plant, {}, 2.0);
  EXPECT_NEAR(plant.chassis_beta_rad(), -6.0 * kDegree_rad, 1e-3);
  EXPECT_NEAR(plant.chassis_alpha_rad(), 0.0, 1e-3);
  plant.tilt_floor(std::numeric_limits<double>::quiet_NaN(), 0.0);
  plant.tilt_floor(2.0, 0.0);
  run(plant, {}, 2.0);
  EXPECT_NEAR(plant.floor_slope_rad(), 6.0 * kDegree_rad, 1e-6);
}

TEST(Plant, NonsenseFromABoardMovesNothing) {
  Plant plant({}, 1);
  enable(plant, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity());
  run(plant, {}, 0.5);
  EXPECT_TRUE(std::isfinite(plant.platform().speed_m_s));
  EXPECT_NEAR(plant.platform().speed_m_s, 0.0, 1e-3);
  enable(plant, 5.0, 5.0);  // more than the supply
  EXPECT_EQ(plant.duty_norm(Side::left), 1.0);
  plant.step({}, -1.0);
  plant.step({}, std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(std::isfinite(plant.platform().x_m));
}

TEST(Plant, ABarOfFixedWidthDrawsTheStrutsInward) {
  PlantParams params;
  params.bar_stiff_norm = 1.0;
  Plant stiff(params, 1), sliding({}, 1);
  HarnessMotion turned;
  turned.yaw_rad = 25.0 * kDegree_rad;
  stiff.step(turned, kTick_s);
  sliding.step(turned, kTick_s);
  const double inward_rad = std::atan(0.3 * (1.0 - std::cos(turned.yaw_rad)) / 0.8);
  EXPECT_NEAR(stiff.strut_beta_rad(Side::left), inward_rad, 1e-9);
  EXPECT_NEAR(stiff.strut_beta_rad(Side::right), -inward_rad, 1e-9);
  EXPECT_NEAR(sliding.strut_beta_rad(Side::left), 0.0, 1e-12);
  EXPECT_NEAR(sliding.strut_alpha_rad(Side::right), std::atan(0.3 * std::sin(turned.yaw_rad) / 0.8), 1e-9);
}

}  // namespace
}  // namespace hoist::sim
