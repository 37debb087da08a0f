// Properties of the laws with seeded random inputs, and findings about the paper's algorithms (the numbers in
// control/core/law/DECISIONS.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "control/core/law/differential_drive.hpp"
#include "control/core/law/kalman_gain.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/pelvis.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/core/law/tilt_kalman.hpp"

namespace hoist::test {
namespace {

constexpr double kDt_s = 0.01;
constexpr double kDegree_rad = std::numbers::pi / 180.0;

/// A random wish: steps and noise, all of [-1, 1].
class Wish {
 public:
  explicit Wish(unsigned seed) : random_(seed) {}
  double next() {
    if (change_(random_) < 0.01) level_ = any_(random_);
    return std::clamp(level_ + 0.1 * any_(random_), -1.0, 1.0);
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> any_{-1.0, 1.0};
  std::uniform_real_distribution<double> change_{0.0, 1.0};
  double level_{};
};

/// Steps of 10 ms until the speed is zero or has changed sign, at most `limit`.
int steps_to_zero(const law::PfpConfig<double>& config, double u_norm, int limit = 10'000) {
  law::PfpState<double> state{40.0, 40.0};
  for (int k = 1; k <= limit; ++k) {
    law::pfp_step(config, state, u_norm, kDt_s);
    if (state.v_units <= 0.0) return k;
  }
  return limit;
}

template <typename Real>
class Controllers : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Controllers, Reals);

TYPED_TEST(Controllers, OutputsAreBoundedAndOdd) {
  using Real = TypeParam;
  for (unsigned seed = 0; seed < 20; ++seed) {
    Wish wish(seed);
    law::PfpConfig<Real> config;
    config.v_f_max_units = Real(seed % 2 == 0 ? 50 : 15);
    law::PfpTurnConfig<Real> turn_config;
    turn_config.deadband = seed % 3 == 0 ? law::TurnDeadband::kLiteral : law::TurnDeadband::kDiscardInput;
    law::PfpState<Real> ahead;
    law::PfpState<Real> back;
    law::PfpTurnState<Real> left;
    law::PfpTurnState<Real> right;
    for (int k = 0; k < 20'000; ++k) {
      const Real u = static_cast<Real>(wish.next());
      const auto a = law::pfp_step(config, ahead, u, Real(kDt_s));
      const auto b = law::pfp_step(config, back, -u, Real(kDt_s));
      ASSERT_EQ(a, b);
      ASSERT_EQ(ahead.v_units, -back.v_units);
      ASSERT_LE(std::fabs(ahead.v_f_units), config.v_f_max_units);
      ASSERT_LE(std::fabs(ahead.v_units), config.v_f_max_units + config.k_p);
      law::pfp_turn_step(turn_config, left, u, Real(kDt_s));
      law::pfp_turn_step(turn_config, right, -u, Real(kDt_s));
      ASSERT_EQ(left.omega_units, -right.omega_units);
      ASSERT_LE(std::fabs(left.omega_units), Real(52.001));
    }
  }
}

TYPED_TEST(Controllers, UprightSpeedOnlyEverFalls) {
  using Real = TypeParam;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> inside(-0.0499, 0.0499);
  law::PfpConfig<Real> config;
  law::PfpTurnConfig<Real> turn_config;
  law::PfpState<Real> state{Real(30), Real(29)};
  law::PfpTurnState<Real> turn{Real(-30), Real(-29)};
  Real before = state.v_units;
  Real turn_before = turn.omega_units;
  for (int k = 0; k < 1000; ++k) {
    const Real u = static_cast<Real>(inside(random));
    ASSERT_EQ(law::pfp_step(config, state, u, Real(kDt_s)), law::PfpBranch::kDeadband);
    ASSERT_EQ(law::pfp_turn_step(turn_config, turn, u, Real(kDt_s)), law::PfpTurnBranch::kDeadband);
    ASSERT_LT(state.v_units, before);
    ASSERT_GT(state.v_units, Real(0));
    ASSERT_GE(turn.omega_units, turn_before);
    ASSERT_LE(turn.omega_units, Real(0));
    before = state.v_units;
    turn_before = turn.omega_units;
  }
  // 10 s at tau 2 s.
  EXPECT_NEAR(state.v_units, 29.0 * std::exp(-5.0), 1e-3);
}

TYPED_TEST(Controllers, BrakingNeverSpeedsUpAndLeaningHarderNeverBrakesLess) {
  using Real = TypeParam;
  law::PfpConfig<Real> config;
  for (const double lean : {-0.06, -0.1, -0.3, -1.0}) {
    law::PfpState<Real> state{Real(40), Real(40)};
    law::PfpState<Real> harder{Real(40), Real(40)};
    for (int k = 0; k < 200 && state.v_units > Real(0) && harder.v_units > Real(0); ++k) {
      const Real before = state.v_units;
      ASSERT_EQ(law::pfp_step(config, state, Real(lean), Real(kDt_s)), law::PfpBranch::kReversal);
      law::pfp_step(config, harder, std::max(Real(lean) * Real(1.2), Real(-1)), Real(kDt_s));
      ASSERT_LT(state.v_units, before);
      ASSERT_LE(harder.v_units, state.v_units);
    }
  }
}

// D9: a neutral patient creeps in the literal reading and stands still in the product's.
TEST(TurnDeadband, ProductStandsStillWhereTheLiteralReadingCreeps) {
  law::PfpTurnConfig<double> product;
  law::PfpTurnConfig<double> literal;
  literal.deadband = law::TurnDeadband::kLiteral;
  law::PfpTurnState<double> a;
  law::PfpTurnState<double> b;
  for (int k = 0; k < 1000; ++k) {
    law::pfp_turn_step(product, a, 0.049, kDt_s);
    law::pfp_turn_step(literal, b, 0.049, kDt_s);
  }
  EXPECT_EQ(a.omega_units, 0.0);
  EXPECT_NEAR(b.omega_units, 0.098, 1e-12);
}

// D7: exactly on the edge the braking factor is 1 and nothing is divided by zero.
TEST(Findings, EdgeOfTheDeadband) {
  const law::PfpConfig<double> config;
  law::PfpState<double> state{3.0, 3.2};
  EXPECT_EQ(law::pfp_step(config, state, -0.05, kDt_s), law::PfpBranch::kReversal);
  EXPECT_NEAR(state.v_f_units, 3.2 - 1e-4 * 2.5, 1e-15);
  EXPECT_TRUE(std::isinf(law::tau_brake_s(0.05, 0.05, 2.0, kDt_s)));
  EXPECT_TRUE(std::isnan(law::tau_brake_s(0.02, 0.05, 2.0, kDt_s)));
}

// D12: the direct part alone carries the speed through zero; the paper's sentence about K_2r holds for K_P = 0 only.
TEST(Findings, ReversalGainIsNotNeededWithADirectPart) {
  law::PfpConfig<double> config;
  EXPECT_EQ(steps_to_zero(config, -0.5), 17);
  config.k_2r = 0.0;
  EXPECT_EQ(steps_to_zero(config, -0.5), 17);
  config.k_p = 0.0;
  EXPECT_EQ(steps_to_zero(config, -0.5, 1000), 1000) << "never";
  config.k_2r = 1e-4;
  EXPECT_LT(steps_to_zero(config, -0.5, 1000), 100);
  EXPECT_NEAR(1e-4 / (1.0 - std::exp(-kDt_s / 10.0)), 0.100, 0.001);
}

// D13: the braking factor is per step, so the step must stay 10 ms.
TEST(Findings, BrakingFactorIsPerStep) {
  const law::PfpConfig<double> config;
  law::PfpState<double> slow{40.0, 40.0};
  law::PfpState<double> fast{40.0, 40.0};
  law::pfp_step(config, slow, -0.5, 0.01);
  law::pfp_step(config, fast, -0.5, 0.001);
  EXPECT_EQ(slow.v_f_units, fast.v_f_units);
  EXPECT_NEAR(law::tau_brake_s(-0.5, 0.05, 2.0, 0.01), 10.0 * law::tau_brake_s(-0.5, 0.05, 2.0, 0.001), 1e-15);
}

// D14: just outside the dead-band braking is weaker than letting go; the option mends it.
TEST(Findings, WeakBrakeTrapAndItsOption) {
  law::PfpConfig<double> config;
  EXPECT_NEAR(steps_to_zero(config, -0.06) * kDt_s, 10.8, 0.05);
  law::PfpState<double> coasting{40.0, 40.0};
  int coast = 0;
  while (coasting.v_units > 4.0) {
    law::pfp_step(config, coasting, 0.0, kDt_s);
    ++coast;
  }
  EXPECT_NEAR(coast * kDt_s, 4.6, 0.05);
  // Where braking meets releasing: |u| - D = dT L_dec / tau_dec.
  for (const auto& [l_dec, beyond] : {std::pair{2.0, 0.01}, {10.0, 0.05}, {50.0, 0.25}}) {
    EXPECT_NEAR(law::tau_brake_s(0.05 + beyond, 0.05, l_dec, kDt_s), config.tau_dec_s, 1e-9);
  }
  config.brake_at_least_as_released = true;
  for (const double l_dec : {2.0, 10.0, 50.0}) {
    config.l_dec = l_dec;
    for (double u = -0.051; u > -0.4; u -= 0.01) {
      law::PfpState<double> braking{40.0, 40.0};
      law::PfpState<double> released{40.0, 40.0};
      law::pfp_step(config, braking, u, kDt_s);
      law::pfp_step(config, released, 0.0, kDt_s);
      ASSERT_LE(braking.v_units, released.v_units) << l_dec << " " << u;
    }
  }
}

// D15: how hard it brakes, before any ramp.
TEST(Findings, HardBrake) {
  const law::PfpConfig<double> config;
  EXPECT_EQ(steps_to_zero(config, -0.3), 34);
  EXPECT_EQ(steps_to_zero(config, -1.0), 7);
}

// D16: outside the dead-band the wish is used in full, so it jumps by K_P D at the edge.
TEST(Findings, JumpAtTheEdge) {
  const law::PfpConfig<double> config;
  law::PfpState<double> inside{1.0, 1.0};
  law::PfpState<double> outside{1.0, 1.0};
  law::pfp_step(config, inside, std::nextafter(0.05, 0.0), kDt_s);
  law::pfp_step(config, outside, 0.05, kDt_s);
  EXPECT_NEAR(outside.v_units - inside.v_units, 0.1, 0.01);
}

// D20: the values (13) do not give the gain (14); a neighbouring problem does.
TEST(Findings, PrintedGainIsNotTheSolutionOfThePrintedProblem) {
  const law::TiltGain<double> printed;
  const auto solved = law::solve_kalman_gain(law::KalmanGainProblem<double>{});
  ASSERT_TRUE(solved.converged);
  EXPECT_NEAR(solved.k_angle, 0.028434446456701, 1e-12);
  EXPECT_NEAR(solved.k_bias, -0.034849059412413, 1e-12);
  EXPECT_GT(solved.k_angle / printed.k_angle, 2.7);
  EXPECT_GT(solved.k_bias / printed.k_bias, 26.0);
  // For any bias variance: with V_angle = 0.1 and N = 800 the angle's gain cannot be as small as printed.
  for (const double v_bias : {1e-6, 1e-4, 1e-2, 1.0, 100.0}) {
    law::KalmanGainProblem<double> problem;
    problem.v_bias = v_bias;
    const auto other = law::solve_kalman_gain(problem);
    ASSERT_TRUE(other.converged) << v_bias;
    EXPECT_GT(other.k_angle, 0.0111) << v_bias;
  }
  const auto near = law::solve_kalman_gain(law::KalmanGainProblem<double>{0.0632, 0.00137, 800.0, 0.01, 1.0, 1.0});
  EXPECT_NEAR(near.k_angle, printed.k_angle, 5e-5);
  EXPECT_NEAR(near.k_bias, printed.k_bias, 5e-6);
}

TEST(KalmanGain, DoesNotDependOnItsStartAndSaysWhenItFailed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> exponent(-3.0, 3.0);
  for (int i = 0; i < 50; ++i) {
    law::KalmanGainProblem<double> problem{
        std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)), std::pow(10.0, exponent(random)), 0.01, 1.0, 1.0};
    const auto a = law::solve_kalman_gain(problem);
    problem.p0_angle = std::pow(10.0, exponent(random));
    problem.p0_bias = std::pow(10.0, exponent(random));
    const auto b = law::solve_kalman_gain(problem);
    ASSERT_TRUE(a.converged && b.converged);
    ASSERT_NEAR(a.k_angle, b.k_angle, 1e-9 * a.k_angle);
    ASSERT_NEAR(a.k_bias, b.k_bias, 1e-8 * std::fabs(a.k_bias));
    // Stable error dynamics: characteristic z^2 - (2 - K1 + dt K2) z + (1 - K1) inside the unit circle.
    const double trace = 2.0 - a.k_angle + 0.01 * a.k_bias;
    const double product = 1.0 - a.k_angle;
    ASSERT_LT(std::fabs(product), 1.0);
    ASSERT_LT(std::fabs(trace), 1.0 + product);
  }
  for (const auto& bad : {law::KalmanGainProblem<double>{0.1, 0.0, 800.0, 0.01, 1.0, 1.0},
                          {0.1, 1.0, 0.0, 0.01, 1.0, 1.0},
                          {0.1, 1.0, 800.0, 0.0, 1.0, 1.0},
                          {-0.1, 1.0, 800.0, 0.01, 1.0, 1.0},
                          {NAN, 1.0, 800.0, 0.01, 1.0, 1.0}}) {
    EXPECT_FALSE(law::solve_kalman_gain(bad).converged);
  }
}

TEST(TiltFilter, LearnsABiasAndForgetsAWrongStart) {
  for (const auto& [gain, learns_s] : {std::pair{law::TiltGain<double>{}, 40.0}, {law::TiltGain<double>{0.0284344, -0.0348491}, 8.0}}) {
    auto state = law::tilt_start(10.0 * kDegree_rad, 0.0, kDegree_rad);
    for (int k = 0; k * kDt_s < learns_s; ++k) ASSERT_TRUE(law::tilt_step(gain, state, kDegree_rad, 0.0, kDt_s));
    EXPECT_NEAR(state.angle_rad, 0.0, 0.05 * kDegree_rad);
    EXPECT_NEAR(state.bias_rad_s, kDegree_rad, 0.05 * kDegree_rad);
  }
}

// D20: how long the printed gain needs to learn a bias of 1 deg/s, which is why the bias is measured at standstill first.
TEST(Findings, PrintedGainLearnsABiasSlowly) {
  auto state = law::tilt_start(0.0, 0.0, kDegree_rad);
  double worst_rad = 0.0;
  double last_beyond_s = 0.0;
  for (int k = 1; k <= 4000; ++k) {
    ASSERT_TRUE(law::tilt_step(law::TiltGain<double>{}, state, kDegree_rad, 0.0, kDt_s));
    worst_rad = std::max(worst_rad, std::fabs(state.angle_rad));
    if (std::fabs(state.angle_rad) > 0.1 * kDegree_rad) last_beyond_s = k * kDt_s;
  }
  EXPECT_NEAR(worst_rad / kDegree_rad, 0.79, 0.01);
  EXPECT_NEAR(last_beyond_s, 17.5, 0.3);
}

TEST(AccAngles, AreTheTiltInBothAxes) {
  for (double alpha = -15.0; alpha <= 15.0; alpha += 2.5) {
    for (double beta = -15.0; beta <= 15.0; beta += 2.5) {
      // The sensor is tilted forward by alpha about +y, then right by beta about +x; gravity's reaction seen from inside.
      const double a = alpha * kDegree_rad;
      const double b = beta * kDegree_rad;
      const auto angles = law::acc_angles(-std::sin(a) * 9.81, std::cos(a) * std::sin(b) * 9.81, std::cos(a) * std::cos(b) * 9.81);
      ASSERT_TRUE(angles.valid);
      ASSERT_NEAR(angles.beta_rad, b, 1e-12);
      // Combined tilt costs at most half a degree in one axis (D21).
      ASSERT_NEAR(angles.alpha_rad, a, 0.55 * kDegree_rad);
      if (beta == 0.0) {
        ASSERT_NEAR(angles.alpha_rad, a, 1e-12);
      }
    }
  }
}

TEST(Pelvis, SignsAndRangesFit) {
  const law::PelvisGeometry<double> geometry;
  const double stop = 15.0 * kDegree_rad;
  const auto range = law::full_range(geometry, stop);
  const auto forward = law::pelvis_exact<double>({stop, stop, 0.0, 0.0}, geometry);
  EXPECT_NEAR(law::normalise(forward, range, {}).u_norm, 1.0, 1e-12);
  EXPECT_EQ(forward.dpsi_rad, 0.0);
  const auto left_turn = law::pelvis_exact<double>({-stop, stop, 0.0, 0.0}, geometry);
  EXPECT_NEAR(law::normalise(left_turn, range, {}).u_psi_norm, 1.0, 1e-12);
  EXPECT_LT(law::pelvis_exact<double>({0.0, 0.0, stop, stop}, geometry).dy_m, 0.0) << "leaning right moves the harness right";
  // D2: the printed (3) is half the pelvis angle for small angles; the geometric value is the true one.
  const auto small = law::pelvis_exact<double>({-0.01, 0.01, 0.0, 0.0}, geometry);
  EXPECT_NEAR(law::geometric_yaw_rad<double>({-0.01, 0.01, 0.0, 0.0}, geometry), 2.0 * small.dpsi_rad, 1e-5);
  // Lean and turn share the same tilt: |u| + |u_psi| stays about within 1 for struts within the stop.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> tilt(-stop, stop);
  for (int i = 0; i < 10'000; ++i) {
    const auto pelvis = law::pelvis_exact<double>({tilt(random), tilt(random), 0.0, 0.0}, geometry);
    const auto intent = law::normalise(pelvis, range, {});
    ASSERT_TRUE(intent.valid);
    ASSERT_LE(std::fabs(intent.u_norm) + std::fabs(intent.u_psi_norm), 1.02);
    // The yaw's formula is odd and the small-angle form close.
    const auto mirrored = law::pelvis_exact<double>({-0.1, 0.05, 0.02, 0.03}, geometry);
    const auto swapped = law::pelvis_exact<double>({0.05, -0.1, 0.02, 0.03}, geometry);
    ASSERT_EQ(mirrored.dpsi_rad, -swapped.dpsi_rad);
  }
  EXPECT_FALSE(law::normalise<double>({0.1, 0.0, 0.1}, {0.0, 1.0}, {}).valid);
  EXPECT_FALSE(law::normalise<double>({NAN, 0.0, 0.1}, {1.0, 1.0}, {}).valid);
}

TEST(Odometry, CounterDifferenceIsTrueAcrossItsWrap) {
  std::mt19937 random(4);
  std::uniform_int_distribution<std::int64_t> any(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max());
  std::uniform_int_distribution<std::int64_t> moved(-2'000'000'000, 2'000'000'000);
  for (int i = 0; i < 100'000; ++i) {
    const auto before = static_cast<std::int32_t>(any(random));
    const auto by = static_cast<std::int32_t>(moved(random));
    const auto now = static_cast<std::int32_t>(static_cast<std::uint32_t>(before) + static_cast<std::uint32_t>(by));
    ASSERT_EQ(law::delta32(now, before), by);
  }
}

TEST(Odometry, ArcsCloseAndMethodsAgreeWhereTheyShould) {
  // A circle in 100 steps: the exact arc closes it, Euler does not.
  law::OdometryConfig<double> config{1e-4, 1e-4, 0.7, law::OdometryMethod::kExactArc};
  const auto circle = [&](law::OdometryMethod method) {
    law::Pose<double> pose;
    for (int k = 0; k < 100; ++k) {
      EXPECT_TRUE(law::odometry_advance(method, pose, law::Travel<double>{0.05, 2.0 * std::numbers::pi / 100.0}));
    }
    return pose;
  };
  const auto exact = circle(law::OdometryMethod::kExactArc);
  EXPECT_NEAR(std::hypot(exact.x_m, exact.y_m), 0.0, 1e-12);
  EXPECT_NEAR(exact.psi_rad, 2.0 * std::numbers::pi, 1e-12);
  // D25: at a steady speed Euler's error is half a step times the change of the heading's direction, so it never grows beyond one step
  // (3 mm at 100 Hz and 0.3 m/s), however long the walk.
  law::Pose<double> euler;
  law::Pose<double> arc;
  double worst_m = 0.0;
  for (int k = 0; k < 7000; ++k) {
    const double turn = 0.3 * std::sin(2.0 * std::numbers::pi * k / 3500.0) * kDt_s;
    ASSERT_TRUE(law::odometry_advance(law::OdometryMethod::kEuler, euler, law::Travel<double>{0.3 * kDt_s, turn}));
    ASSERT_TRUE(law::odometry_advance(law::OdometryMethod::kExactArc, arc, law::Travel<double>{0.3 * kDt_s, turn}));
    worst_m = std::max(worst_m, std::hypot(euler.x_m - arc.x_m, euler.y_m - arc.y_m));
  }
  EXPECT_LT(worst_m, 0.3 * kDt_s * 1.01);
  EXPECT_GT(worst_m, 1e-6) << "otherwise the two are the same code";
  // One calibration per wheel.
  config.left_m_per_count = 1.01e-4;
  const auto travel = law::odometry_travel(config, 100, 100);
  EXPECT_NEAR(travel.turn_rad, (0.01 - 0.0101) / 0.7, 1e-15);
}

TEST(DifferentialDrive, ForwardAndBackAreInverse) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 10'000; ++i) {
    const law::PlatformSpeed<double> speed{any(random), any(random)};
    const auto wheels = law::wheel_speeds(speed, 0.7);
    const auto back = law::platform_speed_of(wheels, 0.7);
    ASSERT_NEAR(back.v_m_s, speed.v_m_s, 1e-14);
    ASSERT_NEAR(back.omega_rad_s, speed.omega_rad_s, 1e-14);
    if (speed.omega_rad_s > 0.0) {
      ASSERT_GT(wheels.right_m_s, wheels.left_m_s) << "a left turn needs the right wheel faster";
    }
  }
}

}  // namespace
}  // namespace hoist::test
