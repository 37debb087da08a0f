// The reference figures: geometry that must fit together, and projection against brute force.
#include "control/contract/exercises.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace hoist::contract {
namespace {

OwnLine line_of(const std::vector<FloorPoint>& points, bool closed) {
  OwnLine line;
  line.closed = closed;
  for (const FloorPoint& point : points) line.points[line.count++] = point;
  return line;
}

std::vector<ReferencePath> figures() {
  return {ReferencePath::square(),
          ReferencePath::eight(),
          ReferencePath::eight(0.9, 0.9),
          ReferencePath::straight(4.0),
          ReferencePath::circle(0.7),
          ReferencePath::round_square(2.0, 0.4),
          ReferencePath::round_square(1.0, 0.5),
          ReferencePath::slalom(2.0),
          ReferencePath::slalom(1.5).mirrored(),
          ReferencePath::own(kUsualOwnLine, 0.5),
          ReferencePath::own(kUsualOwnLine, 0.0),
          ReferencePath::own(kUsualOwnLine, 20.0),
          ReferencePath::own(line_of({{0, 0}, {1, 0}, {1.5, 1}, {0.4, 1.2}, {0.4, -1}}, false), 0.3),
          ReferencePath::own(line_of({{0.3, 0.2}, {-1, 2}}, false), 0.5),
          ReferencePath::own(kUsualOwnLine, 0.5).mirrored(),
          ReferencePath::square().mirrored(),
          ReferencePath::eight().mirrored()};
}

TEST(ReferencePath, IsOneContinuousLineOfItsOwnLength) {
  for (const auto& path : figures()) {
    SCOPED_TRACE(static_cast<int>(path.shape()));
    const double step_m = path.length_m() / 20'000.0;
    const double end_m = path.closed() ? 3.0 * path.length_m() : path.length_m();
    double gone_m = 0.0;
    PathPose before = path.pose(0.0);
    for (double s_m = step_m; s_m <= end_m; s_m += step_m) {
      const PathPose at = path.pose(s_m);
      const double moved_m = std::hypot(at.x_m - before.x_m, at.y_m - before.y_m);
      // A billionth of a metre before a joint counts as the joint.
      ASSERT_LE(moved_m, step_m + 3e-9) << "a jump at " << s_m;
      gone_m += moved_m;
      before = at;
    }
    EXPECT_NEAR(gone_m, end_m, 1e-3 * end_m);
    if (path.closed()) {
      const PathPose start = path.pose(0.0);
      const PathPose lap = path.pose(path.length_m());
      EXPECT_NEAR(lap.x_m, start.x_m, 1e-12);
      EXPECT_NEAR(lap.y_m, start.y_m, 1e-12);
      EXPECT_NEAR(std::remainder(lap.psi_rad - start.psi_rad, 2.0 * std::numbers::pi), 0.0, 1e-12);
    }
  }
}

TEST(ReferencePath, HeadingIsTheTangentAndCurvatureItsSlope) {
  for (const auto& path : figures()) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> anywhere(0.01, path.length_m() - 0.01);
    constexpr double kStep_m = 1e-5;
    int smooth = 0;
    for (int i = 0; i < 2000; ++i) {
      const double s_m = anywhere(random);
      const PathPose a = path.pose(s_m - kStep_m);
      const PathPose b = path.pose(s_m);
      const PathPose c = path.pose(s_m + kStep_m);
      if (a.kappa_per_m != c.kappa_per_m || std::fabs(a.psi_rad - c.psi_rad) > 0.1) continue;
      ++smooth;
      const double tangent_rad = std::atan2(c.y_m - a.y_m, c.x_m - a.x_m);
      ASSERT_NEAR(std::remainder(tangent_rad - b.psi_rad, 2.0 * std::numbers::pi), 0.0, 1e-6) << s_m;
      ASSERT_NEAR((c.psi_rad - a.psi_rad) / (2.0 * kStep_m), b.kappa_per_m, 1e-6) << s_m;
    }
    EXPECT_GT(smooth, 1900);
  }
}

TEST(ReferencePath, AnOwnSquareIsTheSquare) {
  // Sharp from its corner, round from the middle of its first side.
  const OwnLine drawn = line_of({{-1.5, -1.5}, {1.5, -1.5}, {1.5, 1.5}, {-1.5, 1.5}}, true);
  for (const double radius_m : {0.0, 0.4, 1.5}) {
    const ReferencePath own = ReferencePath::own(drawn, radius_m);
    const ReferencePath square = radius_m > 0 ? ReferencePath::round_square(3.0, radius_m) : ReferencePath::square(3.0);
    ASSERT_NEAR(own.length_m(), square.length_m(), 1e-12) << radius_m;
    EXPECT_TRUE(own.closed());
    for (double s_m = 0.001; s_m < 2.5 * square.length_m(); s_m += 0.013) {
      const PathPose a = own.pose(s_m), b = square.pose(s_m);
      ASSERT_NEAR(a.x_m, b.x_m, 1e-12) << s_m;
      ASSERT_NEAR(a.y_m, b.y_m, 1e-12) << s_m;
      ASSERT_NEAR(a.psi_rad, b.psi_rad, 1e-12) << s_m;
      ASSERT_NEAR(a.kappa_per_m, b.kappa_per_m, 1e-12) << s_m;
    }
  }
}

TEST(ReferencePath, AnOwnLineTakesTheRadiusThatFitsAndRefusesWhatIsNoLine) {
  // An L of 4 m and 1 m: at most half of the short side belongs to the corner.
  const OwnLine corner = line_of({{0, 0}, {4, 0}, {4, 1}}, false);
  const auto tightest_m = [](const ReferencePath& path) {
    double most = 0;
    for (double s_m = 0; s_m < path.length_m(); s_m += 0.001) most = std::max(most, std::fabs(path.pose(s_m).kappa_per_m));
    return 1 / most;
  };
  EXPECT_NEAR(tightest_m(ReferencePath::own(corner, 0.3)), 0.3, 1e-12);
  EXPECT_NEAR(tightest_m(ReferencePath::own(corner, 3.0)), 0.5, 1e-12);
  EXPECT_NEAR(ReferencePath::own(corner, 3.0).length_m(), 3.5 + 0.5 + 0.5 * std::numbers::pi / 2, 1e-12);
  EXPECT_FALSE(ReferencePath::own(corner, 0.3).closed());
  // There and back has no room for an arc: it turns on the spot.
  const ReferencePath back = ReferencePath::own(line_of({{0, 0}, {2, 0}, {0, 0}}, false), 0.5);
  EXPECT_EQ(back.length_m(), 4.0);
  EXPECT_NEAR(std::fabs(back.pose(3.0).psi_rad), std::numbers::pi, 1e-12);
  const ReferencePath most = ReferencePath::own(
      [] {
        OwnLine line;
        line.closed = true;
        for (line.count = 0; line.count < kOwnPointsMost; ++line.count) {
          const double angle_rad = 2.0 * std::numbers::pi * static_cast<double>(line.count) / static_cast<double>(kOwnPointsMost);
          line.points[line.count] = {3.0 * std::cos(angle_rad), 3.0 * std::sin(angle_rad)};
        }
        return line;
      }(),
      1.0);
  EXPECT_NEAR(most.pose(3.0 * most.length_m()).psi_rad - most.pose(0.0).psi_rad, 6.0 * std::numbers::pi, 1e-9);
  for (const OwnLine& none :
       {line_of({}, false), line_of({{0, 0}}, false), line_of({{0, 0}, {1, 0}}, true), line_of({{0, 0}, {0, 0}}, false),
        line_of({{0, 0}, {51, 0}}, false), line_of({{0, 0}, {std::nan(""), 0}}, false)})
    EXPECT_FALSE(ReferencePath::own(none, 0.5).valid());
  EXPECT_FALSE(ReferencePath::own(corner, -0.5).valid());
}

TEST(ReferencePath, SquareCountsTurnsAndTheEightDoesNot) {
  const auto square = ReferencePath::square(2.0);
  EXPECT_NEAR(square.pose(8.0 * 5.0 + 0.5).psi_rad, 5.0 * 2.0 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(square.pose(-0.5).psi_rad, -std::numbers::pi / 2.0, 1e-12) << "before the start is the lap before";
  const auto eight = ReferencePath::eight();
  EXPECT_NEAR(eight.pose(7.0 * eight.length_m() + 0.1).psi_rad, eight.pose(0.1).psi_rad, 1e-12);
  // On a corner the edge that follows.
  EXPECT_NEAR(square.pose(2.0).psi_rad, std::numbers::pi / 2.0, 1e-12);
  EXPECT_NEAR(square.pose(std::nextafter(2.0, 0.0)).psi_rad, std::numbers::pi / 2.0, 1e-12);
}

TEST(ReferencePath, ProjectsLikeBruteForce) {
  for (const auto& path : figures()) {
    for (unsigned seed = 0; seed < 300; ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> place(-2.5, 2.5);
      std::uniform_real_distribution<double> from(0.0, path.closed() ? 2.0 * path.length_m() : path.length_m());
      std::uniform_real_distribution<double> width(0.05, 1.5);
      const double x_m = place(random);
      const double y_m = place(random);
      const double from_m = from(random);
      const double window_m = width(random);
      const double s_m = path.project(x_m, y_m, from_m, window_m);
      ASSERT_GE(s_m, from_m);
      ASSERT_LE(s_m, from_m + window_m + 1e-9);
      const auto distance_at = [&](double at_m) {
        const PathPose pose = path.pose(at_m);
        return std::hypot(pose.x_m - x_m, pose.y_m - y_m);
      };
      double best_m = std::numeric_limits<double>::infinity();
      for (int i = 0; i <= 2000; ++i) best_m = std::min(best_m, distance_at(from_m + window_m * i / 2000.0));
      ASSERT_LE(distance_at(s_m), best_m + 1e-9) << "seed " << seed;
    }
  }
}

TEST(ReferencePath, TakesTheFirstOfEquallyNearPlaces) {
  // Inside a corner both edges are a quarter of a metre away.
  EXPECT_EQ(ReferencePath::square(2.0).project(0.75, -0.75, 1.5, 1.0), 1.75);
}

TEST(ReferencePath, ProjectionNeverJumpsTheCrossing) {
  // Walking the eight five times through its crossing: a search of the whole figure would change branch there.
  const auto path = ReferencePath::eight();
  double s_m = 0.0;
  for (double true_m = 0.0; true_m < 5.0 * path.length_m(); true_m += 0.003) {
    const PathPose at = path.pose(true_m);
    const double offset_m = 0.04 * std::sin(7.0 * true_m);
    const double next_m = path.project(at.x_m - offset_m * std::sin(at.psi_rad), at.y_m + offset_m * std::cos(at.psi_rad), s_m);
    ASSERT_GE(next_m, s_m);
    s_m = next_m;
    ASSERT_NEAR(s_m, true_m, 0.06) << "at " << true_m;
  }
}

TEST(ReferencePath, UnusableSizesGiveAnEmptyPath) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, nan, inf}) {
    for (const auto& path :
         {ReferencePath::square(bad), ReferencePath::eight(bad, 0.8), ReferencePath::eight(1.0, bad), ReferencePath::straight(bad)}) {
      EXPECT_FALSE(path.valid());
      EXPECT_EQ(path.length_m(), 0.0);
      EXPECT_EQ(path.pose(1.0).x_m, 0.0);
      EXPECT_EQ(path.project(1.0, 1.0, 0.25), 0.25);
    }
  }
  EXPECT_FALSE(ReferencePath::eight(1.0, 1.1).valid());
  const auto square = ReferencePath::square();
  EXPECT_EQ(square.project(nan, 0.0, 1.0), 1.0);
  EXPECT_EQ(square.project(0.0, inf, 1.0), 1.0);
  EXPECT_TRUE(std::isfinite(square.pose(nan).x_m));
  EXPECT_TRUE(std::isfinite(square.pose(inf).x_m));
  const auto straight = ReferencePath::straight(4.0);
  EXPECT_EQ(straight.pose(99.0).x_m, 4.0);
  EXPECT_EQ(straight.project(9.0, 0.0, 3.9), 4.0) << "the straight ends";
}

}  // namespace
}  // namespace hoist::contract
