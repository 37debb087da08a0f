// H16: the patient hangs in the harness and is dragged along. A hanging patient leans, and the lean keeps the hoist
// going.
//
// Two rules. Leaning: past hang_tilt_rad for hang_tilt_s, in every motion. Dragged: the hoist rolls faster than
// hang_speed_m_s and the harness has not swung sideways by hang_sway_m for hang_still_s; a walking patient sways twice
// in every stride, and comes back from where it swung within a second. In REMOTE and GUIDED the hoist may be empty, and
// an empty harness does not sway: there the second rule also needs, for the last second, a lean that an empty harness
// never shows. A hoist that GUIDED slows for a lagging patient counts as rolling at any speed, and while it stands for
// the patient no sway counts as a step, so that the wait ends in this alarm. R1 and a high alarm, 2 s after it begins;
// the budget is 2.6 s.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class PatientHanging {
 public:
  static constexpr contract::Fault kFault = contract::Fault::patient_hanging;

  bool check(const MonitorView& view) noexcept {
    const contract::Params& p = view.params;
    const law::StrutAngles<double> struts = view.sensed.relative();
    const double alpha_rad = (struts.alpha_left_rad + struts.alpha_right_rad) / 2;
    const double beta_rad = (struts.beta_left_rad + struts.beta_right_rad) / 2;
    const double square = alpha_rad * alpha_rad + beta_rad * beta_rad;
    const auto beyond = [square](double limit_rad) { return !(square <= limit_rad * limit_rad); };
    // Angles that are not fresh are no evidence either way; the silent sensor stops the hoist as such.
    const bool known = !view.sensed.tilts_stale();

    const double tilt_rad = threshold<kFault, "tilt">(p.hang_tilt_rad);
    leaning_s_ = view.moving && known && beyond(tilt_rad) ? leaning_s_ + view.dt_s : 0;

    const bool waits = view.held_back && view.sensed.odometry.standing_still;
    const double sway_m = threshold<kFault, "sway", Laxer::lower>(p.hang_sway_m);
    // Who is waited for may go on from where the wait began.
    const bool stepped = known && swings(p.strut_length_m * beta_rad, sway_m, waits ? 0.0 : view.dt_s);
    const bool rolling = view.held_back || !(std::fabs(view.sensed.odometry.speed_m_s) <= threshold<kFault, "speed">(p.hang_speed_m_s));
    const bool loaded = view.mode == contract::Mode::user || beyond(threshold<kFault, "load">(kLoaded_rad));
    const bool drawn = view.moving && known && ((rolling && !stepped) || waits);
    drawn_s_ = drawn ? drawn_s_ + view.dt_s : 0;
    loaded_s_ = drawn && loaded ? loaded_s_ + view.dt_s : 0;

    // The alarm stays until the patient has been upright on a standing hoist for a while: long enough to be read. Who stands stooped is upright
    // at the neutral that was set.
    const double off_neutral_rad = alpha_rad - p.neutral_lean_m / p.strut_length_m;
    const double near_rad = threshold<kFault, "near_neutral">(kNearNeutral_rad);
    const bool near_neutral = off_neutral_rad * off_neutral_rad + beta_rad * beta_rad <= near_rad * near_rad;
    upright_s_ = view.moving || !known || (beyond(tilt_rad * kUprightShare) && !near_neutral) ? 0 : upright_s_ + view.dt_s;
    if (view.has(kFault) && upright_s_ < kShown_s) return true;
    const double half_s = view.dt_s / 2;
    const bool dragged =
        drawn_s_ > hold<kFault, "still_time">(p.hang_still_s) - half_s && loaded_s_ > hold<kFault, "load_time">(kLoaded_s) - half_s;
    return leaning_s_ > hold<kFault, "tilt_time">(p.hang_tilt_s) - half_s || dragged;
  }

 private:
  static constexpr double kUprightShare = 0.5;
  static constexpr double kNearNeutral_rad = 0.0349;  // 2 degrees: sway of who stands
  // 3 degrees. Springs of 300 N/m hold an empty bar of 3 kg (assumed) within 0.4 degrees at 0.5 m/s2, and the zeros are calibrated; feet
  // that drag with 13 N lean it farther.
  static constexpr double kLoaded_rad = 0.0524;
  static constexpr double kLoaded_s = 1.0;  // an edge that the wheels cross tips an empty bar for a moment
  // Half a stride at 0.1 m/s takes 1.1 s, of who shuffles up to 1.4 s (firmware/sim/PATIENTS.md: 0.42 + 0.5 v hertz); a sine goes 0.78 of its
  // width in the middle 0.8 s of these. DECISIONS.md, 160.
  static constexpr double kSwing_s = 0.8;
  static constexpr double kShown_s = 5.0;

  /// True in the step in which the harness has swung sideways by `least_m` within kSwing_s, and turned since the last such swing: once in each half
  /// of a stride. What takes longer is a drift: the filter, slow to trust gravity, glides back to the middle after the last step.
  [[nodiscard]] bool swings(double side_m, double least_m, double dt_s) noexcept {
    part_s_ += dt_s;
    if (part_s_ > hold<kFault, "swing_time">(kSwing_s) / kParts - dt_s / 2) {
      part_s_ = 0;
      part_ = (part_ + 1) % kParts;
      parts_[part_] = {side_m, side_m};
    }
    parts_[part_].include({side_m, side_m});
    Span all = parts_[part_];
    for (const Span& part : parts_) all.include(part);
    // A swing that just misses `least_m` is a turn, too, or the wide one after it would count only on its way back.
    const double on_m = to_right_ ? side_m : -side_m;
    farthest_m_ = std::max(farthest_m_, on_m);
    turned_ = turned_ || farthest_m_ - on_m >= least_m / 2;
    const bool right = side_m - all.left_m >= least_m && (!to_right_ || turned_);
    const bool left = all.right_m - side_m >= least_m && (to_right_ || turned_);
    if (!right && !left) return false;
    to_right_ = right;
    turned_ = false;
    farthest_m_ = right ? side_m : -side_m;
    parts_.fill({side_m, side_m});
    part_s_ = 0;
    return true;
  }

  double leaning_s_ = 0, drawn_s_ = 0, loaded_s_ = 0, upright_s_ = 0;
  // How far left and right the harness was in each tenth of a second of the last kSwing_s.
  struct Span {
    double left_m = 0, right_m = 0;
    void include(const Span& other) noexcept {
      left_m = std::min(left_m, other.left_m);
      right_m = std::max(right_m, other.right_m);
    }
  };
  static constexpr std::size_t kParts = 8;
  std::array<Span, kParts> parts_{};
  std::size_t part_ = 0;
  double part_s_ = 0;
  // Of the last swing: which way, how far it went on, and whether it has turned since.
  bool to_right_ = true, turned_ = true;
  double farthest_m_ = 0;
};

}  // namespace hoist::core
