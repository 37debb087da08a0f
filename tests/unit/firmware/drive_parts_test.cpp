// The parts of a drive that need no bus: speed from the encoder, and the heat of the winding.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "control/core/law/servo_loop.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/drive/speed_estimate.hpp"
#include "firmware/nodes/drive/winding.hpp"
#include "firmware/sim/motor.hpp"

namespace hoist::firmware {
namespace {

constexpr double kCountsPerTurn = 2000, kTurn_rad = 6.283185307179586;

// An encoder whose four edges in a line are not evenly spaced, as real ones are, on a shaft that turns steadily within a millisecond.
struct Encoder {
  double unevenness = 0;  // share of an edge's width
  double angle_rad = 0.1;
  std::int32_t counts = 0;
  std::uint32_t edge_us = kEdgeTimeUnknown_us;
  double last_edge_us = -1, now_us = 0;
  int last_step = 0;

  double edge_at(std::int64_t n) const {
    static constexpr double kShape[4] = {0, 1, 0.3, -0.7};
    return static_cast<double>(n) + unevenness * kShape[((n % 4) + 4) % 4];
  }
  // Moves on by 1 ms at this mean speed.
  void step(double speed_rad_s) {
    const double from = angle_rad / kTurn_rad * kCountsPerTurn;
    angle_rad += speed_rad_s * 0.001;
    const double to = angle_rad / kTurn_rad * kCountsPerTurn;
    const auto when_us = [&](double edge) { return now_us + 1000 * (edge - from) / (to - from); };
    for (; to > from && edge_at(counts + 1) <= to; ++counts) pass(1, when_us(edge_at(counts + 1)));
    for (; to < from && edge_at(counts) > to; --counts) pass(-1, when_us(edge_at(counts)));
    now_us += 1000;
  }
  void pass(int step, double at_us) {
    const double gap_us = at_us - last_edge_us;
    edge_us = step == last_step && last_edge_us >= 0 ? static_cast<std::uint32_t>(std::max(1.0, gap_us)) : kEdgeTimeUnknown_us;
    last_step = step;
    last_edge_us = at_us;
  }
};

constexpr double kRadPerCount_ms = kTurn_rad / kCountsPerTurn / 0.001;

TEST(SpeedEstimate, AtAnySteadySpeedItIsNearerThanTheDifference) {
  for (const double uneven : {0.0, 0.15}) {
    for (const double speed : {0.3, 1.0, 2.5, -2.5, 7.0, 20.0, -60.0, 200.0}) {
      SCOPED_TRACE(testing::Message() << speed << " rad/s, unevenness " << uneven);
      Encoder encoder{uneven};
      SpeedEstimate estimate;
      estimate.restart(encoder.counts);
      double worst = 0, worst_difference = 0;
      std::int32_t before = encoder.counts;
      for (int i = 0; i < 3000; ++i) {
        encoder.step(speed);
        const double measured = kRadPerCount_ms * estimate.step(encoder.counts, encoder.edge_us);
        const double difference = kRadPerCount_ms * (encoder.counts - before);
        before = encoder.counts;
        if (i < 200) continue;
        worst = std::max(worst, std::fabs(measured - speed));
        worst_difference = std::max(worst_difference, std::fabs(difference - speed));
      }
      EXPECT_LE(worst, worst_difference + 0.01);
      EXPECT_LE(worst, kRadPerCount_ms * 1.2);  // never further than one count of a tick
      if (std::fabs(speed) < 2.9) {             // one line period is averaged; the quiet time between two edges is not
        EXPECT_LT(worst, (0.03 + uneven) * std::fabs(speed) + 0.01);
      }
    }
  }
}

TEST(SpeedEstimate, WithoutEdgesItFallsAsFastAsTheTimeAllows) {
  Encoder encoder;
  SpeedEstimate estimate;
  for (int i = 0; i < 1000; ++i) {
    encoder.step(60);
    (void)estimate.step(encoder.counts, encoder.edge_us);
  }
  for (int quiet = 1; quiet < 1000; ++quiet)
    ASSERT_LE(estimate.step(encoder.counts, encoder.edge_us), 1.0F / static_cast<float>(quiet) + 1e-6F);
}

TEST(SpeedEstimate, H2_WhateverTheTimerShowsTheSpeedStaysWithinACountOfTheTruth) {
  std::mt19937 random(6);
  Encoder encoder;
  SpeedEstimate estimate;
  estimate.restart(0);
  std::int32_t before = 0;
  double speed = 0;
  for (int i = 0; i < 100000; ++i) {
    speed += 0.5 * (static_cast<double>(random() % 201U) - 100) * 0.01;
    speed = std::clamp(speed, -200.0, 200.0);
    encoder.step(speed);
    const std::uint32_t lie = random() % 3U == 0 ? kEdgeTimeUnknown_us : static_cast<std::uint32_t>(random() >> (random() % 32U));
    const double moved = encoder.counts - before;
    before = encoder.counts;
    const float shown = estimate.step(encoder.counts, lie);
    ASSERT_TRUE(std::isfinite(shown));
    if (moved != 0) {
      ASSERT_LE(std::fabs(shown - moved), 1.0001) << i;
      ASSERT_FALSE(shown * moved < 0) << i;  // never the other way
    } else {
      ASSERT_LE(std::fabs(shown), 1.0) << i;
    }
  }
}

TEST(SpeedEstimate, ACounterThatWrapsIsNoJump) {
  SpeedEstimate estimate;
  estimate.restart(2147483646);
  EXPECT_EQ(estimate.step(-2147483647, kEdgeTimeUnknown_us), 3.0F);
}

TEST(SpeedEstimate, AfterAStandstillTheFirstEdgesAreNoneOfTheOldSpeed) {
  Encoder encoder;
  SpeedEstimate estimate;
  for (int i = 0; i < 500; ++i) {
    encoder.step(1.5);
    (void)estimate.step(encoder.counts, encoder.edge_us);
  }
  for (int i = 0; i < 5000; ++i) {
    encoder.step(0);
    (void)estimate.step(encoder.counts, encoder.edge_us);
  }
  double seen = 0;
  int took_ms = 0;
  for (; took_ms < 50 && seen < 2.2; ++took_ms) {
    encoder.step(2.5);
    seen = kRadPerCount_ms * estimate.step(encoder.counts, encoder.edge_us);
    ASSERT_LT(seen, 3.2);
  }
  EXPECT_LE(took_ms, 5);
}

// The whole loop at 2.5 rad/s of the motor, 0.8 cm/s at the wheel: ripple of the shaft's speed and of the duty.
struct Ripple {
  double speed_rad_s = 0, duty = 0;
};
// cogging_n_m: the iron's pull, 24 times a turn; it is what a servo at a crawl has to smooth.
Ripple creep(bool edges, double uneven, double target_rad_s, double cogging_n_m = 0) {
  sim::MotorConfig config;
  config.inertia_kg_m2 = 1.0e-3;
  sim::Motor motor(config);
  Encoder encoder{uneven};
  SpeedEstimate estimate;
  law::ServoConfig<float> servo;
  servo.k_p_v_s_rad = 0.12F;
  servo.k_i_v_rad = 2.4F;
  servo.current_limit_a = 6;
  law::ServoState<float> state;
  double sum = 0, square = 0, duty_sum = 0, duty_square = 0;
  constexpr int kSettle = 2000, kRun = 6000;
  for (int i = 0; i < kSettle + kRun; ++i) {
    law::ServoInput<float> input;
    input.target_rad_s = static_cast<float>(target_rad_s);
    input.position_counts = encoder.counts;
    input.current_a = static_cast<float>(motor.current_a());
    if (edges) {
      input.speed_measured = true;
      input.speed_rad_s = static_cast<float>(kRadPerCount_ms) * estimate.step(encoder.counts, encoder.edge_us);
    }
    const auto output = law::servo_step(servo, state, input, 0.001F);
    const double before = motor.angle_rad();
    motor.step(static_cast<double>(output.duty_norm) * 24.0, cogging_n_m * std::sin(24 * motor.angle_rad()), 0.001);
    encoder.step((motor.angle_rad() - before) / 0.001);
    if (i < kSettle) continue;
    sum += motor.speed_rad_s();
    square += motor.speed_rad_s() * motor.speed_rad_s();
    duty_sum += static_cast<double>(output.duty_norm);
    duty_square += static_cast<double>(output.duty_norm * output.duty_norm);
  }
  return {std::sqrt(std::max(0.0, square / kRun - sum / kRun * sum / kRun)),
          std::sqrt(std::max(0.0, duty_square / kRun - duty_sum / kRun * duty_sum / kRun))};
}

TEST(SpeedEstimate, TheServoIsSmoothAtTwoToThreeRadiansASecond) {
  for (const double target : {2.0, 2.5, 3.0}) {
    for (const double uneven : {0.0, 0.15}) {
      SCOPED_TRACE(testing::Message() << target << " rad/s, unevenness " << uneven);
      const Ripple before = creep(false, uneven, target), after = creep(true, uneven, target);
      std::printf("creeping at %.1f rad/s, unevenness %.2f: speed ripple %.4f -> %.4f rad/s, duty ripple %.4f -> %.4f\n", target, uneven,
                  before.speed_rad_s, after.speed_rad_s, before.duty, after.duty);
      EXPECT_LT(after.duty, 0.5 * before.duty);
      EXPECT_LE(after.speed_rad_s, before.speed_rad_s + 0.005);
      EXPECT_LT(after.speed_rad_s, 0.05 * target);
    }
  }
}

TEST(SpeedEstimate, WithCoggingTheShaftIsNoLessSteadyAndTheServoWorksLess) {
  for (const double target : {2.0, 2.5, 3.0}) {
    SCOPED_TRACE(target);
    const Ripple before = creep(false, 0.15, target, 0.01), after = creep(true, 0.15, target, 0.01);
    std::printf("creeping at %.1f rad/s over cogging: speed ripple %.4f -> %.4f rad/s, duty ripple %.4f -> %.4f\n", target,
                before.speed_rad_s, after.speed_rad_s, before.duty, after.duty);
    EXPECT_LE(after.speed_rad_s, 1.1 * before.speed_rad_s);
    EXPECT_LE(after.duty, before.duty);
  }
}

TEST(Winding, H11_ItWarmsToWhatTheCurrentMakesOfIt) {
  const WindingConfig config;
  Winding winding;
  winding.start(config);
  EXPECT_EQ(winding.temperature_c(), 90.0F);
  for (int i = 0; i < 600'000; ++i) winding.step_1ms(config, 0);
  EXPECT_NEAR(winding.temperature_c(), 40, 0.5);
  // At the rated current: 40 + 36 A2 x 1.2 ohm x 1.3 K/W, with the copper's own rise 116.4 degrees.
  for (int i = 0; i < 600'000; ++i) winding.step_1ms(config, 6);
  EXPECT_NEAR(winding.temperature_c(), 116.4, 1.0);
  EXPECT_FALSE(winding.too_hot(config));
  EXPECT_LT(winding.current_share(config), 0.6F);  // and is being held there
}

TEST(Winding, H11_TwiceTheRatedCurrentIsFoldedBackWithinSeconds) {
  const WindingConfig config;
  Winding winding;
  winding.start(config);
  int seconds = 0;
  for (; seconds < 60 && winding.current_share(config) == 1.0F; ++seconds)
    for (int i = 0; i < 1000; ++i) winding.step_1ms(config, 12);
  EXPECT_GE(seconds, 3);
  EXPECT_LE(seconds, 6);
}

TEST(Winding, H11_WithTheLimiterObeyingItNeverGetsTooHotWhateverIsAskedOfIt) {
  std::mt19937 random(9);
  for (int run = 0; run < 20; ++run) {
    WindingConfig config;
    config.ambient_c = static_cast<float>(random() % 41U) + 10;
    config.thermal_resistance_k_w = 0.6F + 0.1F * static_cast<float>(random() % 10U);
    config.time_constant_s = 20 + static_cast<float>(random() % 100U);
    Winding winding;
    winding.start(config);
    float asked_a = 12;
    for (int i = 0; i < 300'000; ++i) {
      if (i % 10'000 == 0) asked_a = static_cast<float>(random() % 13U);
      const float limit_a = 12.0F * winding.current_share(config);
      winding.step_1ms(config, asked_a < limit_a ? asked_a : limit_a);
      ASSERT_FALSE(winding.too_hot(config)) << run << " " << i;
    }
  }
}

TEST(Winding, AShareIsAlwaysAShare) {
  for (float t = -300; t < 1200; t += 0.37F) {
    const float share = Winding::fold_share(t, 120);
    ASSERT_GE(share, Winding::kFoldShare);
    ASSERT_LE(share, 1.0F);
    ASSERT_EQ(share == 1.0F, t <= 105.0F) << t;
  }
  WindingConfig odd;
  odd.thermal_resistance_k_w = 1e30F;
  Winding winding;
  winding.start(odd);
  for (int i = 0; i < 1000; ++i) winding.step_1ms(odd, 1e10F);
  EXPECT_EQ(winding.temperature_c(), 1000.0F);
}

}  // namespace
}  // namespace hoist::firmware
