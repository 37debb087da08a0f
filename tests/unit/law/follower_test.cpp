// The path follower's law on its own kinematic model: a unicycle with the drives' lag, implemented independently of the product.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "control/contract/reference_path.hpp"
#include "control/core/law/path_follower.hpp"

namespace hoist::law {
namespace {

constexpr double kStep_s = 0.01;

struct Unicycle {
  double x_m = 0, y_m = 0, psi_rad = 0;
  double rate_rad_s = 0;

  void move(double speed_m_s, double wanted_rad_s, double lag_s, double rate_gain = 1.0) {
    rate_rad_s += (wanted_rad_s - rate_rad_s) * (lag_s > 0 ? kStep_s / (lag_s + kStep_s) : 1.0);
    const double turned_rad = rate_gain * rate_rad_s * kStep_s;
    x_m += speed_m_s * kStep_s * std::cos(psi_rad + turned_rad / 2);
    y_m += speed_m_s * kStep_s * std::sin(psi_rad + turned_rad / 2);
    psi_rad += turned_rad;
  }
};

PathError<double> error_of(const contract::ReferencePath& path, const Unicycle& at, double& s_m) {
  s_m = path.project(at.x_m, at.y_m, s_m);
  const contract::PathPose on = path.pose(s_m);
  const double x_m = at.x_m - on.x_m, y_m = at.y_m - on.y_m;
  return {std::cos(on.psi_rad) * y_m - std::sin(on.psi_rad) * x_m, std::remainder(at.psi_rad - on.psi_rad, 2 * std::numbers::pi),
          on.kappa_per_m};
}

TEST(PathFollower, ComesOntoALineWithoutSwingingOverWhateverTheSpeed) {
  for (const double speed_m_s : {0.05, 0.2, 0.6}) {
    const contract::ReferencePath path = contract::ReferencePath::straight(10.0);
    Unicycle hoist{0, 0.2, 0, 0};
    double s_m = 0, lowest_m = 0.2;
    for (int i = 0; i < static_cast<int>(6.0 / (speed_m_s * kStep_s)); ++i) {
      const PathError<double> error = error_of(path, hoist, s_m);
      hoist.move(speed_m_s, path_curvature<double>({}, error) * speed_m_s, 0.0);
      lowest_m = std::fmin(lowest_m, error.cross_m);
    }
    EXPECT_GT(lowest_m, -1e-3) << speed_m_s;
    EXPECT_NEAR(hoist.y_m, 0, 1e-5) << speed_m_s;
    EXPECT_NEAR(hoist.psi_rad, 0, 1e-5) << speed_m_s;
  }
}

// V = d^2 / L^2 + h^2 falls along every path on lines and circles, as the proof in the header says.
TEST(PathFollower, ItsLyapunovFunctionNeverRises) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> cross(-0.25, 0.25), heading(-1.0, 1.0), radius(0.4, 3.0), speed(0.05, 0.6);
  const PathFollowerConfig<double> config;
  for (int run = 0; run < 200; ++run) {
    const double kappa = run % 3 == 0 ? 0.0 : (run % 3 == 1 ? 1.0 : -1.0) / radius(random);
    const double speed_m_s = speed(random);
    double d_m = cross(random), h_rad = heading(random);
    double before = d_m * d_m / (config.reach_m * config.reach_m) + h_rad * h_rad;
    for (int i = 0; i < 20000; ++i) {
      // The error equations themselves, in steps so small that their own error does not count.
      constexpr double kFine_s = 0.002;
      const double curve = path_curvature<double>(config, {d_m, h_rad, kappa});
      if (std::fabs(curve) >= config.kappa_max_per_m) break;  // bounded: the proof speaks of the law itself
      const double along = std::cos(h_rad) / (1 - kappa * d_m);
      d_m += kFine_s * speed_m_s * std::sin(h_rad);
      h_rad += kFine_s * speed_m_s * (curve - kappa * along);
      const double now = d_m * d_m / (config.reach_m * config.reach_m) + h_rad * h_rad;
      ASSERT_LE(now, before + 1e-5) << "run " << run << " step " << i;
      before = now;
    }
  }
}

TEST(PathFollower, RandomPathsStartsLagsAndSlipsEndOnThePath) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int run = 0; run < 300; ++run) {
    const double c_m = 0.8 + unit(random), r_m = c_m * (0.6 + 0.4 * unit(random));
    contract::ReferencePath path = run % 4 == 0   ? contract::ReferencePath::eight(c_m, r_m)
                                   : run % 4 == 1 ? contract::ReferencePath::circle(r_m)
                                   : run % 4 == 2 ? contract::ReferencePath::round_square(2 * c_m, 0.5 * c_m)
                                                  : contract::ReferencePath::straight(100.0);
    if (unit(random) < 0.5) path = path.mirrored();
    const double speed_m_s = 0.1 + 0.5 * unit(random), lag_s = 0.2 * unit(random);
    // A wheel that slips now and then turns the hoist less than it should.
    const double slip_gain = 1 - 0.3 * unit(random);
    const contract::PathPose start = path.pose(0.0);
    Unicycle hoist{start.x_m + 0.1 * (unit(random) - 0.5), start.y_m + 0.3 * (unit(random) - 0.5),
                   start.psi_rad + 0.8 * (unit(random) - 0.5), 0};
    double s_m = 0, worst_late_m = 0, worst_m = 0;
    const int steps = static_cast<int>(12.0 / (speed_m_s * kStep_s));
    for (int i = 0; i < steps; ++i) {
      const PathError<double> error = error_of(path, hoist, s_m);
      const double curve = path_curvature<double>({}, error);
      const bool slips = i % 700 < 30 && i < steps / 2;
      hoist.move(speed_m_s, curve * speed_m_s, lag_s, slips ? slip_gain : 1.0);
      worst_m = std::fmax(worst_m, std::fabs(error.cross_m));
      if (i > steps * 3 / 4) worst_late_m = std::fmax(worst_late_m, std::fabs(error.cross_m));
    }
    EXPECT_LT(worst_m, 0.35) << run;
    // The rest is the lag where the curvature jumps: the mode looks ahead, this test does not.
    EXPECT_LT(worst_late_m, 0.01 + 0.15 * lag_s) << "run " << run << " lag " << lag_s << " speed " << speed_m_s;
  }
}

TEST(PathFollower, HostileNumbersGoStraightAndTheCurveIsBounded) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInf, -kInf}) {
    EXPECT_EQ(path_curvature<double>({}, {bad, 0, 0}), 0);
    EXPECT_EQ(path_curvature<double>({}, {0, bad, 0}), 0);
    EXPECT_EQ(path_curvature<double>({}, {0, 0, bad}), 0);
  }
  EXPECT_EQ(path_curvature<double>({}, {1e6, 0, 0}), -4.0);
  EXPECT_EQ(path_curvature<double>({}, {-1e6, 0, 0}), 4.0);
  // Beyond the centre of the curve the figure's own part stays bounded and keeps its side.
  EXPECT_GT(path_curvature<double>({}, {5.0, 0, 1.0}), -4.0 - 1e-12);
  EXPECT_EQ(path_curvature<double>({}, {0, 0, 0.5}), 0.5) << "on the path its own curvature is driven";
}

TEST(ApproachSpeed, IsTheRampThatArrives) {
  EXPECT_DOUBLE_EQ(approach_speed(0.5, 0.0, 0.25), 0.5);
  EXPECT_DOUBLE_EQ(approach_speed(0.0, 0.3, 0.25), 0.3);
  EXPECT_EQ(approach_speed(-1.0, 0.0, 0.25), 0);
}

}  // namespace
}  // namespace hoist::law
