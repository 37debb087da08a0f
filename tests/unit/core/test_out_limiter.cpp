// Speed and turn on their way to a wheel: the rules of control/core/output/limiter.hpp, speed_limits.hpp, wheel_room.hpp, wheel_mixing.hpp,
// braking.hpp and sync_pulses.hpp, written a second time from their descriptions. Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "control/core/output/limiter.hpp"
#include "control/core/output/sync_pulses.hpp"
#include "control/core/output/wheel_mixing.hpp"

namespace hoist::core::test::out_limiter {
namespace {

using contract::Params;
using contract::SpeedCause;

double within(double x, double limit) { return std::clamp(x, -limit, limit); }

// H1: 210 rad/s of a motor through gear 30, at the smaller wheel.
double outer_m_s(const Params& p) { return 210.0 / 30.0 * p.wheel_radius_m * std::min(p.wheel_left_scale_norm, p.wheel_right_scale_norm); }

double rate_m_s2(Braking braking, const Params& p) {
  if (braking == Braking::soft) return 0.5;
  if (braking == Braking::remote) return 0.8;
  if (braking == Braking::protective) return p.protective_deceleration_m_s2;
  if (braking == Braking::bumper) return p.bumper_deceleration_m_s2;
  return p.acceleration_m_s2_max;
}

// The largest acceleration from which the speed meets the gap while it falls by a jerk step in each step.
double meets_m_s2(double gap_m_s, double jerk_m_s3, double dt_s) {
  const double units = gap_m_s / (jerk_m_s3 * dt_s * dt_s);
  int falls = 0;
  while ((falls + 1.0) * (falls + 2.0) / 2.0 <= units) ++falls;
  // n + (n - 1) + ... + (n - falls) = units.
  return (units + falls * (falls + 1.0) / 2.0) / (falls + 1.0) * jerk_m_s3 * dt_s;
}

// What a mode asks for, and what bumper and slope have left of it.
struct Asked {
  double m_s = 0, left_m_s = 0, yaw_rad_s = 0;
};

struct Rule {
  double v = 0, a = 0, w = 0;
  SpeedCause cause = SpeedCause::none;
  bool stops = false, gentle = false, exact = false;

  void stop(const Params& p, Braking braking, double dt) {
    const double v0 = v, w0 = w;
    v = std::copysign(std::max(0.0, std::fabs(v) - rate_m_s2(braking, p) * dt), v0);
    a = (v - v0) / dt;
    // It stays on its curve, as far as the turn can slow down.
    const double curve = v0 == 0 ? 0 : w0 * (v / v0);
    w = w0 + within(curve - w0, p.yaw_acceleration_rad_s2_max * dt);
    cause = SpeedCause::none;
    stops = true;
    exact = v == 0;
  }

  void go(const Params& p, Asked asked, double dt) {
    if (stops) {
      a = 0;
      gentle = false;
    }
    stops = false;
    cause = asked.left_m_s != asked.m_s ? SpeedCause::slope : SpeedCause::none;
    if (!std::isfinite(asked.left_m_s)) {
      asked.m_s = asked.left_m_s = 0;
      cause = SpeedCause::none;
    }
    const double wish = within(asked.left_m_s, p.speed_m_s_max * p.speed_cap_norm);
    if (wish != asked.left_m_s) cause = SpeedCause::cap;
    const double turn = std::isfinite(asked.yaw_rad_s) ? within(asked.yaw_rad_s, p.yaw_rate_rad_s_max) : 0;
    // The turn has what it asks for of the outer wheel, half of it at most. Until it has, the speed uses what the turn leaves now.
    const double outer = outer_m_s(p), half_m = p.track_width_m / 2;
    const double share = std::min(std::fabs(wish), std::max(outer - std::fabs(turn) * half_m, outer / 2));
    const double target = within(wish, std::min(share, std::max(0.0, outer - std::fabs(w) * half_m)));
    if (target != wish) cause = SpeedCause::turn;
    if (!(std::fabs(asked.m_s - target) > 0.02)) cause = SpeedCause::none;
    // A wished change uses the full bound; what a turn takes and returns comes at 0.3 m/s2.
    const bool slower = v > 0 ? wish < v : v < 0 && wish > v;
    if (target != wish && std::fabs(v) >= std::fabs(target) - 1e-9) gentle = true;
    if (target == wish && slower) gentle = false;
    double most = p.acceleration_m_s2_max;
    if (gentle) most = std::min(most, std::max(0.3, slower ? meets_m_s2(std::fabs(wish - v), p.jerk_m_s3_max, dt) : 0.0));
    const double wanted = std::copysign(std::min(most, meets_m_s2(std::fabs(target - v), p.jerk_m_s3_max, dt)), target - v);
    a += within(wanted - a, p.jerk_m_s3_max * dt);
    v += a * dt;
    exact = std::fabs(v - target) < 1e-9;
    if (exact) v = target;
    if (v == wish) gentle = false;
    // The turn grows into what the speed leaves.
    const double turn_target = within(turn, std::min((outer - share) / half_m, std::max(0.0, outer - std::fabs(v)) / half_m));
    w += within(turn_target - w, p.yaw_acceleration_rad_s2_max * dt);
  }
};

Params any_params(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double least, double most) { return least + (most - least) * unit(random); };
  Params p;
  if (random() % 3 == 0) return p;
  p.speed_m_s_max = between(0.3, 0.65);
  p.speed_cap_norm = random() % 2 == 0 ? 1.0 : between(0.2, 1.0);
  p.acceleration_m_s2_max = between(0.2, 0.5);
  p.jerk_m_s3_max = between(0.5, 10.0);
  p.yaw_rate_rad_s_max = between(0.2, 0.87);
  p.yaw_acceleration_rad_s2_max = between(0.1, 2.09);
  p.protective_deceleration_m_s2 = between(0.8, 1.0);
  p.bumper_deceleration_m_s2 = between(0.8, 1.5);
  p.track_width_m = between(0.3, 1.2);
  p.wheel_radius_m = between(0.04, 0.13);
  p.wheel_left_scale_norm = between(0.9, 1.1);
  p.wheel_right_scale_norm = between(0.9, 1.1);
  return p;
}

TEST(OutLimiter, H1H15EachStepFollowsTheWishAsItsBoundsSay) {
  int gentle = 0, stops = 0, exact = 0, held = 0;
  std::array<int, 8> causes{};
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    const Params p = any_params(random);
    const double dt = seed % 4 == 0 ? 0.02 : 0.01;
    Limiter limiter;
    Rule rule;
    Braking braking = Braking::none;
    double speed = 0, yaw = 0, drift = 0, limit = 9;
    int dip = 0;
    bool blind = false;
    for (int i = 0, left = 0; i < 500; ++i) {
      if (left-- == 0) {
        left = one_of(std::array{0, 1, 5, 20, 60, 150});
        const auto what = random() % 16;
        braking = Braking::none;
        drift = 0;
        if (what < 5) speed = 1.6 * unit(random) - 0.8;
        if (what == 5) speed = one_of(std::array<double, 4>{NAN, HUGE_VAL, -HUGE_VAL, 0});
        if (what > 2 && what < 10) yaw = one_of(std::array{0.0, 0.1, 0.5, 0.8, -0.4, -0.87, 3.0});
        if (what == 10) yaw = one_of(std::array<double, 3>{NAN, HUGE_VAL, -HUGE_VAL});
        if (what == 11) drift = 0.6 * unit(random) - 0.3;
        if (what == 12) speed = rule.v + one_of(std::array{0.015, -0.015, 0.03, -0.03, 1e-6, 2e-5});
        if (what > 12) braking = one_of(std::array{Braking::soft, Braking::remote, Braking::protective, Braking::bumper});
        limit = random() % 4 == 0 ? 0.5 * unit(random) : 9;
        if (!std::isfinite(speed) && left > 5) left = 5;
        if (random() % 12 == 0) {
          const std::array<double, 6> from{0.3, -0.5, 5, -5, NAN, HUGE_VAL};
          const double v = one_of(from), w = one_of(from);
          limiter.start_from(p, v, w);
          rule = {};
          if (std::isfinite(v)) rule.v = within(v, p.speed_m_s_max);
          if (std::isfinite(w)) rule.w = within(w, p.yaw_rate_rad_s_max);
        } else if (random() % 20 == 0) {
          limiter.reset();
          rule = {};
        }
      }
      speed += drift * dt;
      Asked asked{speed, speed, yaw};
      // Beside the speed that the next step reaches at the most jerk, nearer and farther than what counts as the same.
      if (random() % 30 == 0) {
        asked.m_s = asked.left_m_s = rule.v + (rule.a - p.jerk_m_s3_max * dt) * dt + one_of(std::array{0.0, -0.7e-9, -1.5e-9, -3e-9});
        if (random() % 2 == 0) {
          speed = asked.m_s;
          drift = left = 0;
        }
      }
      // Less for a moment, while a turn takes or returns speed.
      if (dip == 0 && rule.gentle && random() % 20 == 0) dip = 3;
      if (dip > 0) {
        asked.m_s = asked.left_m_s = 0.7 * rule.v;
        --dip;
      }
      LimitedSpeed limited{asked.m_s};
      if (limit < 9) {
        limited.within(limit, SpeedCause::slope);
        asked.left_m_s = std::isnan(asked.m_s) ? asked.m_s : within(asked.m_s, limit);
      }
      if (random() % 25 == 0) blind = random() % 4 == 0;
      limiter.step(p, braking, limited, asked.yaw_rad_s, blind, dt);
      const double before_v = rule.v, before_w = rule.w;
      if (braking != Braking::none) {
        rule.stop(p, braking, dt);
      } else {
        rule.go(p, asked, dt);
        // Who sees nothing leads nowhere: what has risen, or changed its side, did not.
        if (blind && (std::fabs(rule.v) > std::fabs(before_v) || rule.v * before_v < 0)) {
          rule.v = rule.v * before_v < 0 ? 0 : before_v;
          rule.a = 0;
          ++held;
        }
        if (blind) rule.w = rule.w * before_w < 0 ? 0 : std::clamp(rule.w, -std::fabs(before_w), std::fabs(before_w));
      }
      ASSERT_NEAR(limiter.speed_m_s(), rule.v, 1e-12) << i;
      if (rule.exact) {
        ASSERT_EQ(limiter.speed_m_s(), rule.v) << i << ": exactly";
      }
      ASSERT_NEAR(limiter.acceleration_m_s2(), rule.a, 1e-9) << i;
      ASSERT_NEAR(limiter.yaw_rate_rad_s(), rule.w, 1e-12) << i;
      ASSERT_EQ(limiter.cause(), rule.cause) << i;
      ASSERT_EQ(limiter.at_rest(), limiter.speed_m_s() == 0 && limiter.yaw_rate_rad_s() == 0) << i;
      // So that roundings do not add up.
      rule.v = limiter.speed_m_s();
      rule.a = limiter.acceleration_m_s2();
      rule.w = limiter.yaw_rate_rad_s();
      gentle += rule.gentle ? 1 : 0;
      stops += rule.stops ? 1 : 0;
      exact += rule.exact ? 1 : 0;
      ++causes[static_cast<std::size_t>(rule.cause)];
    }
  }
  EXPECT_GT(gentle, 3000);
  EXPECT_GT(stops, 10'000);
  EXPECT_GT(exact, 10'000);
  EXPECT_GT(held, 3000);
  for (const SpeedCause cause : {SpeedCause::none, SpeedCause::cap, SpeedCause::turn, SpeedCause::slope})
    EXPECT_GT(causes[static_cast<std::size_t>(cause)], 1000) << static_cast<int>(cause);
}

// The last limit that takes anything off is the one in force; less than 0.02 m/s in all is not told.
TEST(OutLimiter, ASpeedCarriesTheLimitThatReducedIt) {
  std::mt19937 random(11);
  const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
  constexpr std::array kCauses{SpeedCause::cap, SpeedCause::turn, SpeedCause::slope, SpeedCause::bumper};
  constexpr std::array kLimits_m_s{0.0, 0.1, 0.285, 0.27, 0.3, 0.5, 0.6, 0.7};
  int told = 0;
  for (int i = 0; i < 5000; ++i) {
    const double asked = one_of(std::array{0.3, -0.3, 0.6, -0.6, 0.0});
    LimitedSpeed speed{asked};
    double left = asked;
    SpeedCause cause = SpeedCause::none;
    for (int k = 0; k < 3; ++k) {
      const SpeedCause of = one_of(kCauses);
      const double before = left;
      const auto what = random() % 3;
      if (what == 0) {
        const double share = one_of(std::array{0.0, 0.5, 0.95, 0.9, 1.0});
        left *= share;
        speed.share(share, of);
      } else if (what == 1) {
        const double limit = one_of(kLimits_m_s);
        left = within(left, limit);
        speed.within(limit, of);
      } else {
        const double backward = one_of(kLimits_m_s), forward = one_of(kLimits_m_s);
        left = std::clamp(left, -backward, forward);
        speed.within(backward, forward, of);
      }
      if (left != before) cause = of;
      const bool tells = std::fabs(asked - left) > 0.02;
      ASSERT_EQ(speed.m_s(), left);
      ASSERT_EQ(speed.cause(), tells ? cause : SpeedCause::none) << asked << " " << left;
      told += tells ? 1 : 0;
    }
  }
  EXPECT_GT(told, 2000);
}

TEST(OutLimiter, H1SpeedAndTurnTogetherTakeNoMoreThanTheOuterWheelHas) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> wide(-2.0, 2.0);
  for (int i = 0; i < 2000; ++i) {
    const Params p = any_params(random);
    const WheelRoom room{p};
    const double outer = outer_m_s(p), half_m = p.track_width_m / 2, v = wide(random), w = wide(random);
    const double speed_left = std::max(0.0, outer - std::fabs(w) * half_m), yaw_left = std::max(0.0, outer - std::fabs(v)) / half_m;
    ASSERT_NEAR(room.speed_left_m_s(w), speed_left, 1e-12);
    ASSERT_NEAR(room.yaw_left_rad_s(v), yaw_left, 1e-12);
    // A turn that needs no more than half of the wheels has all of it.
    const double speed_share = std::min(std::fabs(v), std::max(speed_left, outer / 2));
    ASSERT_NEAR(room.speed_share_m_s(v, w), speed_share, 1e-12);
    ASSERT_NEAR(room.yaw_share_rad_s(v, w), std::min(std::fabs(w), (outer - speed_share) / half_m), 1e-12);
    // On a curve the hoist turns by curvature times speed.
    const double fastest = room.curve_speed_m_s(w);
    ASSERT_NEAR(fastest + std::fabs(w) * fastest * half_m, outer, 1e-12);
  }
}

TEST(OutLimiter, BothWheelsAreToldTheirSpeedInStepsOfTheDriveAndSlowDownAlike) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> wide(-1.5, 1.5);
  int limited = 0;
  for (int i = 0; i < 3000; ++i) {
    const Params p = any_params(random);
    const Derived derived = derive(p);
    const double v = wide(random), w = i % 3 == 0 ? 0.0 : 2 * wide(random);
    // rad/s of the motor, one step is 0.001 of it; 400 at most.
    double left = 30 * (v - w * p.track_width_m / 2) / (p.wheel_radius_m * p.wheel_left_scale_norm);
    double right = 30 * (v + w * p.track_width_m / 2) / (p.wheel_radius_m * p.wheel_right_scale_norm);
    const double most = std::max(std::fabs(left), std::fabs(right));
    if (most > 400) {
      left *= 400 / most;
      right *= 400 / most;
      ++limited;
    }
    const WheelCommand told = mix_wheels(v, w, derived);
    ASSERT_LE(std::fabs(told.left_raw - left * 1000), 0.5 + 1e-6);
    ASSERT_LE(std::fabs(told.right_raw - right * 1000), 0.5 + 1e-6);
    ASSERT_NEAR(wheel_m_s(told.left_raw, derived.left_motor_per_m), left / 30 * p.wheel_radius_m * p.wheel_left_scale_norm, 1e-5);
  }
  EXPECT_GT(limited, 300);
  constexpr std::array kNoNumbers{static_cast<double>(NAN), static_cast<double>(HUGE_VAL), -static_cast<double>(HUGE_VAL)};
  for (const double no_number : kNoNumbers) {
    for (const auto& [v, w] : {std::pair{no_number, 0.2}, std::pair{0.2, no_number}, std::pair{no_number, no_number}}) {
      const WheelCommand told = mix_wheels(v, w, derive(Params{}));
      EXPECT_EQ(told.left_raw, 0);
      EXPECT_EQ(told.right_raw, 0);
    }
  }
}

TEST(OutLimiter, EachStopHasItsDeceleration) {
  std::mt19937 random(7);
  for (int i = 0; i < 50; ++i) {
    const Params p = any_params(random);
    for (const Braking braking : {Braking::none, Braking::soft, Braking::remote, Braking::protective, Braking::bumper})
      ASSERT_EQ(deceleration_m_s2(braking, p), rate_m_s2(braking, p)) << static_cast<int>(braking);
  }
}

// A pulse on each second, a group of 16: a long one, then the group's number, lowest digit first.
TEST(OutSyncPulses, TheLineSpellsTheNumberOfItsGroup) {
  for (const std::uint64_t group : {0U, 1U, 2U, 3U, 100U, 0x2AAAU, 0x5555U, 0x7FFFU, 0x8000U, 0x12345U}) {
    for (std::uint64_t place = 0; place < 16; ++place) {
      const std::uint64_t digit = place == 0 ? 0 : (group / (std::uint64_t{1} << (place - 1))) % 2;
      const std::uint64_t length_ms = place == 0 ? 800 : digit == 1 ? 500 : 200;
      for (std::uint64_t ms = 0; ms < 1000; ms += 10)
        ASSERT_EQ(sync_pulse(((group * 16 + place) * 1000 + ms) / 10), ms < length_ms) << group << " " << place << " " << ms;
    }
  }
}

}  // namespace
}  // namespace hoist::core::test::out_limiter
