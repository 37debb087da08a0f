// Bounds of every motion under extreme wishes.
#include <gtest/gtest.h>

#include <cstdint>
#include <random>

#include "control/core/output/limiter.hpp"
#include "control/core/output/wheel_mixing.hpp"
#include "control/core/types.hpp"

namespace hoist::core {
namespace {

constexpr double kRounding = 1e-9;

TEST(Limiter, NeverExceedsAnyBoundUnderRandomWishes) {
  std::mt19937_64 random(20261121);
  std::uniform_real_distribution<double> wide(-3.0, 3.0), unit(0.0, 1.0);
  for (int run = 0; run < 200; ++run) {
    contract::Params p;
    p.speed_m_s_max = 0.05 + 0.6 * unit(random);
    p.acceleration_m_s2_max = 0.05 + 0.45 * unit(random);
    p.jerk_m_s3_max = 0.5 + 19.5 * unit(random);
    p.yaw_rate_rad_s_max = 0.05 + 0.8 * unit(random);
    p.yaw_acceleration_rad_s2_max = 0.1 + 1.9 * unit(random);
    p.track_width_m = 0.3 + 0.9 * unit(random);
    p.wheel_radius_m = 0.03 + 0.1 * unit(random);
    p.wheel_left_scale_norm = 0.9 + 0.2 * unit(random);
    const double outer_m_s_max = kMotorTop_rad_s / derive(p).left_motor_per_m * std::fmin(1.0, 1.0 / p.wheel_left_scale_norm);
    Limiter limiter;
    double speed = 0, wish_yaw = 0;
    for (int i = 0; i < 3000; ++i) {
      if (i % (1 + static_cast<int>(random() % 150)) == 0) {
        speed = wide(random);
        wish_yaw = wide(random);
      }
      const double v = limiter.speed_m_s(), a = limiter.acceleration_m_s2(), w = limiter.yaw_rate_rad_s();
      limiter.step(p, Braking::none, speed, wish_yaw, false, kTick_s);
      ASSERT_LE(std::abs(limiter.speed_m_s()), p.speed_m_s_max + kRounding) << run << " " << i;
      ASSERT_LE(std::abs(limiter.speed_m_s() - v) / kTick_s, p.acceleration_m_s2_max + 1e-6);
      ASSERT_LE(std::abs(limiter.acceleration_m_s2() - a) / kTick_s, p.jerk_m_s3_max + 1e-6);
      ASSERT_LE(std::abs(limiter.yaw_rate_rad_s()), p.yaw_rate_rad_s_max + kRounding);
      ASSERT_LE(std::abs(limiter.yaw_rate_rad_s() - w) / kTick_s, p.yaw_acceleration_rad_s2_max + 1e-6);
      const double outer_m_s = std::abs(limiter.speed_m_s()) + std::abs(limiter.yaw_rate_rad_s()) * p.track_width_m / 2;
      // A turn that a rising speed takes the room from ends on its own ramp.
      ASSERT_LE(outer_m_s, 1.03 * outer_m_s_max) << run << " " << i;
    }
  }
}

TEST(Limiter, ReachesItsTargetWithoutOvershoot) {
  const contract::Params p;
  for (const double target : {0.001, 0.0123, 0.1, 0.3, 0.65, -0.2, -0.65}) {
    Limiter limiter;
    double largest = 0;
    int reached = 0;
    for (int i = 0; i < 400; ++i) {
      limiter.step(p, Braking::none, target, 0, false, kTick_s);
      largest = std::max(largest, std::abs(limiter.speed_m_s()));
      if (reached == 0 && limiter.speed_m_s() == target) reached = i;
    }
    EXPECT_LE(largest, std::abs(target) + kRounding);
    EXPECT_EQ(limiter.speed_m_s(), target) << "exactly";
    EXPECT_LE(reached * kTick_s, std::abs(target) / 0.5 + 0.5 / 3.0 + 0.1) << "and not lazily";
  }
}

// H1: the fastest walk and the fastest turn together would need 0.96 m/s of the outer wheel.
TEST(Limiter, H1_ATurnHasItsWayAndTheHoistSlowsDownForIt) {
  const contract::Params p;
  for (const double sign : {1.0, -1.0}) {
    Limiter limiter;
    const auto lead = [&](double speed_m_s, double yaw_rate_rad_s) {
      for (int i = 0; i < 400; ++i) limiter.step(p, Braking::none, sign * speed_m_s, yaw_rate_rad_s, false, kTick_s);
    };
    lead(0.65, 0.1);
    EXPECT_NEAR(limiter.speed_m_s(), sign * 0.65, 1e-9);
    EXPECT_NEAR(limiter.yaw_rate_rad_s(), 0.1, 1e-9) << "it steers at its top speed";
    EXPECT_EQ(limiter.cause(), contract::SpeedCause::none);
    lead(0.65, 5.0);
    EXPECT_NEAR(limiter.yaw_rate_rad_s(), p.yaw_rate_rad_s_max, 1e-9);
    EXPECT_NEAR(limiter.speed_m_s(), sign * (0.70 - p.yaw_rate_rad_s_max * 0.35), 1e-9);
    EXPECT_EQ(limiter.cause(), contract::SpeedCause::turn);
    lead(0.65, -0.3);
    EXPECT_NEAR(limiter.yaw_rate_rad_s(), -0.3, 1e-9);
    EXPECT_NEAR(limiter.speed_m_s(), sign * (0.70 - 0.3 * 0.35), 1e-9);
    lead(0.3, 0.5);
    EXPECT_NEAR(limiter.speed_m_s(), sign * 0.3, 1e-9) << "slow enough for it as it is";
    lead(0.65, 0.0);
    EXPECT_NEAR(limiter.speed_m_s(), sign * 0.65, 1e-9);
  }
}

// H15: a lean caused by the hoist's own slowing is judged later. The speed that a turn takes and returns causes none; a wished change is as quick
// as ever, also in a turn.
TEST(Limiter, H15_ATurnChangesTheSpeedMoreGentlyThanAWish) {
  const contract::Params p;
  Limiter limiter;
  double hardest_m_s2 = 0;
  const auto lead = [&](double speed_m_s, double yaw_rate_rad_s, int ticks) {
    hardest_m_s2 = 0;
    for (int i = 0; i < ticks; ++i) {
      limiter.step(p, Braking::none, speed_m_s, yaw_rate_rad_s, false, kTick_s);
      hardest_m_s2 = std::max(hardest_m_s2, std::abs(limiter.acceleration_m_s2()));
    }
  };
  lead(0.65, 0.0, 400);
  EXPECT_NEAR(hardest_m_s2, 0.5, 1e-9);
  for (int i = 0; i < 10; ++i) {
    lead(0.65, i % 2 == 0 ? 0.8 : 0.0, 70 + 30 * (i % 3));
    EXPECT_GT(hardest_m_s2, 0.2) << i;
    EXPECT_LE(hardest_m_s2, 0.3 + 1e-9) << i;
  }
  lead(0.65, 0.8, 300);
  lead(0.1, 0.8, 30);
  EXPECT_NEAR(hardest_m_s2, 0.5, 1e-9) << "to slow down";
  lead(0.65, 0.8, 300);
  lead(-0.3, 0.8, 30);
  EXPECT_NEAR(hardest_m_s2, 0.5, 1e-9) << "to go back";
  // A lean that falls off a little, in the middle of a turn.
  for (const double falls_m_s2 : {0.05, 0.2, 0.29}) {
    lead(0.65, 0.0, 400);
    double wish_m_s = 0.65, worst_m_s2 = 0;
    for (int i = 0; i < 60; ++i) {
      lead(wish_m_s -= falls_m_s2 * kTick_s, 0.87, 1);
      worst_m_s2 = std::max(worst_m_s2, hardest_m_s2);
    }
    EXPECT_LE(worst_m_s2, 0.3 + 1e-9) << falls_m_s2;
  }
}

TEST(Limiter, AHoistThatSpeedsUpInATurnDoesSoAsQuicklyAsAnyOther) {
  const contract::Params p;
  const auto ticks_to = [&p](double speed_m_s, const auto& yaw_rate_rad_s) {
    Limiter limiter;
    int ticks = 0;
    for (; limiter.speed_m_s() < speed_m_s - 1e-6 && ticks < 1000; ++ticks)
      limiter.step(p, Braking::none, 0.6, yaw_rate_rad_s(ticks), false, kTick_s);
    return ticks;
  };
  const int straight = ticks_to(0.6, [](int) { return 0.0; });
  EXPECT_EQ(ticks_to(0.6, [](int tick) { return tick == 20 ? 0.8 : 0.0; }), straight);
  EXPECT_EQ(ticks_to(0.6, [](int tick) { return 0.15 * std::sin(0.06 * tick); }), straight);
  EXPECT_LE(ticks_to(0.39, [](int) { return 0.87; }), straight);
  // The return after a turn, with a rising wish, ends when the speed has returned.
  Limiter limiter;
  for (int i = 0; i < 300; ++i) limiter.step(p, Braking::none, 0.5, 0.87, false, kTick_s);
  for (int i = 0; i < 1500; ++i) limiter.step(p, Braking::none, 0.5 + 1e-5 * i, 0.0, false, kTick_s);
  for (int i = 0; i < 20; ++i) limiter.step(p, Braking::none, 0.65, 0.0, false, kTick_s);
  EXPECT_GT(limiter.acceleration_m_s2(), 0.4);
}

// Small wheels far apart could give all they have to a turn: the walk would end in one on the spot.
TEST(Limiter, ATurnTakesHalfOfWhatTheWheelsHaveAtMost) {
  contract::Params p;
  p.track_width_m = 1.2;
  p.wheel_radius_m = 0.05;
  Limiter limiter;
  for (int i = 0; i < 1000; ++i) limiter.step(p, Braking::none, 0.6, p.yaw_rate_rad_s_max, false, kTick_s);
  EXPECT_NEAR(limiter.speed_m_s(), 0.175, 1e-9);
  EXPECT_NEAR(limiter.yaw_rate_rad_s(), 0.175 / 0.6, 1e-9);
  for (int i = 0; i < 1000; ++i) limiter.step(p, Braking::none, 0, p.yaw_rate_rad_s_max, false, kTick_s);
  EXPECT_NEAR(limiter.yaw_rate_rad_s(), 0.35 / 0.6, 1e-9) << "standing it may have all";
}

TEST(Limiter, TheCapOfThePatientHolds) {
  contract::Params p;
  p.speed_cap_norm = 0.2;
  Limiter limiter;
  for (int i = 0; i < 500; ++i) {
    limiter.step(p, Braking::none, 5.0, 0, false, kTick_s);
    ASSERT_LE(limiter.speed_m_s(), 0.13 + kRounding);
  }
  EXPECT_NEAR(limiter.speed_m_s(), 0.13, 1e-9);
  EXPECT_EQ(limiter.cause(), contract::SpeedCause::cap);
  limiter.step(p, Braking::none, 0.14, 0, false, kTick_s);
  EXPECT_EQ(limiter.cause(), contract::SpeedCause::none) << "so little is not told";
  limiter.step(p, Braking::soft, 5.0, 0, false, kTick_s);
  EXPECT_EQ(limiter.cause(), contract::SpeedCause::none) << "a stop is no limit";
}

// The last limit that lowers the speed is the one in force.
TEST(LimitedSpeed, TellsTheTightestLimitInEitherDirection) {
  using contract::SpeedCause;
  for (const double sign : {1.0, -1.0}) {
    LimitedSpeed speed{sign * 0.6};
    speed.share(0.5, SpeedCause::patient_lag);
    speed.share(1.0, SpeedCause::command_age);
    EXPECT_EQ(speed.cause(), SpeedCause::patient_lag);
    speed.within(0.4, SpeedCause::cap);
    EXPECT_EQ(speed.cause(), SpeedCause::patient_lag);
    EXPECT_EQ(speed.m_s(), sign * 0.3);
    speed.within(0.2, SpeedCause::slope);
    EXPECT_EQ(speed.m_s(), sign * 0.2);
    EXPECT_EQ(speed.cause(), SpeedCause::slope);
    speed.within(0.0, 0.1, SpeedCause::bumper);
    EXPECT_EQ(speed.m_s(), sign > 0 ? 0.1 : 0.0);
    EXPECT_EQ(speed.cause(), SpeedCause::bumper);
  }
}

TEST(Limiter, EachStopBrakesAtItsOwnRateAndNeverHarder) {
  const contract::Params p;
  const std::pair<Braking, double> stops[] = {
      {Braking::soft, 0.5}, {Braking::remote, 0.8}, {Braking::protective, 1.0}, {Braking::bumper, 1.5}};
  for (const auto& [braking, rate] : stops) {
    for (const double turn : {0.0, 0.5, -0.8}) {
      Limiter limiter;
      for (int i = 0; i < 400; ++i) limiter.step(p, Braking::none, 0.6, turn, false, kTick_s);
      const double v0 = limiter.speed_m_s();
      int ticks = 0;
      while (!limiter.at_rest() && ticks < 1000) {
        const double v = limiter.speed_m_s(), w = limiter.yaw_rate_rad_s();
        // Wishes meanwhile do not count.
        limiter.step(p, braking, 0.65, -turn, false, kTick_s);
        ASSERT_LE(v - limiter.speed_m_s(), rate * kTick_s + kRounding);
        ASSERT_GE(limiter.speed_m_s(), 0.0) << "a stop never reverses";
        ASSERT_LE(std::abs(limiter.yaw_rate_rad_s()), std::abs(w));
        ++ticks;
      }
      EXPECT_NEAR(ticks * kTick_s, v0 / rate, 0.5) << "the turn may end a little later than the speed";
      EXPECT_EQ(limiter.speed_m_s(), 0.0);
    }
  }
}

TEST(Limiter, AStopThatEndsEarlyDoesNotCarryIntoReverse) {
  const contract::Params p;
  Limiter limiter;
  for (int i = 0; i < 200; ++i) limiter.step(p, Braking::none, 0.3, 0, false, kTick_s);
  while (limiter.speed_m_s() > 0.015) limiter.step(p, Braking::protective, 0, 0, false, kTick_s);
  for (int i = 0; i < 200; ++i) {
    limiter.step(p, Braking::none, 0.3, 0, false, kTick_s);
    ASSERT_GE(limiter.speed_m_s(), 0.0);
  }
  EXPECT_NEAR(limiter.speed_m_s(), 0.3, 1e-9);
}

TEST(Limiter, WhatIsNotANumberCountsAsZero) {
  const contract::Params p;
  Limiter limiter;
  for (int i = 0; i < 200; ++i) limiter.step(p, Braking::none, 0.3, 0.3, false, kTick_s);
  for (int i = 0; i < 200; ++i) limiter.step(p, Braking::none, i % 2 == 0 ? NAN : HUGE_VAL, -HUGE_VAL, false, kTick_s);
  EXPECT_EQ(limiter.speed_m_s(), 0.0);
  EXPECT_EQ(limiter.yaw_rate_rad_s(), 0.0);
  limiter.start_from(p, NAN, HUGE_VAL);
  EXPECT_TRUE(limiter.at_rest());
  limiter.start_from(p, 9, 9);
  EXPECT_LE(limiter.speed_m_s(), p.speed_m_s_max);
}

TEST(WheelMixing, LeftTurnDrivesTheRightWheelFasterAndKeepsTheCurveAtTheDrivesLimit) {
  contract::Params p;
  const Derived d = derive(p);
  const WheelCommand wheels = mix_wheels(0.3, 0.5, d);
  EXPECT_EQ(wheels.left_raw, std::lround((0.3 - 0.5 * 0.35) / 0.1 * 30 * 1000));
  EXPECT_EQ(wheels.right_raw, std::lround((0.3 + 0.5 * 0.35) / 0.1 * 30 * 1000));
  const WheelCommand limit = mix_wheels(3.0, 2.0, d);
  EXPECT_EQ(limit.right_raw, 400000);
  EXPECT_NEAR(static_cast<double>(limit.left_raw) / limit.right_raw, (3.0 - 0.7) / (3.0 + 0.7), 1e-5);
  const WheelCommand nothing = mix_wheels(NAN, 0, d);
  EXPECT_EQ(nothing.left_raw, 0);
  EXPECT_EQ(nothing.right_raw, 0);
}

TEST(WheelMixing, ACalibratedWheelIsCommandedByItsOwnRadius) {
  contract::Params p;
  p.wheel_left_scale_norm = 1.05;
  const Derived d = derive(p);
  const WheelCommand wheels = mix_wheels(0.3, 0, d);
  EXPECT_NEAR(static_cast<double>(wheels.right_raw) / wheels.left_raw, 1.05, 1e-4);
  EXPECT_NEAR(wheel_m_s(wheels.left_raw, d.left_motor_per_m), 0.3, 1e-5);
}

}  // namespace
}  // namespace hoist::core
