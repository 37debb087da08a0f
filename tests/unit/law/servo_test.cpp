// The servo loop against the motor, by properties that any discretisation must keep (golden file servo_properties), in the number type of
// the drive and in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "control/core/law/servo_loop.hpp"
#include "firmware/sim/motor.hpp"
#include "tests/unit/law/golden.hpp"

namespace hoist::test {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kSupply_v = 24.0;

struct Sample {
  double time_s;
  double target_rad_s;
  double speed_rad_s;
  double current_a;
  double reference_rad_s;
  double duty;
  std::int32_t counts;
  bool stale;
};

struct Scenario {
  double duration_s{};
  std::function<double(double)> target_rad_s;
  double load_n_m{};
  std::function<bool(double)> locked = [](double) { return false; };
  std::function<double(double)> command_age_s = [](double) { return 0.0; };
};

template <typename Real>
class Servo : public testing::Test {
 public:
  law::ServoConfig<Real> config;

  std::vector<Sample> run(const Scenario& scenario) const {
    EXPECT_EQ(law::refusal(config), nullptr);
    law::ServoState<Real> state;
    sim::Motor motor;
    std::vector<Sample> trace;
    const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
    for (int k = 0; k < ticks; ++k) {
      const double time_s = k * kTick_s;
      motor.lock(scenario.locked(time_s));
      const double target = scenario.target_rad_s(time_s);
      const auto out = law::servo_step(config, state,
                                       {static_cast<Real>(target), static_cast<Real>(scenario.command_age_s(time_s)),
                                        motor.encoder_counts(), static_cast<Real>(motor.current_a()), static_cast<Real>(kSupply_v)},
                                       static_cast<Real>(kTick_s));
      EXPECT_FALSE(out.refused);
      motor.step(static_cast<double>(out.duty_norm) * kSupply_v, scenario.load_n_m, kTick_s);
      trace.push_back({time_s, target, motor.speed_rad_s(), motor.current_a(), static_cast<double>(out.reference_rad_s),
                       static_cast<double>(out.duty_norm), motor.encoder_counts(), out.command_stale});
    }
    return trace;
  }

  // P1
  void expect_reference_ramps(const std::vector<Sample>& trace) const {
    const double largest = static_cast<double>(config.acceleration_max_rad_s2) * kTick_s * (1.0 + 1e-5);
    double before = 0.0;
    for (const auto& sample : trace) {
      ASSERT_LE(std::fabs(sample.reference_rad_s - before), largest) << "at " << sample.time_s;
      before = sample.reference_rad_s;
    }
  }

  // P2
  static void expect_tracks(const std::vector<Sample>& trace) {
    const double target = trace.back().target_rad_s;
    double sum = 0.0;
    int count = 0;
    for (const auto& sample : trace) {
      if (sample.time_s < trace.back().time_s - 0.5) continue;
      sum += sample.speed_rad_s;
      ++count;
    }
    EXPECT_NEAR(sum / count, target, std::max(0.01 * std::fabs(target), 0.5));
  }

  // P3
  void expect_current_bounded(const std::vector<Sample>& trace) const {
    const double limit = static_cast<double>(config.current_limit_a);
    int above = 0;
    for (const auto& sample : trace) {
      const double current = std::fabs(sample.current_a);
      ASSERT_LE(current, 1.5 * limit) << "at " << sample.time_s;
      above = current > 1.05 * limit ? above + 1 : 0;
      ASSERT_LE(above, 50) << "at " << sample.time_s;
    }
  }
};

using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Servo, Reals);

TYPED_TEST(Servo, StepUnderLoad) {
  const auto trace = this->run({2.5, [](double t) { return t >= 0.1 ? 150.0 : 0.0; }, 0.1});
  this->expect_reference_ramps(trace);
  this->expect_tracks(trace);
  this->expect_current_bounded(trace);
}

TYPED_TEST(Servo, LockedRotorWindsNothingUp) {
  const double lock_s = 5.0;
  const auto trace = this->run({8.0, [](double) { return 100.0; }, 0.0, [=](double t) { return t < lock_s; }});
  this->expect_current_bounded(trace);
  // P4
  const double settle_s = 100.0 / static_cast<double>(this->config.acceleration_max_rad_s2) + 0.6;
  bool pressed_at_the_limit = false;
  for (const auto& sample : trace) {
    if (sample.time_s < lock_s) {
      pressed_at_the_limit = pressed_at_the_limit || sample.current_a > 0.95 * static_cast<double>(this->config.current_limit_a);
      continue;
    }
    ASSERT_LE(sample.speed_rad_s, 115.0) << "at " << sample.time_s;
    if (sample.time_s > lock_s + settle_s) {
      ASSERT_NEAR(sample.speed_rad_s, 100.0, 2.0) << "at " << sample.time_s;
    }
  }
  EXPECT_TRUE(pressed_at_the_limit) << "otherwise this test shows nothing";
}

TYPED_TEST(Servo, Reversal) {
  const auto trace = this->run({4.0, [](double t) { return t < 1.5 ? 150.0 : -150.0; }, 0.0});
  this->expect_reference_ramps(trace);
  this->expect_tracks(trace);
  this->expect_current_bounded(trace);
}

TYPED_TEST(Servo, SlowTurnsSteadily) {
  for (const double target : {2.0, 3.0, -2.0}) {
    SCOPED_TRACE(target);
    const auto trace = this->run({4.0, [=](double) { return target; }, std::copysign(0.05, target)});
    // P7: the counter must not stand still for more than 20 ms after the first second.
    int still = 0;
    double sum = 0.0;
    int count = 0;
    for (std::size_t k = 1; k < trace.size(); ++k) {
      if (trace[k].time_s < 1.0) continue;
      still = trace[k].counts == trace[k - 1].counts ? still + 1 : 0;
      ASSERT_LE(still, 20) << "at " << trace[k].time_s;
      sum += trace[k].speed_rad_s;
      ++count;
    }
    EXPECT_NEAR(sum / count, target, 0.05 * std::fabs(target));
  }
}

TYPED_TEST(Servo, StopsAndStaysWithinTwoCounts) {
  const auto trace = this->run({4.5, [](double t) { return t < 1.0 ? 100.0 : 0.0; }, 0.0});
  this->expect_reference_ramps(trace);
  // P6: a second after standstill was due (1.0 s + 0.25 s of ramp) for two seconds.
  const auto first = std::find_if(trace.begin(), trace.end(), [](const Sample& s) { return s.time_s >= 2.25; });
  for (auto sample = first; sample != trace.end() && sample->time_s < 4.25; ++sample) {
    ASSERT_LE(std::abs(sample->counts - first->counts), 2) << "at " << sample->time_s;
  }
}

TYPED_TEST(Servo, MirroredInputsGiveTheMirroredAnswer) {
  // P5, the law alone: exactly.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> target(-200.0, 200.0);
  std::uniform_real_distribution<double> current(-6.0, 6.0);
  std::uniform_int_distribution<std::int32_t> move(-90, 90);
  law::ServoState<TypeParam> left;
  law::ServoState<TypeParam> right;
  std::int32_t position = 0;
  for (int k = 0; k < 20'000; ++k) {
    position += move(random);
    const auto goal = static_cast<TypeParam>(target(random));
    const auto amps = static_cast<TypeParam>(current(random));
    const auto a = law::servo_step(this->config, left, {goal, TypeParam(0), position, amps, TypeParam(24)}, TypeParam(1e-3));
    const auto b = law::servo_step(this->config, right, {-goal, TypeParam(0), -position, -amps, TypeParam(24)}, TypeParam(1e-3));
    ASSERT_EQ(a.duty_norm, -b.duty_norm) << "tick " << k;
    ASSERT_EQ(a.speed_rad_s, -b.speed_rad_s) << "tick " << k;
  }
}

TYPED_TEST(Servo, MirroredDrivesGoTheMirroredWay) {
  // P5 in closed loop: the encoder rounds down, so the two see counts that differ by one; one of them is 3 rad/s at 1 ms.
  const auto ahead = this->run({2.5, [](double t) { return t < 1.5 ? 150.0 : 20.0; }, 0.1});
  const auto back = this->run({2.5, [](double t) { return t < 1.5 ? -150.0 : -20.0; }, -0.1});
  const double one_count_duty = 3.15 * static_cast<double>(this->config.k_p_v_s_rad) / kSupply_v;
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    ASSERT_NEAR(ahead[k].counts, -back[k].counts, 2) << "at " << ahead[k].time_s;
    ASSERT_NEAR(ahead[k].duty, -back[k].duty, one_count_duty) << "at " << ahead[k].time_s;
  }
}

TYPED_TEST(Servo, DoesNotDependOnWhenCommandsArrive) {
  // P8: the same target received often or rarely (but in time) gives the same duty, bit for bit.
  const auto often = this->run({1.0, [](double) { return 80.0; }, 0.05});
  Scenario seldom{1.0, [](double) { return 80.0; }, 0.05};
  seldom.command_age_s = [](double t) { return std::fmod(t, 0.035); };
  const auto trace = this->run(seldom);
  for (std::size_t k = 0; k < trace.size(); ++k) ASSERT_EQ(trace[k].duty, often[k].duty) << "tick " << k;
}

TYPED_TEST(Servo, StopsByItselfWhenCommandsStop) {
  // P9: the last command came at 1 s.
  Scenario scenario{3.0, [](double) { return 100.0; }, 0.05};
  scenario.command_age_s = [](double t) { return t < 1.0 ? 0.0 : t - 1.0; };
  const auto trace = this->run(scenario);
  this->expect_reference_ramps(trace);
  const double timeout_s = static_cast<double>(this->config.command_timeout_s);
  for (const auto& sample : trace) {
    if (sample.time_s < 1.0 + timeout_s - 1e-9) {
      ASSERT_FALSE(sample.stale) << "at " << sample.time_s;
    }
    // Stale at the latest one tick after the time-out, and then down at the full ramp.
    const double since_s = sample.time_s - 1.0 - timeout_s - 2.0 * kTick_s;
    if (since_s > 0.0) {
      ASSERT_TRUE(sample.stale);
      ASSERT_LE(sample.reference_rad_s, std::max(0.0, 100.0 - since_s * static_cast<double>(this->config.acceleration_max_rad_s2)) + 1e-3);
    }
  }
  EXPECT_EQ(trace.back().reference_rad_s, 0.0);
  EXPECT_NEAR(trace.back().speed_rad_s, 0.0, 0.5);
  // An unknown age counts as too old.
  law::ServoState<TypeParam> state;
  const auto unknown =
      law::servo_step(this->config, state, {TypeParam(100), TypeParam(NAN), 0, TypeParam(0), TypeParam(24)}, TypeParam(1e-3));
  EXPECT_TRUE(unknown.command_stale);
  EXPECT_EQ(unknown.reference_rad_s, TypeParam(0));
}

TYPED_TEST(Servo, HoldsItsLimitsOnOtherMotorsAndAnEmptyBattery) {
  // The limiter uses no motor model: half and double the winding, an empty battery (21.6 V) and a weak one.
  for (const double resistance : {0.6, 1.2, 2.4}) {
    for (const double supply_v : {18.0, 21.6, 27.0}) {
      SCOPED_TRACE(std::to_string(resistance) + " ohm, " + std::to_string(supply_v) + " V");
      sim::MotorConfig motor_config;
      motor_config.resistance_ohm = resistance;
      sim::Motor motor(motor_config);
      law::ServoState<TypeParam> state;
      motor.lock(true);
      int above = 0;
      for (int k = 0; k < 3000; ++k) {
        if (k == 1500) motor.lock(false);
        const auto out = law::servo_step(this->config, state,
                                         {TypeParam(100), TypeParam(0), motor.encoder_counts(), static_cast<TypeParam>(motor.current_a()),
                                          static_cast<TypeParam>(supply_v)},
                                         TypeParam(1e-3));
        motor.step(static_cast<double>(out.duty_norm) * supply_v, 0.0, 1e-3);
        ASSERT_LE(std::fabs(motor.current_a()), 6.0) << "tick " << k;
        above = std::fabs(motor.current_a()) > 4.2 ? above + 1 : 0;
        ASSERT_LE(above, 50) << "tick " << k;
      }
      EXPECT_NEAR(motor.speed_rad_s(), 100.0, 2.0);
    }
  }
}

TYPED_TEST(Servo, PositionCounterMayWrap) {
  law::ServoState<TypeParam> state;
  std::int32_t position = std::numeric_limits<std::int32_t>::max() - 100;
  for (int k = 0; k < 200; ++k) {
    const auto out =
        law::servo_step(this->config, state, {TypeParam(0), TypeParam(0), position, TypeParam(0), TypeParam(24)}, TypeParam(1e-3));
    ASSERT_LE(out.speed_rad_s, TypeParam(2.0 * 3.15)) << "tick " << k;
    ASSERT_GE(out.speed_rad_s, TypeParam(0)) << "tick " << k;
    position = static_cast<std::int32_t>(static_cast<std::uint32_t>(position) + 2U);
  }
}

// The scenarios above are the golden file's: its cases and what each must check.
TEST(ServoProperties, EveryGoldenScenarioIsTested) {
  const auto& files = golden_files();
  const auto file = std::find_if(files.begin(), files.end(), [](const auto& f) { return f.function == "servo_properties"; });
  ASSERT_NE(file, files.end());
  std::vector<std::string> scenarios;
  for (const auto& golden : file->cases) scenarios.push_back(golden.at("in").at("scenario"));
  EXPECT_EQ(scenarios, (std::vector<std::string>{"step", "locked then freed", "reversal", "slow", "stop"}));
}

}  // namespace
}  // namespace hoist::test
