// Removal of the gait's sway from lean and turn: its size, its delay, and no ringing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "control/core/law/gait_cancel.hpp"

namespace hoist::law {
namespace {

constexpr double kStep_s = 0.01, kTwoPi = 2.0 * std::numbers::pi;
constexpr double kSway_m = 0.03, kTwist_rad = 0.044, kBob_m = 0.012;

// A walker: sideways sway, with twist and bob at any phase, added to a wish.
struct Walker {
  GaitCancelConfig<double> config;
  GaitCancelState<double> state;
  GaitPart<double> part;
  double phase_rad = 0.4, hz = 0.6, size = 1.0, sway_offset_m = 0.01, twist_phase_rad = 1.1;
  double wish_rad = 0, wish_m = 0.05;
  double gait_rad = 0, gait_m = 0;  // of this step: what should be removed

  void step() {
    phase_rad += kTwoPi * hz * kStep_s;
    gait_rad = size * kTwist_rad * std::sin(phase_rad + twist_phase_rad);
    gait_m = size * kBob_m * std::sin(2.0 * phase_rad + 0.3);
    part = gait_cancel_step(config, state, wish_m + gait_m, sway_offset_m + size * kSway_m * std::cos(phase_rad), wish_rad + gait_rad,
                            kStep_s);
  }
  void run(double seconds) {
    for (double left_s = seconds; left_s > kStep_s / 2; left_s -= kStep_s) step();
  }
  struct Rms {
    double turn_left = 0, lean_left = 0;  // of what was there, the share that is left
  };
  Rms over(double seconds) {
    double turn = 0, turn_left = 0, lean = 0, lean_left = 0;
    for (double left_s = seconds; left_s > kStep_s / 2; left_s -= kStep_s) {
      step();
      turn += gait_rad * gait_rad;
      turn_left += (gait_rad - part.turn_rad) * (gait_rad - part.turn_rad);
      lean += gait_m * gait_m;
      lean_left += (gait_m - part.lean_m) * (gait_m - part.lean_m);
    }
    return {std::sqrt(turn_left / turn), std::sqrt(lean_left / lean)};
  }
};

TEST(GaitCancel, ASteadyGaitIsTakenOutAtEveryCadence) {
  for (const double hz : {0.45, 0.6, 0.8, 1.2}) {
    SCOPED_TRACE(hz);
    Walker walker;
    walker.hz = hz;
    walker.run(12);
    const auto rms = walker.over(10);
    EXPECT_LT(rms.turn_left, 0.1);
    EXPECT_LT(rms.lean_left, 0.1);
    EXPECT_NEAR(walker.part.stride_hz, hz, 0.02);
  }
}

// Delay of a slow wish: the phase that the removal adds at its frequency.
TEST(GaitCancel, ASlowWishIsDelayedByLessThan30ms) {
  for (const double wish_hz : {0.05, 0.1, 0.2}) {
    SCOPED_TRACE(wish_hz);
    Walker walker;
    walker.run(20);
    double in_sine = 0, in_cosine = 0, out_sine = 0, out_cosine = 0;
    const int steps = static_cast<int>(std::lround(100.0 / kStep_s));  // whole periods of every wish, and of 0.6 Hz
    for (int i = 0; i < steps; ++i) {
      const double at_rad = kTwoPi * wish_hz * i * kStep_s;
      walker.wish_rad = 0.06 * std::sin(at_rad);
      walker.step();
      const double in = walker.wish_rad + walker.gait_rad, out = in - walker.part.turn_rad;
      in_sine += in * std::sin(at_rad);
      in_cosine += in * std::cos(at_rad);
      out_sine += out * std::sin(at_rad);
      out_cosine += out * std::cos(at_rad);
    }
    const double lag_rad = std::remainder(std::atan2(in_cosine, in_sine) - std::atan2(out_cosine, out_sine), kTwoPi);
    EXPECT_LT(std::fabs(lag_rad) / (kTwoPi * wish_hz), 0.030);
    EXPECT_NEAR(std::hypot(out_sine, out_cosine) / std::hypot(in_sine, in_cosine), 1.0, 0.1) << "nor made smaller";
  }
}

TEST(GaitCancel, ItFollowsStepsOfTheCadence) {
  Walker walker;
  walker.run(12);
  for (const double hz : {0.5, 1.2, 0.7, 1.0, 0.5}) {
    SCOPED_TRACE(hz);
    walker.hz = hz;
    double most_rad = 0;
    for (int i = 0; i < 600; ++i) {
      walker.step();
      most_rad = std::max(most_rad, std::fabs(walker.gait_rad - walker.part.turn_rad));
    }
    EXPECT_LT(most_rad, 2.0 * kTwist_rad) << "while it finds the new one, never twice the sway";
    EXPECT_LT(walker.over(4).turn_left, 0.4);
  }
}

TEST(GaitCancel, StandingAndStoppingLeaveNothingThatRings) {
  Walker walker;
  walker.run(20);
  // The gait ends within half a second, as a patient stops.
  for (int i = 0; i < 50; ++i) {
    walker.size = std::max(0.0, 1.0 - i * 0.02);
    walker.step();
  }
  walker.size = 0;
  double late_rad = 0;
  for (int i = 0; i < 300; ++i) {
    walker.step();
    if (i >= 100) late_rad = std::max(late_rad, std::fabs(walker.part.turn_rad));
  }
  EXPECT_LT(late_rad, 0.1 * kTwist_rad);
  // A standing patient who turns keeps the full turn, from the first step on.
  for (int i = 0; i < 1000; ++i) {
    walker.wish_rad = 0.1 * std::sin(0.7 * i * kStep_s);
    walker.wish_m = 0.05 * std::cos(2.0 * i * kStep_s);
    walker.step();
    ASSERT_EQ(walker.part.turn_rad, 0.0);
    ASSERT_EQ(walker.part.lean_m, 0.0);
    ASSERT_EQ(walker.part.stride_hz, 0.0);
  }
  // And walks again: what was learnt is still there.
  walker.wish_rad = 0;
  walker.size = 1;
  walker.run(4);
  EXPECT_LT(walker.over(3).turn_left, 0.4);
}

TEST(GaitCancel, ATurnBegunWhileWalkingIsNotTakenForGait) {
  Walker walker;
  walker.run(20);
  double most_rad = 0, late_rad = 0, wish = 0, rate = 0;
  for (int i = 0; i < 1500; ++i) {
    // A pelvis turned by 0.1 within a quarter of a second: two equal lags, as patients have.
    rate += ((0.1 - wish) / (0.125 * 0.125) - 2.0 * rate / 0.125) * kStep_s;
    wish += rate * kStep_s;
    walker.wish_rad = wish;
    walker.step();
    const double wrong_rad = std::fabs(walker.part.turn_rad - walker.gait_rad);
    most_rad = std::max(most_rad, wrong_rad);
    if (i > 1000) late_rad = std::max(late_rad, wrong_rad);
  }
  EXPECT_LT(most_rad, 0.02);
  EXPECT_LT(late_rad, 0.006);
}

TEST(GaitCancel, NonsenseBeginsAnewAndRemovesNothing) {
  constexpr double kInf = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {kNan, kInf, -kInf, 1e308}) {
    for (int which = 0; which < 3; ++which) {
      Walker walker;
      walker.run(10);
      const auto part =
          gait_cancel_step(walker.config, walker.state, which == 0 ? bad : 0.0, which == 1 ? bad : 0.0, which == 2 ? bad : 0.0, kStep_s);
      EXPECT_TRUE(std::isfinite(part.lean_m) && std::isfinite(part.turn_rad) && std::isfinite(part.sway_m));
      walker.run(20);
      EXPECT_TRUE(std::isfinite(walker.part.turn_rad));
      // A sway of 1e308 m is a number, and spoils the state all the same.
      EXPECT_LT(walker.over(5).turn_left, 0.2);
    }
  }
}

}  // namespace
}  // namespace hoist::law
