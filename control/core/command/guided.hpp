// An exercise under way: the figure, placed on the floor where the hoist stood at its begin, and how far along it the
// hoist is.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "control/contract/guided_path.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/path_follower.hpp"
#include "control/core/output/wheel_room.hpp"

namespace hoist::core {

/// Values of the live value guided_phase. `for_patient` is shown only: internally the phase stays following or turning.
enum class GuidedPhase : std::uint8_t { none, waiting, following, turning, ending, for_patient };

class GuidedRun {
 public:
  /// Takes a checked exercise; nothing of an earlier one remains.
  void load(const contract::GuidedPath& wish) noexcept {
    *this = GuidedRun{};
    wish_ = wish;
    figure_ = contract::figure_of(wish);
    // A square with sharp corners has one leg per side and a turn on the spot after each; any other figure is one leg.
    corners_ = wish.shape == contract::GuidedShape::square && wish.radius_m == 0;
    leg_m_ = corners_ ? wish.size_m : figure_.length_m() * wish.laps;
    legs_ = corners_ ? 4 * wish.laps : 1;
    loaded_ = true;
  }
  /// The same exercise on the same start mark, interrupted before its end: continues where the hoist is, at the speed
  /// requested now.
  [[nodiscard]] bool continues(const contract::GuidedPath& wish, std::uint32_t mark) const noexcept {
    return mark_ == mark && phase != GuidedPhase::none && end_ != contract::GuidedEnd::finished && contract::same_figure(wish, wish_);
  }
  void go_on(const contract::GuidedPath& wish) noexcept {
    wish_.speed_m_s = wish.speed_m_s;
    end_ = contract::GuidedEnd::none;
    loaded_ = goes_on_ = true;
  }
  /// The request was refused.
  void unload() noexcept { loaded_ = goes_on_ = false; }
  [[nodiscard]] bool loaded() const noexcept { return loaded_; }

  /// Places the figure at the hoist's pose; an exercise that continues keeps its place.
  void begin(const law::Pose<double>& pose, std::uint32_t mark) noexcept {
    loaded_ = false;
    share_norm_ = 1;
    waits_ = held_back_ = false;
    if (std::exchange(goes_on_, false)) {
      // Interrupted in a corner: its turn comes next.
      phase = corners_ && leg_left_m() <= kArrived_m ? GuidedPhase::turning : GuidedPhase::waiting;
      return;
    }
    mark_ = mark;
    const contract::PathPose start = figure_.pose(0.0);
    const double turn_rad = start.psi_rad - pose.psi_rad;
    cos_ = std::cos(turn_rad);
    sin_ = std::sin(turn_rad);
    turn_rad_ = turn_rad;
    x_m_ = start.x_m - cos_ * pose.x_m + sin_ * pose.y_m;
    y_m_ = start.y_m - sin_ * pose.x_m - cos_ * pose.y_m;
    phase = GuidedPhase::waiting;
  }

  /// Finds the nearest place on the figure, never backward and never past the end of the leg, and how far off it the hoist is.
  void locate(const law::Pose<double>& pose) noexcept {
    const double x_m = x_m_ + cos_ * pose.x_m - sin_ * pose.y_m;
    const double y_m = y_m_ + sin_ * pose.x_m + cos_ * pose.y_m;
    const double left_m = leg_end_m() - s_m_;
    if (left_m > kInside_m) {
      const double reach_m = left_m - kInside_m < contract::kProjectionWindow_m ? left_m - kInside_m : contract::kProjectionWindow_m;
      s_m_ = figure_.project(x_m, y_m, s_m_, reach_m);
    }
    const contract::PathPose at = figure_.pose(s_m_);
    const double cos_psi = std::cos(at.psi_rad), sin_psi = std::sin(at.psi_rad);
    const double off_x_m = x_m - at.x_m, off_y_m = y_m - at.y_m;
    cross_m_ = cos_psi * off_y_m - sin_psi * off_x_m;
    // Beyond the end, where the projection stays, the distance past it is subtracted.
    beyond_m_ = cos_psi * off_x_m + sin_psi * off_y_m;
    heading_rad_ = pose.psi_rad + turn_rad_;
    heading_error_rad_ = std::remainder(heading_rad_ - at.psi_rad, kTurn_rad);
  }

  /// Mean curvature of the figure between two distances ahead, within the leg: a step of the curvature becomes a ramp.
  [[nodiscard]] double curvature_ahead(double from_m, double to_m) const noexcept {
    const double begin_m = inside(s_m_ + from_m), end_m = inside(s_m_ + to_m);
    if (end_m - begin_m < kShortest_m) return figure_.pose(s_m_).kappa_per_m;
    return (figure_.pose(end_m).psi_rad - figure_.pose(begin_m).psi_rad) / (end_m - begin_m);
  }

  /// The fastest speed now at which no curve ahead needs more than this turn rate or more than its share of the outer
  /// wheel; slowing with this deceleration over a distance shortened by `late_m`.
  [[nodiscard]] double curve_speed(double yaw_rate_rad_s, const WheelRoom& room, double deceleration_m_s2, double late_m) const noexcept {
    const auto within = [yaw_rate_rad_s, &room](double kappa_per_m) {
      const double kappa = std::fabs(kappa_per_m), outer_m_s = contract::kGuidedWheelShare_norm * room.curve_speed_m_s(kappa);
      return kappa * outer_m_s > yaw_rate_rad_s ? yaw_rate_rad_s / kappa : outer_m_s;
    };
    const contract::ReferencePath::Ahead ahead = figure_.ahead(s_m_);
    const double here = within(ahead.kappa_per_m);
    // One joint ahead is enough: each piece of every figure is longer than the way to slow down before the next but one.
    const double there = law::approach_speed(std::fmax(ahead.left_m - late_m, 0.0), within(ahead.next_kappa_per_m), deceleration_m_s2);
    return here < there ? here : there;
  }

  /// The heading to turn to at the end of this leg, against the present one; left positive.
  [[nodiscard]] double corner_rad() const noexcept {
    // Just behind the corner the next side has begun.
    return std::remainder(figure_.pose(leg_end_m()).psi_rad - heading_rad_, kTurn_rad);
  }
  void next_leg() noexcept {
    ++leg_;
    s_m_ = leg_begin_m();
  }

  /// The share of its speed that the hoist keeps for a patient who lags; `drives`: hold-to-run is held, so that only
  /// this share slows the hoist.
  void slow_down(double share_norm, bool drives) noexcept {
    share_norm_ = share_norm;
    held_back_ = drives && share_norm < 1;
    // Shown below half the speed, with hysteresis against the rhythm of the patient's steps.
    waits_ = held_back_ && share_norm < (waits_ ? kGoesOn_norm : kWaits_norm);
  }
  [[nodiscard]] double share_norm() const noexcept { return share_norm_; }
  /// Slower than requested, because the patient lags.
  [[nodiscard]] bool held_back() const noexcept { return held_back_; }
  [[nodiscard]] GuidedPhase told_phase() const noexcept { return waits_ ? GuidedPhase::for_patient : phase; }

  [[nodiscard]] const contract::GuidedPath& wish() const noexcept { return wish_; }
  [[nodiscard]] bool has_corners() const noexcept { return corners_; }
  [[nodiscard]] bool last_leg() const noexcept { return leg_ + 1 >= legs_; }
  [[nodiscard]] double leg_left_m() const noexcept { return leg_end_m() - s_m_ - (beyond_m_ > 0 ? beyond_m_ : 0); }
  [[nodiscard]] double cross_m() const noexcept { return cross_m_; }
  [[nodiscard]] double heading_error_rad() const noexcept { return heading_error_rad_; }
  [[nodiscard]] double total_m() const noexcept { return leg_m_ * legs_; }
  [[nodiscard]] double left_m() const noexcept { return end_ == contract::GuidedEnd::finished ? 0.0 : total_m() - s_m_; }
  [[nodiscard]] double progress_norm() const noexcept { return total_m() > 0 ? 1.0 - left_m() / total_m() : 0.0; }

  /// Only the first reason for the end is reported.
  void end(contract::GuidedEnd reason) noexcept {
    if (end_ == contract::GuidedEnd::none) end_ = reason;
  }
  [[nodiscard]] contract::GuidedEnd ended() const noexcept { return end_; }

  /// The end of a leg counts as reached within this distance.
  static constexpr double kArrived_m = 0.008;

  GuidedPhase phase = GuidedPhase::none;

 private:
  static constexpr double kTurn_rad = 6.283185307179586;
  // A place this close before the end still belongs to the leg (the figure's own joint is a thousand times narrower).
  static constexpr double kInside_m = 1e-6;
  static constexpr double kShortest_m = 1e-3;
  static constexpr double kWaits_norm = 0.5, kGoesOn_norm = 0.75;

  [[nodiscard]] double leg_begin_m() const noexcept { return leg_m_ * leg_; }
  [[nodiscard]] double leg_end_m() const noexcept { return leg_m_ * (leg_ + 1.0); }
  [[nodiscard]] double inside(double s_m) const noexcept {
    const double least = leg_begin_m(), most = leg_end_m() - kInside_m;
    return s_m < least ? least : (s_m > most ? most : s_m);
  }

  contract::GuidedPath wish_;
  contract::ReferencePath figure_ = contract::ReferencePath::straight();
  double leg_m_ = 0;
  std::uint32_t legs_ = 0, leg_ = 0;
  bool corners_ = false, loaded_ = false, goes_on_ = false;
  bool held_back_ = false, waits_ = false;
  double share_norm_ = 1;
  std::uint32_t mark_ = 0;                                       // start mark on which it began
  double cos_ = 1, sin_ = 0, turn_rad_ = 0, x_m_ = 0, y_m_ = 0;  // from the floor's frame into the figure's
  double s_m_ = 0, cross_m_ = 0, beyond_m_ = 0, heading_rad_ = 0, heading_error_rad_ = 0;
  contract::GuidedEnd end_ = contract::GuidedEnd::none;
};

}  // namespace hoist::core
