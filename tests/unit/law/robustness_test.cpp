// For any input the output of a law is finite; and valid input restores it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "control/contract/reference_path.hpp"
#include "control/core/law/kalman_gain.hpp"
#include "control/core/law/pelvis.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/core/law/servo_loop.hpp"
#include "control/core/law/tilt_kalman.hpp"
#include "db/metrics/cross_correlation.hpp"
#include "tests/unit/law/golden.hpp"

namespace hoist::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kDt_s = 0.01;

std::vector<double> numbers_of(const nlohmann::json& column) {
  std::vector<double> out;
  for (const auto& value : column) {
    out.push_back(value.is_null() ? kNan : (value == "inf" ? kInf : (value == "-inf" ? -kInf : value.get<double>())));
  }
  return out;
}

nlohmann::json open_case(const std::string& function) {
  for (const auto& file : golden_files()) {
    if (file.kind != "open") continue;
    for (const auto& golden : file.cases) {
      if (golden.at("in").at("function") == function) return golden.at("in");
    }
  }
  ADD_FAILURE() << "no open case for " << function;
  return {};
}

TEST(Robustness, TranslationFadesWhileTheWishIsUnknownAndComesBack) {
  law::PfpConfig<double> config;
  law::PfpState<double> state;
  law::PfpState<double> undisturbed;
  bool refused = false;
  double before = 0.0;
  for (const double u : numbers_of(open_case("trans").at("u"))) {
    const auto branch = law::pfp_step(config, state, u, kDt_s);
    law::pfp_step(config, undisturbed, 0.5, kDt_s);
    ASSERT_TRUE(std::isfinite(state.v_units) && std::isfinite(state.v_f_units));
    if (!std::isfinite(u)) {
      EXPECT_EQ(branch, law::PfpBranch::kRefused);
      EXPECT_LT(state.v_units, before) << "an unknown wish must slow the platform down";
      refused = true;
    } else {
      EXPECT_NE(branch, law::PfpBranch::kRefused);
    }
    before = state.v_units;
  }
  EXPECT_TRUE(refused);
  // Half a second after five lost samples: within 5 % of a run that lost none.
  EXPECT_NEAR(state.v_units, undisturbed.v_units, 0.05 * undisturbed.v_units);
}

TEST(Robustness, RotationSurvivesAnInfinity) {
  law::PfpTurnConfig<double> config;
  law::PfpTurnState<double> state;
  int refused = 0;
  for (const double u : numbers_of(open_case("rot").at("u"))) {
    refused += law::pfp_turn_step(config, state, u, kDt_s) == law::PfpTurnBranch::kRefused ? 1 : 0;
    ASSERT_TRUE(std::isfinite(state.omega_units) && std::isfinite(state.omega_f_units));
    ASSERT_LE(std::fabs(state.omega_units), config.k_p + config.k_pf);
  }
  EXPECT_EQ(refused, 1);
  EXPECT_GT(state.omega_units, 0.6);
}

TEST(Robustness, TiltKeepsItsStateThroughUnusableSamples) {
  auto state = law::tilt_start(0.1, 0.01, 0.0);
  for (const double bad : numbers_of(open_case("tilt").at("u"))) {
    EXPECT_FALSE(law::tilt_step(law::TiltGain<double>{}, state, bad, bad, kDt_s));
    EXPECT_FALSE(law::tilt_step(law::TiltGain<double>{}, state, bad, 0.0, kDt_s));
    EXPECT_FALSE(law::tilt_step(law::TiltGain<double>{}, state, 0.0, bad, kDt_s));
    EXPECT_FALSE(law::tilt_step(law::TiltGain<double>{}, state, 0.0, 0.0, bad));
  }
  EXPECT_EQ(state.angle_rad, 0.1);
  EXPECT_EQ(state.bias_rad_s, 0.01);
  EXPECT_TRUE(law::tilt_step(law::TiltGain<double>{}, state, 0.0, 0.1, kDt_s));
  const auto started = law::tilt_start(kNan, 0.0, 0.0);
  EXPECT_EQ(started.angle_rad, 0.0);
  EXPECT_FALSE(law::acc_angles(kNan, 0.0, 1.0).valid);
  EXPECT_FALSE(law::acc_angles(0.0, 0.0, 0.0).valid);
  EXPECT_FALSE(law::acc_angles(0.0, kInf, 1.0).valid);
}

TEST(Robustness, CorrelationOfNothingIsNoNumber) {
  const auto u = numbers_of(open_case("xcorr0").at("u"));
  EXPECT_FALSE(db::cross_correlation(u, u).has_value());
  const std::vector<double> zero(5, 0.0);
  const std::vector<double> bad = {1.0, kNan};
  const std::vector<double> good = {1.0, 2.0};
  EXPECT_FALSE(db::cross_correlation(zero, zero).has_value());
  EXPECT_FALSE(db::cross_correlation(bad, good).has_value());
  EXPECT_FALSE(db::cross_correlation(good, zero).has_value());
}

/// Numbers an attacker or a broken sensor would choose, among ordinary ones.
template <typename Real>
Real nasty(std::mt19937& random) {
  using Limits = std::numeric_limits<Real>;
  static constexpr std::array<Real, 14> kNasty = {
      Real(0),        -Real(0),      Limits::quiet_NaN(),  Limits::infinity(), -Limits::infinity(), Limits::max(),
      -Limits::max(), Limits::min(), Limits::denorm_min(), Limits::epsilon(),  Real(0.05),          -Real(0.05),
      Real(1),        -Real(1)};
  std::uniform_int_distribution<std::size_t> pick(0, 2 * kNasty.size() - 1);
  std::uniform_real_distribution<double> ordinary(-1.5, 1.5);
  const auto at = pick(random);
  return at < kNasty.size() ? kNasty[at] : static_cast<Real>(ordinary(random));
}

template <typename Real>
class Nasty : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Nasty, Reals);

TYPED_TEST(Nasty, ControllersStayFiniteAndRecover) {
  using Real = TypeParam;
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    law::PfpConfig<Real> config;
    law::PfpTurnConfig<Real> turn_config;
    if (seed % 2 == 1) {
      // Unvalidated parameters.
      config = {nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random),
                nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), seed % 4 == 1};
      turn_config = {nasty<Real>(random), nasty<Real>(random), nasty<Real>(random),
                     nasty<Real>(random), nasty<Real>(random), law::TurnDeadband::kLiteral};
    }
    law::PfpState<Real> state;
    law::PfpTurnState<Real> turn_state;
    for (int k = 0; k < 2000; ++k) {
      const Real dt_s = k % 7 == 0 ? nasty<Real>(random) : Real(0.01);
      law::pfp_step(config, state, nasty<Real>(random), dt_s);
      law::pfp_turn_step(turn_config, turn_state, nasty<Real>(random), dt_s);
      ASSERT_TRUE(std::isfinite(state.v_units) && std::isfinite(state.v_f_units)) << "seed " << seed << " step " << k;
      ASSERT_TRUE(std::isfinite(turn_state.omega_units) && std::isfinite(turn_state.omega_f_units)) << "seed " << seed << " step " << k;
      if (seed % 2 == 0) {
        ASSERT_LE(std::fabs(state.v_units), Real(52.001));
        ASSERT_LE(std::fabs(turn_state.omega_units), Real(52.001));
      }
    }
    // A corrupted state gives zero, not a guess.
    state = {std::numeric_limits<Real>::quiet_NaN(), Real(1)};
    EXPECT_EQ(law::pfp_step(config, state, Real(1), Real(0.01)), law::PfpBranch::kRefused);
    EXPECT_EQ(state.v_units, Real(0));
    EXPECT_EQ(state.v_f_units, Real(0));
    const law::PfpConfig<Real> good;
    EXPECT_EQ(law::pfp_step(good, state, Real(1), Real(0.01)), law::PfpBranch::kNormal);
    EXPECT_GT(state.v_units, Real(2));
  }
}

TYPED_TEST(Nasty, ServoStaysFiniteAndWithinItsDuty) {
  using Real = TypeParam;
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::int32_t> any(std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max());
    law::ServoConfig<Real> config;
    law::ServoState<Real> state;
    for (int k = 0; k < 2000; ++k) {
      const Real supply_v = k % 5 == 0 ? nasty<Real>(random) : Real(24);
      const auto out =
          law::servo_step(config, state, {nasty<Real>(random), nasty<Real>(random), any(random), nasty<Real>(random), supply_v},
                          k % 11 == 0 ? nasty<Real>(random) : Real(1e-3));
      ASSERT_TRUE(std::isfinite(out.duty_norm) && std::isfinite(out.speed_rad_s) && std::isfinite(out.reference_rad_s));
      ASSERT_LE(std::fabs(out.duty_norm), Real(1));
      if (out.refused) {
        ASSERT_EQ(out.duty_norm, Real(0));
      }
      ASSERT_TRUE(std::isfinite(state.integral_v) && std::isfinite(state.applied_v));
    }
  }
}

TYPED_TEST(Nasty, EverythingElseStaysFinite) {
  using Real = TypeParam;
  std::mt19937 random(11);
  law::Pose<Real> pose;
  law::RateLimitState<Real> ramp;
  law::LowPassState<Real> filtered;
  auto tilt = law::tilt_start(Real(0), Real(0), Real(0));
  for (int k = 0; k < 100'000; ++k) {
    const law::StrutAngles<Real> struts{nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random)};
    const law::PelvisGeometry<Real> geometry{nasty<Real>(random), nasty<Real>(random)};
    const auto intent = law::normalise(law::pelvis_exact(struts, geometry), law::full_range(geometry, nasty<Real>(random)),
                                       {nasty<Real>(random), nasty<Real>(random)});
    ASSERT_TRUE(std::fabs(intent.u_norm) <= Real(1) && std::fabs(intent.u_psi_norm) <= Real(1));
    if (!intent.valid) {
      ASSERT_EQ(intent.u_norm, Real(0));
      ASSERT_EQ(intent.u_psi_norm, Real(0));
    }
    const law::OdometryConfig<Real> odometry{nasty<Real>(random), nasty<Real>(random), nasty<Real>(random),
                                             static_cast<law::OdometryMethod>(k % 3)};
    static_cast<void>(law::odometry_step(odometry, pose, k, -k));
    ASSERT_TRUE(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.psi_rad));
    static_cast<void>(law::tilt_step(law::TiltGain<Real>{}, tilt, nasty<Real>(random), nasty<Real>(random), nasty<Real>(random)));
    ASSERT_TRUE(std::isfinite(tilt.angle_rad) && std::isfinite(tilt.bias_rad_s));
    ASSERT_TRUE(std::isfinite(law::rate_limit_step(nasty<Real>(random), ramp, nasty<Real>(random), nasty<Real>(random))));
    ASSERT_TRUE(std::isfinite(law::low_pass_step(Real(0.004), filtered, nasty<Real>(random), Real(0.001))));
    if (k % 1000 == 0) {
      const auto gain = law::solve_kalman_gain<Real>(
          {nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random), nasty<Real>(random)});
      ASSERT_TRUE(std::isfinite(gain.k_angle) && std::isfinite(gain.k_bias));
    }
  }
}

TEST(Robustness, EveryUnusableParameterIsNamed) {
  const auto expect_named = [](const char* sentence, const std::string& name) {
    ASSERT_NE(sentence, nullptr) << name;
    EXPECT_EQ(std::string(sentence).rfind(name + ":", 0), 0U) << sentence;
  };
  using Pfp = law::PfpConfig<double>;
  EXPECT_EQ(law::refusal(Pfp{}), nullptr);
  const std::vector<std::tuple<std::string, double Pfp::*, double>> wrong = {{"deadband_norm", &Pfp::deadband_norm, 1.0},
                                                                             {"tau_n_s", &Pfp::tau_n_s, 0.0},
                                                                             {"tau_dec_s", &Pfp::tau_dec_s, -1.0},
                                                                             {"l_dec", &Pfp::l_dec, 0.0},
                                                                             {"k_2r", &Pfp::k_2r, -1e-9},
                                                                             {"k_p", &Pfp::k_p, -1.0},
                                                                             {"k_pf", &Pfp::k_pf, kInf},
                                                                             {"v_f_max_units", &Pfp::v_f_max_units, -1.0}};
  for (const auto& [name, member, value] : wrong) {
    for (const double bad : {value, kNan}) {
      Pfp config;
      config.*member = bad;
      expect_named(law::refusal(config), name);
    }
  }
  using Turn = law::PfpTurnConfig<double>;
  EXPECT_EQ(law::refusal(Turn{}), nullptr);
  for (const auto& [name, member] : std::vector<std::pair<std::string, double Turn::*>>{{"deadband_norm", &Turn::deadband_norm},
                                                                                        {"tau_n_s", &Turn::tau_n_s},
                                                                                        {"tau_dec_s", &Turn::tau_dec_s},
                                                                                        {"k_p", &Turn::k_p},
                                                                                        {"k_pf", &Turn::k_pf}}) {
    Turn config;
    config.*member = kNan;
    expect_named(law::refusal(config), name);
  }
  using Servo = law::ServoConfig<double>;
  EXPECT_EQ(law::refusal(Servo{}), nullptr);
  for (const auto& [name, member] :
       std::vector<std::pair<std::string, double Servo::*>>{{"counts_per_turn", &Servo::counts_per_turn},
                                                            {"acceleration_max_rad_s2", &Servo::acceleration_max_rad_s2},
                                                            {"current_limit_a", &Servo::current_limit_a},
                                                            {"k_p_v_s_rad", &Servo::k_p_v_s_rad},
                                                            {"k_i_v_rad", &Servo::k_i_v_rad},
                                                            {"speed_low_pass_s", &Servo::speed_low_pass_s},
                                                            {"limiter_v_per_a", &Servo::limiter_v_per_a},
                                                            {"supply_min_v", &Servo::supply_min_v},
                                                            {"command_timeout_s", &Servo::command_timeout_s}}) {
    Servo config;
    config.*member = -1.0;
    expect_named(law::refusal(config), name);
    config.*member = kNan;
    expect_named(law::refusal(config), name);
  }
}

}  // namespace
}  // namespace hoist::test
