// The calculators of calibration alone: hidden true values, tape readings, and expected results.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "control/core/calibrate/bumper_check.hpp"
#include "control/core/calibrate/gyro_bias.hpp"
#include "control/core/calibrate/pairs.hpp"
#include "control/core/calibrate/sensor_zero.hpp"
#include "control/core/calibrate/still_window.hpp"
#include "control/core/calibrate/strut_geometry.hpp"
#include "control/core/calibrate/umbmark.hpp"
#include "control/core/calibrate/wheel_signs.hpp"
#include "control/core/calibrate/wheel_travel.hpp"

namespace hoist::core::test {
namespace {

using contract::CalibrationReason;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180.0;

double between(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

TEST(Calibrators, AStillWindowNeverContainsAMovement) {
  StillWindow<1> window;
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(window.add({1.0 + 0.01 * (i % 2)}, {0.02}));
  EXPECT_EQ(window.ticks(), 50U);
  EXPECT_NEAR(window.mean(0), 1.005, 1e-9);
  EXPECT_FALSE(window.add({1.05}, {0.02}));
  EXPECT_EQ(window.ticks(), 0U);
  ASSERT_TRUE(window.add({1.05}, {0.02}));
  EXPECT_NEAR(window.mean(0), 1.05, 1e-12) << "nothing of before";
  EXPECT_FALSE(window.add({kNaN}, {0.02}));
  EXPECT_EQ(window.ticks(), 0U);
}

TEST(Calibrators, ASensorMoreThanThreeDegreesOffIsRefused) {
  EXPECT_DOUBLE_EQ(sensor_zero(0.02).value, 0.02);
  EXPECT_EQ(sensor_zero(3.01 * kDegree).reason, CalibrationReason::zero_too_large);
  EXPECT_EQ(sensor_zero(-3.01 * kDegree).reason, CalibrationReason::zero_too_large);
  EXPECT_EQ(sensor_zero(kNaN).reason, CalibrationReason::zero_too_large);
}

TEST(Calibrators, AGyroscopeThatDriftsOrIsBrokenIsRefused) {
  EXPECT_DOUBLE_EQ(gyro_bias(0.01, 0.0005).value, 0.01);
  EXPECT_EQ(gyro_bias(0.01, 0.002).reason, CalibrationReason::still_settling);
  EXPECT_EQ(gyro_bias(2.6 * kDegree, 0.0).reason, CalibrationReason::gyro_too_large);
  EXPECT_EQ(gyro_bias(kNaN, 0.0).reason, CalibrationReason::gyro_too_large);
}

TEST(Calibrators, StrutsAreFoundWithinAPerCentWhateverTheMiddleIs) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const double length_m = between(random, 0.7, 0.9), spacing_m = between(random, 0.52, 0.68), middle_m = between(random, -0.02, 0.02);
    MeasuredPairs ways, turns;
    for (const double way_m : {0.12, -0.12, 0.10, -0.13}) {
      // A millimetre of the tape, two hundredths of a degree of the sensors.
      const double alpha = std::atan((way_m + middle_m) / length_m) + between(random, -0.02, 0.02) * kDegree;
      ASSERT_TRUE(ways.add(std::tan(alpha), way_m + between(random, -0.001, 0.001)));
    }
    const Outcome length = strut_length(ways, 0.8);
    ASSERT_TRUE(length.good()) << i;
    EXPECT_NEAR(length.value, length_m, 0.01 * length_m);
    for (const double turn : {6 * kDegree, 12 * kDegree, -12 * kDegree}) {
      const double half_m = spacing_m / 2 * std::sin(turn);
      ASSERT_TRUE(turns.add(2 * half_m / length_m, std::sin(turn + between(random, -0.1, 0.1) * kDegree)));
    }
    const Outcome spacing = strut_spacing(turns, length_m, 0.6);
    ASSERT_TRUE(spacing.good()) << i;
    EXPECT_NEAR(spacing.value, spacing_m, 0.012 * spacing_m);
  }
}

// Four millimetres that the hand was off are 15 % of three centimetres, and no line shows them.
TEST(Calibrators, PlacesNearToEachOtherAreTooLittle) {
  constexpr double kLength_m = 0.8, kSpacing_m = 0.6;
  MeasuredPairs ways, turns;
  for (const double side : {1.0, -1.0, 1.0}) {
    ASSERT_TRUE(ways.add(side * 0.026 / kLength_m, side * 0.03));
    ASSERT_TRUE(turns.add(side * kSpacing_m * std::sin(0.05 * 0.026 / 0.03) / kLength_m, side * std::sin(0.05)));
  }
  EXPECT_EQ(strut_length(ways, kLength_m).reason, CalibrationReason::too_little) << strut_length(ways, kLength_m).value;
  EXPECT_EQ(strut_spacing(turns, kLength_m, kSpacing_m).reason, CalibrationReason::too_little)
      << strut_spacing(turns, kLength_m, kSpacing_m).value;
  EXPECT_EQ(strut_length(MeasuredPairs{}, kLength_m).reason, CalibrationReason::too_little);
  // Ten centimetres are enough, for any centre.
  MeasuredPairs aside;
  for (const double way_m : {0.07, 0.04, -0.031}) ASSERT_TRUE(aside.add(way_m / kLength_m, way_m));
  ASSERT_TRUE(strut_length(aside, kLength_m).good());
  EXPECT_NEAR(strut_length(aside, kLength_m).value, kLength_m, 1e-9);
}

TEST(Calibrators, AWrongFigureOfTheTapeIsNotBelieved) {
  MeasuredPairs half;
  ASSERT_TRUE(half.add(0.15, 0.06));
  ASSERT_TRUE(half.add(-0.15, -0.06));
  EXPECT_EQ(strut_length(half, 0.8).reason, CalibrationReason::implausible);
  MeasuredPairs contrary;
  ASSERT_TRUE(contrary.add(0.15, -0.12));
  ASSERT_TRUE(contrary.add(-0.15, 0.12));
  EXPECT_EQ(strut_length(contrary, 0.8).reason, CalibrationReason::implausible);
  MeasuredPairs unlike;
  ASSERT_TRUE(unlike.add(20.0, 2.0));
  ASSERT_TRUE(unlike.add(-20.0, -2.1));
  EXPECT_EQ(wheel_radius(unlike, 1.0, 0.1).reason, CalibrationReason::disagree);
  MeasuredPairs centimetres;
  ASSERT_TRUE(centimetres.add(20.0, 0.02));
  ASSERT_TRUE(centimetres.add(-20.0, -0.02));
  EXPECT_EQ(wheel_radius(centimetres, 1.0, 0.1).reason, CalibrationReason::implausible);
  EXPECT_EQ(wheel_radius(MeasuredPairs{}, 1.0, 0.1).reason, CalibrationReason::too_little);
  EXPECT_EQ(track_width(MeasuredPairs{}, 3.1, 0.7).reason, CalibrationReason::too_little);
  MeasuredPairs turns;
  ASSERT_TRUE(turns.add(0.74 * 2 * std::numbers::pi, 2 * std::numbers::pi));
  ASSERT_TRUE(turns.add(-0.74 * 2 * std::numbers::pi, -2 * std::numbers::pi));
  EXPECT_NEAR(track_width(turns, 3.1, 0.7).value, 0.74, 1e-12);
}

// A square driven by odometry that assumes what it assumes, on a machine that is what it is; where it truly ends.
SquareError drive_square(double side_m, bool left, double assumed_track_m, double true_track_m, double left_norm, double right_norm) {
  std::complex<double> at = 0;
  double heading = 0;
  const auto go = [&](double left_m, double right_m) {  // as the odometry counts them
    constexpr int kPieces = 2000;
    const double l = left_m * left_norm / kPieces, r = right_m * right_norm / kPieces;
    for (int i = 0; i < kPieces; ++i) {
      const double turn = (r - l) / true_track_m;
      at += (l + r) / 2 * std::polar(1.0, heading + turn / 2);
      heading += turn;
    }
  };
  const double corner_m = std::numbers::pi / 4 * assumed_track_m * (left ? 1 : -1);
  for (int i = 0; i < 4; ++i) {
    go(side_m, side_m);
    go(-corner_m, corner_m);
  }
  return {at.real(), at.imag()};
}

TEST(Calibrators, UmbmarkFindsTrackAndUnequalWheelsFromTwoSquares) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    const double side_m = between(random, 2.0, 4.0), track_m = 0.7 * between(random, 0.96, 1.04), unequal = between(random, -0.008, 0.008);
    const SquareError left = drive_square(side_m, true, 0.7, track_m, 1 - unequal, 1 + unequal);
    const SquareError right = drive_square(side_m, false, 0.7, track_m, 1 - unequal, 1 + unequal);
    const SquareResult found = umbmark(side_m, left, right, 0.7);
    ASSERT_EQ(found.reason, CalibrationReason::none) << i;
    EXPECT_NEAR(found.track_norm * 0.7, track_m, 0.01 * track_m) << i;
    EXPECT_NEAR(found.left_scale_norm, 1 - unequal, 0.001);
    EXPECT_NEAR(found.right_scale_norm, 1 + unequal, 0.001);
    EXPECT_NEAR(found.left_scale_norm + found.right_scale_norm, 2.0, 1e-12);
    // What is left after one correction drives a square that closes at least eight times better.
    const SquareError again = drive_square(side_m, true, 0.7 * found.track_norm, track_m, (1 - unequal) / found.left_scale_norm,
                                           (1 + unequal) / found.right_scale_norm);
    EXPECT_LE(std::hypot(again.x_m, again.y_m), std::hypot(left.x_m, left.y_m) / 8 + 0.01);
  }
}

TEST(Calibrators, SquaresThatContradictThemselvesAreRefused) {
  EXPECT_EQ(umbmark(3.0, {0.3, 0.3}, {0.1, 0.1}, 0.7).reason, CalibrationReason::disagree);
  EXPECT_EQ(umbmark(3.0, {2.9, -2.9}, {2.9, 2.9}, 0.7).reason, CalibrationReason::implausible);
  EXPECT_EQ(umbmark(3.0, {kNaN, 0}, {0, 0}, 0.7).reason, CalibrationReason::implausible);
  const SquareResult perfect = umbmark(3.0, {0, 0}, {0, 0}, 0.7);
  EXPECT_EQ(perfect.reason, CalibrationReason::none);
  EXPECT_DOUBLE_EQ(perfect.track_norm, 1.0);
  EXPECT_DOUBLE_EQ(perfect.left_scale_norm, 1.0);
}

// H2: an encoder that counts backward makes a drive run away.
TEST(Calibrators, WheelsThatCountWronglyAreNamed) {
  EXPECT_EQ(judge_push(0.5, 0.5), CalibrationReason::none);
  EXPECT_EQ(judge_push(-0.5, 0.5), CalibrationReason::left_encoder_reversed);
  EXPECT_EQ(judge_push(0.5, -0.5), CalibrationReason::right_encoder_reversed);
  EXPECT_EQ(judge_push(-0.5, -0.5), CalibrationReason::both_backward);
  EXPECT_EQ(judge_push(0.0, 0.5), CalibrationReason::left_encoder_dead);
  EXPECT_EQ(judge_push(0.5, 0.02), CalibrationReason::right_encoder_dead);
  EXPECT_EQ(judge_turn(-0.3, 0.3, 1.2), CalibrationReason::none);
  EXPECT_EQ(judge_turn(0.3, -0.3, 1.2), CalibrationReason::encoders_swapped);
  EXPECT_EQ(judge_turn(0.3, -0.3, -1.2), CalibrationReason::turned_right);
}

// H13: a bumper that is wired to another's place.
TEST(Calibrators, BumpersAreCheckedOneAfterTheOther) {
  BumperCheck good;
  for (const std::uint8_t strip : {1, 2, 4, 8}) {
    for (int i = 0; i < 30; ++i) EXPECT_EQ(good.step(0), CalibrationReason::none);
    for (int i = 0; i < 30; ++i) EXPECT_EQ(good.step(strip), CalibrationReason::none);
  }
  EXPECT_FALSE(good.done()) << "the last one is still pressed";
  good.step(0);
  EXPECT_TRUE(good.done());
  BumperCheck swapped;
  swapped.step(0);
  EXPECT_EQ(swapped.step(2), CalibrationReason::bumper_swapped);
  BumperCheck stuck;
  CalibrationReason reason = CalibrationReason::none;
  for (int i = 0; i < 400 && reason == CalibrationReason::none; ++i) reason = stuck.step(4);
  EXPECT_EQ(reason, CalibrationReason::bumper_stuck);
}

}  // namespace
}  // namespace hoist::core::test
