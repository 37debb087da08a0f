// The follower of a planned figure (command/guided.hpp), against the description of the figures and of the exercise: where
// the hoist is on its figure, how far off it, what curves lie ahead and how fast they may be driven. The figure is laid out
// here a second time, directly on the floor.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "control/contract/guided_path.hpp"
#include "control/core/command/guided.hpp"

namespace hoist::core::test::figure {
namespace {

using contract::GuidedEnd;
using contract::GuidedPath;
using contract::GuidedShape;
using law::Pose;

constexpr double kPi = std::numbers::pi;

/// A line or an arc; at its end the hoist turns on the spot by corner_rad.
struct Piece {
  double length_m = 0, kappa_per_m = 0, corner_rad = 0;
};
/// The figures as the head of reference_path.hpp describes them, counter-clockwise.
std::vector<Piece> one_lap(const GuidedPath& path) {
  const double size_m = path.size_m, r_m = path.radius_m;
  switch (path.shape) {
    case GuidedShape::straight:
      return {{size_m}};
    case GuidedShape::circle:
      return {{2 * kPi * size_m, 1 / size_m}};
    case GuidedShape::square: {
      if (r_m == 0) return {{size_m, 0, kPi / 2}, {size_m, 0, kPi / 2}, {size_m, 0, kPi / 2}, {size_m, 0, kPi / 2}};
      const Piece side{size_m - 2 * r_m}, half{size_m / 2 - r_m}, curve{kPi / 2 * r_m, 1 / r_m};
      return {half, curve, side, curve, side, curve, side, curve, half};
    }
    case GuidedShape::eight: {
      const double straight_m = std::sqrt(size_m * size_m - r_m * r_m), loop_m = r_m * (kPi + 2 * std::asin(r_m / size_m));
      return {{straight_m}, {loop_m, -1 / r_m}, {2 * straight_m}, {loop_m, 1 / r_m}, {straight_m}};
    }
    case GuidedShape::slalom: {
      // It crosses the line of the poles at 60 degrees, and begins and ends along it.
      const double curve_m = size_m / (2 * std::sin(kPi / 3)), sixth_m = kPi / 3 * curve_m, k = 1 / curve_m;
      return {{sixth_m, k}, {2 * sixth_m, -k}, {2 * sixth_m, k}, {2 * sixth_m, -k}, {2 * sixth_m, k}, {sixth_m, -k}};
    }
    default:
      return {};
  }
}

/// The figure on the floor, from where the hoist stood and looked at its begin; all laps one behind the other.
class Line {
 public:
  struct At {
    std::complex<double> floor_m;
    double psi_rad = 0, kappa_per_m = 0, rest_m = 0, next_kappa_per_m = 0;
  };
  Line(const GuidedPath& path, const Pose<double>& begin) {
    const std::vector<Piece> lap = one_lap(path);
    At at{{begin.x_m, begin.y_m}, begin.psi_rad};
    for (std::uint32_t n = 0; n < path.laps; ++n)
      for (Piece piece : lap) {
        if (path.clockwise) piece = {piece.length_m, -piece.kappa_per_m, -piece.corner_rad};
        at.kappa_per_m = piece.kappa_per_m;
        pieces_.push_back({at, length_m_, piece.length_m});
        at = along(pieces_.back(), piece.length_m);
        at.psi_rad += piece.corner_rad;
        length_m_ += piece.length_m;
      }
    // After the last lap a closed figure begins again, with the same curve as its first piece; an open one is over.
    const bool closed = path.shape != GuidedShape::straight && path.shape != GuidedShape::slalom;
    last_kappa_per_m_ = closed ? pieces_.front().begin.kappa_per_m : 0;
    end_psi_rad_ = at.psi_rad;
    const bool corners = path.shape == GuidedShape::square && path.radius_m == 0;
    legs_ = corners ? 4 * path.laps : 1;
  }
  [[nodiscard]] double length_m() const { return length_m_; }
  [[nodiscard]] double leg_m() const { return length_m_ / legs_; }
  [[nodiscard]] std::uint32_t legs() const { return legs_; }
  /// On a joint the piece that begins there, but never one behind `leg`.
  [[nodiscard]] At at(double s_m, std::uint32_t leg) const {
    const double end_m = leg_m() * (leg + 1);
    std::size_t i = pieces_.size() - 1;
    while (i > 0 && (pieces_[i].from_m > s_m + 1e-9 || pieces_[i].from_m > end_m - 1e-9)) --i;
    At found = along(pieces_[i], s_m - pieces_[i].from_m);
    found.rest_m = pieces_[i].from_m + pieces_[i].length_m - s_m;
    found.next_kappa_per_m = i + 1 < pieces_.size() ? pieces_[i + 1].begin.kappa_per_m : last_kappa_per_m_;
    return found;
  }
  /// Where the hoist looks once it has turned the corner behind this leg.
  [[nodiscard]] double heading_behind_rad(std::uint32_t leg) const {
    return leg + 1 < legs_ ? at(leg_m() * (leg + 1), leg + 1).psi_rad : end_psi_rad_;
  }
  /// The nearest place between these two: looked for every few millimetres, then where the way to the hoist is square to the line.
  [[nodiscard]] double nearest(std::complex<double> hoist_m, double from_m, double to_m, std::uint32_t leg) const {
    constexpr int kParts = 100;
    const auto place = [&](int i) { return from_m + (to_m - from_m) * i / kParts; };
    int best = 0;
    for (int i = 1; i <= kParts; ++i)
      if (std::abs(hoist_m - at(place(i), leg).floor_m) < std::abs(hoist_m - at(place(best), leg).floor_m)) best = i;
    double low_m = place(best > 0 ? best - 1 : 0), high_m = place(best < kParts ? best + 1 : kParts);
    for (int i = 0; i < 50; ++i) {
      const double middle_m = (low_m + high_m) / 2;
      (ahead_m(hoist_m, at(middle_m, leg)) > 0 ? low_m : high_m) = middle_m;
    }
    return low_m;
  }
  /// How far the hoist is ahead of this place, and how far to its left.
  static double ahead_m(std::complex<double> hoist_m, const At& at) {
    return ((hoist_m - at.floor_m) * std::polar(1.0, -at.psi_rad)).real();
  }
  static double left_m(std::complex<double> hoist_m, const At& at) {
    return ((hoist_m - at.floor_m) * std::polar(1.0, -at.psi_rad)).imag();
  }

 private:
  struct Laid {
    At begin;
    double from_m = 0, length_m = 0;
  };
  static At along(const Laid& piece, double s_m) {
    // A chord is shorter than its arc by sin(h) / h, and looks along the middle of it.
    const double half_rad = piece.begin.kappa_per_m * s_m / 2;
    const double chord_m = half_rad == 0 ? s_m : s_m * std::sin(half_rad) / half_rad;
    return {piece.begin.floor_m + std::polar(1.0, piece.begin.psi_rad + half_rad) * chord_m, piece.begin.psi_rad + 2 * half_rad,
            piece.begin.kappa_per_m};
  }
  std::vector<Laid> pieces_;
  double length_m_ = 0, last_kappa_per_m_ = 0, end_psi_rad_ = 0;
  std::uint32_t legs_ = 1;
};

double wrapped(double rad) { return std::remainder(rad, 2 * kPi); }

const GuidedPath kFigures[] = {
    {{GuidedShape::straight, false, 3.0, 0}, 0.3, 1}, {{GuidedShape::square, false, 1.2, 0}, 0.3, 2},
    {{GuidedShape::square, true, 0.7, 0}, 0.3, 1},    {{GuidedShape::square, false, 2.0, 0.5}, 0.3, 2},
    {{GuidedShape::square, true, 1.0, 0.5}, 0.3, 1},  {{GuidedShape::circle, false, 0.6, 0}, 0.3, 3},
    {{GuidedShape::circle, true, 1.5, 0}, 0.3, 1},    {{GuidedShape::eight, false, 1.0, 0.8}, 0.3, 2},
    {{GuidedShape::eight, true, 0.5, 0.5}, 0.3, 1},   {{GuidedShape::slalom, false, 2.0, 0}, 0.3, 1},
    {{GuidedShape::slalom, true, 1.75, 0}, 0.3, 1},   {{GuidedShape::straight, false, 0.5, 0}, 0.3, 1},
};

/// One exercise, pushed about at random around its line, beside the same written down here.
class Walk {
 public:
  Walk(const GuidedPath& path, std::uint32_t seed) : random_(seed), begin_{any(-9, 9), any(-9, 9), any(-9, 9)}, line_(path, begin_) {
    run_.load(path);
    run_.begin(begin_, 1);
    params_.wheel_radius_m = any(0.06, 0.1);
    params_.track_width_m = any(0.5, 0.9);
  }
  void all() {
    EXPECT_NEAR(run_.total_m(), line_.length_m(), 1e-9);
    EXPECT_EQ(run_.has_corners(), line_.legs() > 1);
    for (; leg_ < line_.legs(); ++leg_) {
      if (leg_ > 0) run_.next_leg();
      EXPECT_EQ(run_.last_leg(), leg_ + 1 == line_.legs());
      const double begin_m = line_.leg_m() * leg_, end_m = begin_m + line_.leg_m();
      s_m_ = begin_m;
      double there_m = begin_m;
      while (there_m < end_m + 0.1) {
        step(there_m, end_m);
        if (testing::Test::HasFailure()) return;
        const double kind = any(0, 1);
        there_m += kind < 0.1 ? any(0.3, 1.2) : (kind < 0.2 ? any(-0.2, 0) : any(0, 0.06));
        if (there_m < begin_m) there_m = begin_m;
      }
      step(end_m + 0.1, end_m);
    }
  }

 private:
  double any(double least, double most) { return std::uniform_real_distribution<double>(least, most)(random_); }

  /// The hoist stands beside this place, or as far beyond the end of the leg, straight on.
  void step(double there_m, double end_m) {
    const Line::At beside = line_.at(there_m < end_m ? there_m : end_m, leg_);
    const double on_m = there_m < end_m ? 0 : there_m - end_m;
    const std::complex<double> hoist_m = beside.floor_m + std::polar(1.0, beside.psi_rad) * std::complex<double>(on_m, any(-0.15, 0.15));
    const double psi_rad = beside.psi_rad + any(-1.5, 1.5) + 2 * kPi * std::round(any(-3, 3));
    run_.locate({hoist_m.real(), hoist_m.imag(), psi_rad});
    // Never backward, no more than half a metre ahead, never past the end of the leg.
    const bool end_seen = s_m_ + 0.5 >= end_m;
    s_m_ = line_.nearest(hoist_m, s_m_, end_seen ? end_m : s_m_ + 0.5, leg_);
    const Line::At at = line_.at(s_m_, leg_);
    EXPECT_NEAR(run_.left_m(), line_.length_m() - s_m_, kNear_m);
    EXPECT_NEAR(run_.progress_norm(), s_m_ / line_.length_m(), kNear_m);
    EXPECT_NEAR(run_.cross_m(), Line::left_m(hoist_m, at), kNear_m);
    EXPECT_NEAR(wrapped(run_.heading_error_rad() - (psi_rad - at.psi_rad)), 0, kNear_m * 5);
    EXPECT_LE(std::fabs(run_.heading_error_rad()), kPi + 1e-9);
    if (run_.has_corners()) {
      EXPECT_NEAR(wrapped(run_.corner_rad() - (line_.heading_behind_rad(leg_) - psi_rad)), 0, kNear_m);
      EXPECT_LE(std::fabs(run_.corner_rad()), kPi + 1e-9);
    }
    // A place that half a metre held back says nothing about the rest of the leg.
    const double past_m = Line::ahead_m(hoist_m, at);
    if (end_seen || past_m < kNear_m) {
      EXPECT_NEAR(run_.leg_left_m(), end_m - s_m_ - std::fmax(past_m, 0.0), 2 * kNear_m);
    }
    curves(at, end_m);
  }
  void curves(const Line::At& at, double end_m) {
    const double begin_m = end_m - line_.leg_m();
    const double from_m = any(-0.3, 0.1), kind = any(0, 1), over_m = kind < 0.2 ? 0 : (kind < 0.4 ? any(0, 0.0009) : any(0.0021, 0.6));
    const double first_m = std::fmin(std::fmax(s_m_ + from_m, begin_m), end_m);
    const double last_m = std::fmin(std::fmax(s_m_ + from_m + over_m, begin_m), end_m);
    const double way_m = last_m - first_m, told_per_m = run_.curvature_ahead(from_m, from_m + over_m);
    if (way_m < 0.0009) {
      EXPECT_NEAR(told_per_m, at.kappa_per_m, 1e-9) << "too short for a mean";
    } else if (way_m > 0.0021) {
      EXPECT_NEAR(told_per_m * way_m, line_.at(last_m, leg_).psi_rad - line_.at(first_m, leg_).psi_rad, 5 * kNear_m);
    }
    // At most this turn rate, and 93 % of the outer wheel's top speed; the next curve is slowed for as late as the deceleration allows.
    const double yaw_rad_s = any(0.05, 0.8), slow_m_s2 = any(0.05, 0.4), late_m = any(-0.05, 0.2), half_m = params_.track_width_m / 2;
    const WheelRoom room{params_};
    const auto most_m_s = [&](double kappa_per_m) {
      const double curve = std::fabs(kappa_per_m), wheel_m_s = 0.93 * room.speed_left_m_s(0) / (1 + curve * half_m);
      return curve > 0 ? std::fmin(wheel_m_s, yaw_rad_s / curve) : wheel_m_s;
    };
    const double next_m_s = most_m_s(at.next_kappa_per_m), rest_m = std::fmax(at.rest_m - late_m, 0.0);
    const double most = std::fmin(most_m_s(at.kappa_per_m), std::sqrt(next_m_s * next_m_s + 2 * slow_m_s2 * rest_m));
    EXPECT_NEAR(run_.curve_speed(yaw_rad_s, room, slow_m_s2, late_m), most, 1e-5);
  }

  /// The place stays a micrometre before the end of its leg.
  static constexpr double kNear_m = 3e-6;

  std::mt19937 random_;
  Pose<double> begin_;
  Line line_;
  GuidedRun run_;
  contract::Params params_;
  std::uint32_t leg_ = 0;
  double s_m_ = 0;
};

TEST(GuidedRun, KnowsItsPlaceAndTheCurvesAheadOnEveryFigure) {
  std::uint32_t seed = 0;
  for (const GuidedPath& path : kFigures)
    for (int n = 0; n < 3; ++n) {
      SCOPED_TRACE(testing::Message() << contract::find_exercise(path.shape)->name << ' ' << path.size_m << ' ' << path.radius_m
                                      << ", seed " << seed);
      Walk(path, seed++).all();
      if (HasFailure()) return;
    }
}

TEST(GuidedRun, WithoutAnExerciseNothingIsDoneAndAfterItsEndAllOfIt) {
  GuidedRun run;
  EXPECT_EQ(run.progress_norm(), 0);
  EXPECT_EQ(run.left_m(), 0);
  run.load(kFigures[0]);
  run.begin({}, 1);
  EXPECT_EQ(run.progress_norm(), 0);
  run.end(GuidedEnd::finished);
  run.end(GuidedEnd::stopped);
  EXPECT_EQ(run.ended(), GuidedEnd::finished) << "the first reason counts";
  EXPECT_EQ(run.progress_norm(), 1);
  EXPECT_EQ(run.left_m(), 0);
}

// Shown as waiting from below half the speed until three quarters of it, and only while the hand holds.
TEST(GuidedRun, WaitingIsShownWithHysteresis) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(0, 1);
  GuidedRun run;
  run.load(kFigures[0]);
  run.begin({}, 1);
  run.phase = GuidedPhase::following;
  bool shown = false;
  double share = 1;
  for (int i = 0; i < 2000; ++i) {
    share = std::fmin(std::fmax(share + (any(random) - 0.5) * 0.4, 0), 1);
    const bool drives = any(random) < 0.9;
    shown = drives && (share < 0.5 || (shown && share < 0.75));
    run.slow_down(share, drives);
    ASSERT_EQ(run.share_norm(), share);
    ASSERT_EQ(run.held_back(), drives && share < 1);
    ASSERT_EQ(run.told_phase(), shown ? GuidedPhase::for_patient : GuidedPhase::following) << share;
  }
}

/// On the mark 5, interrupted this far along its line. The patient lagged.
GuidedRun interrupted(const GuidedPath& path, double at_m, GuidedEnd end = GuidedEnd::asked) {
  GuidedRun run;
  run.load(path);
  run.begin({}, 5);
  for (double x_m = 0; x_m < at_m; x_m += 0.4) run.locate({x_m, 0, 0});
  run.locate({at_m, 0, 0});
  run.phase = GuidedPhase::following;
  run.slow_down(0.2, true);
  run.end(end);
  run.phase = GuidedPhase::ending;
  return run;
}

TEST(GuidedRun, OnlyTheSameFigureOnTheSameMarkContinues) {
  const GuidedPath path{{GuidedShape::square, false, 2.0, 0.5}, 0.3, 2};
  const GuidedRun run = interrupted(path, 0.3);
  EXPECT_TRUE(run.continues(path, 5));
  EXPECT_FALSE(run.continues(path, 6));
  GuidedPath other = path;
  other.speed_m_s = 0.1;
  EXPECT_TRUE(run.continues(other, 5)) << "at another speed";
  for (const GuidedPath& wish :
       {GuidedPath{{GuidedShape::eight, false, 2.0, 0.5}, 0.3, 2}, GuidedPath{{GuidedShape::square, true, 2.0, 0.5}, 0.3, 2},
        GuidedPath{{GuidedShape::square, false, 2.1, 0.5}, 0.3, 2}, GuidedPath{{GuidedShape::square, false, 2.0, 0.6}, 0.3, 2},
        GuidedPath{{GuidedShape::square, false, 2.0, 0.5}, 0.3, 1}})
    EXPECT_FALSE(run.continues(wish, 5));
  EXPECT_FALSE(interrupted(path, 0.3, GuidedEnd::finished).continues(path, 5)) << "it is over";
  GuidedRun never;
  never.load(path);
  EXPECT_FALSE(never.continues(path, 0)) << "it never began";
}

TEST(GuidedRun, WhatContinuesKeepsItsPlaceAndNothingOfTheLag) {
  GuidedPath path{{GuidedShape::straight, false, 3.0, 0}, 0.3, 1};
  GuidedRun run = interrupted(path, 1.0);
  EXPECT_EQ(run.told_phase(), GuidedPhase::for_patient);
  EXPECT_FALSE(run.loaded());
  path.speed_m_s = 0.1;
  run.go_on(path);
  EXPECT_TRUE(run.loaded());
  EXPECT_EQ(run.ended(), GuidedEnd::none);
  run.begin({1.0, 0.05, 0.1}, 5);
  EXPECT_FALSE(run.loaded());
  EXPECT_EQ(run.told_phase(), GuidedPhase::waiting);
  EXPECT_EQ(run.share_norm(), 1);
  EXPECT_FALSE(run.held_back());
  EXPECT_EQ(run.wish().speed_m_s, 0.1);
  run.locate({1.0, 0.05, 0.1});
  EXPECT_NEAR(run.left_m(), 2.0, 1e-9);
  EXPECT_NEAR(run.cross_m(), 0.05, 1e-9) << "the line stays where it was";
  EXPECT_NEAR(run.heading_error_rad(), 0.1, 1e-9);
  // A refused request leaves nothing to begin.
  run.go_on(path);
  run.unload();
  EXPECT_FALSE(run.loaded());
}

// A corner counts as reached 8 mm before it.
TEST(GuidedRun, OneInterruptedInACornerTurnsNext) {
  for (const bool corner : {true, false})
    for (const double before_m : {0.0, 0.007, 0.009, 0.6}) {
      SCOPED_TRACE(before_m);
      const GuidedPath path =
          corner ? GuidedPath{{GuidedShape::square, false, 1.2, 0}, 0.3, 1} : GuidedPath{{GuidedShape::straight, false, 1.2, 0}, 0.3, 1};
      GuidedRun run = interrupted(path, 1.2 - before_m);
      run.go_on(path);
      run.begin({1.2 - before_m, 0, 0}, 5);
      EXPECT_EQ(run.phase, corner && before_m < 0.008 ? GuidedPhase::turning : GuidedPhase::waiting);
    }
}

}  // namespace
}  // namespace hoist::core::test::figure
