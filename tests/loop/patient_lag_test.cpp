// The slow-down of an exercise (law/patient_lag.hpp) on bodies that are harder than the simulated patient: any mass, legs with their own
// pace, reactions of up to half a second, struts with a wrong zero, steps and noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>

#include "control/contract/params.hpp"
#include "control/core/law/patient_lag.hpp"
#include "control/core/output/limiter.hpp"

namespace hoist::tests {
namespace {

constexpr double kDegree_rad = 0.017453292519943295, kTick_s = 0.01;

struct Body {
  double mass_kg, reaction_s, zero_error_rad, pace_m_s, compensation_norm;
  bool
      follows;  // walks as fast as the hoist was felt to go, up to the pace; otherwise at the pace from the first step on, 0 = the feet stay
};

struct Led {
  double slowest_m_s = 1, fastest_m_s = 0, mean_m_s = 0;  // commanded in the last 20 s
  double farthest_back_rad = 0;
  bool guarded = false;  // a limit of H15 or H16 was passed for its time

  [[nodiscard]] double swing_m_s() const { return fastest_m_s - slowest_m_s; }
};

/// Body on springs of the design between struts of 0.8 m (firmware/sim/plant.hpp); drive and wheels follow with a lag of 0.06 s.
class LedBody {
 public:
  explicit LedBody(const Body& body) : body_(body) {}

  /// One step under this command; the lean as the struts show it, and the true one with its rate.
  void step(double command_m_s) {
    const std::size_t back = (at_ + kMemory - static_cast<std::size_t>(std::lround(body_.reaction_s / kTick_s))) % kMemory;
    const double felt_m_s = hoist_then_[back], felt_n = kSpring_n_m * lean_then_[back];
    set_off_ = set_off_ || felt_m_s > 0.02;
    const double goal_m_s = body_.follows ? std::min(felt_m_s, body_.pace_m_s) : (set_off_ ? body_.pace_m_s : 0.0);
    const double most_n = 70.0 * std::max(1.0, body_.mass_kg / 75.0);
    for (int i = 0; i < 10; ++i) {
      hoist_m_s_ += (command_m_s - hoist_m_s_) * 0.001 / 0.06;
      double spring_n = kSpring_n_m * lean_m_ + 60.0 * (own_m_s_ - hoist_m_s_);
      if (std::fabs(lean_m_) > kStop_m) spring_n += 8000.0 * (lean_m_ - std::copysign(kStop_m, lean_m_));
      const double stay_n = body_.pace_m_s > 0 ? 0.0 : -3000.0 * own_m_;
      const double legs_n =
          std::clamp(stay_n + body_.compensation_norm * felt_n + 3.0 * body_.mass_kg * (goal_m_s - own_m_s_), -most_n, most_n);
      own_m_ += own_m_s_ * 0.001;
      own_m_s_ += (legs_n - spring_n) / body_.mass_kg * 0.001;
      lean_m_ += (own_m_s_ - hoist_m_s_) * 0.001;
    }
    hoist_then_[at_] = hoist_m_s_;
    lean_then_[at_] = lean_m_;
    at_ = (at_ + 1) % kMemory;
    // Each step sways by 1.5 cm, the most of the random patients.
    phase_rad_ += 4.0 * 3.141592653589793 * (0.42 + 0.5 * std::fabs(own_m_s_)) * kTick_s;
    const double sway_m = 0.015 * std::min(1.0, std::fabs(own_m_s_) / 0.15) * std::sin(phase_rad_);
    const double before_rad = shown_rad_;
    shown_rad_ = std::atan((lean_m_ + sway_m) / 0.8) + body_.zero_error_rad + noise_(random_);
    rate_rad_s_ += ((shown_rad_ - before_rad) / kTick_s - rate_rad_s_) * 0.2;
  }
  [[nodiscard]] double lean_rad() const { return shown_rad_; }
  [[nodiscard]] double rate_rad_s() const { return rate_rad_s_; }

 private:
  static constexpr std::size_t kMemory = 64;
  static constexpr double kSpring_n_m = 300.0, kStop_m = 0.214;
  Body body_;
  double lean_m_ = 0, own_m_ = 0, own_m_s_ = 0, hoist_m_s_ = 0, phase_rad_ = 0, shown_rad_ = 0, rate_rad_s_ = 0;
  bool set_off_ = false;
  std::array<double, kMemory> hoist_then_{}, lean_then_{};
  std::size_t at_ = 0;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, 0.1 * kDegree_rad};
};

Led lead(const Body& body, double wish_m_s, double seconds = 45.0) {
  const contract::Params p;
  core::Limiter limiter;
  LedBody patient(body);
  double share_norm = 1, beyond_s = 0, resting_s = 0;
  Led led;
  int counted = 0;
  for (double t_s = 0; t_s < seconds; t_s += kTick_s) {
    share_norm = law::patient_lag_step<double>({p.guided_lag_start_rad}, share_norm, -patient.lean_rad(), -patient.rate_rad_s(), kTick_s);
    limiter.step(p, core::Braking::none, wish_m_s * share_norm, 0.0, false, kTick_s);
    patient.step(limiter.speed_m_s());
    const double lag_rad = -patient.lean_rad();
    led.farthest_back_rad = std::max(led.farthest_back_rad, lag_rad);
    beyond_s = lag_rad > p.hang_tilt_rad ? beyond_s + kTick_s : 0;
    resting_s = lag_rad > p.fall_static_tilt_rad ? resting_s + kTick_s : 0;
    const bool falls = lag_rad > p.fall_tilt_rad && -patient.rate_rad_s() > p.fall_rate_rad_s;
    led.guarded = led.guarded || falls || beyond_s > p.hang_tilt_s || resting_s > p.fall_static_s;
    if (t_s < seconds - 20.0) continue;
    led.slowest_m_s = std::min(led.slowest_m_s, limiter.speed_m_s());
    led.fastest_m_s = std::max(led.fastest_m_s, limiter.speed_m_s());
    led.mean_m_s += limiter.speed_m_s();
    ++counted;
  }
  led.mean_m_s /= counted;
  return led;
}

template <typename Judge>
void with_bodies(double pace_norm, bool follows, const Judge& judge) {
  for (const double wish_m_s : {0.1, 0.2, 0.3, 0.45, 0.6})
    for (const double mass_kg : {30.0, 75.0, 150.0})
      for (const double reaction_s : {0.1, 0.3, 0.5})
        for (const double zero_deg : {-1.0, 0.0, 1.0})
          for (const double compensation_norm : {0.0, 0.8}) {
            SCOPED_TRACE(testing::Message() << wish_m_s << " m/s, " << mass_kg << " kg, " << reaction_s << " s, zero " << zero_deg
                                            << " deg, compensation " << compensation_norm << (follows ? ", follows" : ""));
            judge(wish_m_s,
                  lead({mass_kg, reaction_s, zero_deg * kDegree_rad, pace_norm * wish_m_s, compensation_norm, follows}, wish_m_s));
          }
}

// H15, H16. The rest of the swing is the sway of each step; an unstable loop would swing between standstill and the full speed.
TEST(PatientLag, H15_H16_WhoWalksAtHalfTheSpeedIsLedWithoutAGuardAndWithoutHunting) {
  for (const double pace_norm : {0.5, 0.75})
    for (const bool follows : {false, true})
      with_bodies(pace_norm, follows, [&](double wish_m_s, const Led& led) {
        EXPECT_FALSE(led.guarded) << led.farthest_back_rad / kDegree_rad;
        EXPECT_LT(led.swing_m_s(), 0.6 * wish_m_s);
        EXPECT_GT(led.slowest_m_s, 0.1 * wish_m_s);
        // The springs draw a light body along, too: the hoist may be faster than its legs alone.
        EXPECT_GT(led.mean_m_s, 0.4 * wish_m_s);
      });
}

TEST(PatientLag, WhoWalksAsFastAsTheHoistIsLedAtTheWholeSpeed) {
  with_bodies(1.0, false, [](double wish_m_s, const Led& led) { EXPECT_GT(led.mean_m_s, 0.95 * wish_m_s); });
}

// H16: the hoist stands, up to 0.2 m/s before the struts lean as in a fall. The alarm at the end of the wait: guided_test.cpp.
TEST(PatientLag, H16_WhoDoesNotWalkStopsTheHoist) {
  with_bodies(0.0, false, [](double wish_m_s, const Led& led) {
    EXPECT_LT(led.mean_m_s, 0.02);
    if (wish_m_s < 0.25) {
      EXPECT_LT(led.farthest_back_rad, contract::Params{}.fall_static_tilt_rad);
    }
  });
}

TEST(PatientLag, WhatIsNoNumberSlowsDown) {
  const double none = std::nan("");
  EXPECT_LT(law::patient_lag_step<double>({0.04}, 1.0, none, 0.0, kTick_s), 1.0);
  EXPECT_LT(law::patient_lag_step<double>({0.04}, 1.0, 0.0, none, kTick_s), 1.0);
  EXPECT_EQ(law::patient_lag_step<double>({0.04}, 1.0, 0.03, 0.0, kTick_s), 1.0) << "below the band nothing changes";
}

}  // namespace
}  // namespace hoist::tests
