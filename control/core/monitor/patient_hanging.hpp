// H16: the patient hangs in the harness and is dragged along. A hanging patient leans, and the lean keeps the hoist
// going.
//
// Two rules. Leaning: past hang_tilt_rad for hang_tilt_s, in every motion. Dragged: the hoist rolls faster than
// hang_speed_m_s and the harness has not swung sideways by hang_sway_m for hang_still_s; a walking patient sways twice
// in every stride. In REMOTE and GUIDED the hoist may be empty, and an empty harness does not sway: there the second
// rule also needs a lean that an empty harness never shows. A hoist that GUIDED slows for a lagging patient counts as
// rolling at any speed, and while it stands for the patient no sway counts as a step, so that the wait ends in this
// alarm. R1 and a high alarm, 2 s after it begins; the budget is 2.6 s.
#pragma once
#include <cmath>

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

    const bool stepped = known && swings(p.strut_length_m * beta_rad, threshold<kFault, "sway", Laxer::lower>(p.hang_sway_m));
    const bool rolling = view.held_back || !(std::fabs(view.sensed.odometry.speed_m_s) <= threshold<kFault, "speed">(p.hang_speed_m_s));
    const bool loaded = view.mode == contract::Mode::user || beyond(threshold<kFault, "load">(kLoaded_rad));
    const bool waits = view.held_back && view.sensed.odometry.standing_still;
    const bool drawn = view.moving && known && loaded && ((rolling && !stepped) || waits);
    drawn_s_ = drawn ? drawn_s_ + view.dt_s : 0;

    // The alarm stays until the patient has been upright on a standing hoist for a while: long enough to be read.
    upright_s_ = view.moving || !known || beyond(tilt_rad * kUprightShare) ? 0 : upright_s_ + view.dt_s;
    if (view.has(kFault) && upright_s_ < kShown_s) return true;
    const double half_s = view.dt_s / 2;
    return leaning_s_ > hold<kFault, "tilt_time">(p.hang_tilt_s) - half_s || drawn_s_ > hold<kFault, "still_time">(p.hang_still_s) - half_s;
  }

 private:
  static constexpr double kUprightShare = 0.5;
  // 3 degrees. Springs of 300 N/m hold an empty bar of 3 kg (assumed) within 0.4 degrees at 0.5 m/s2, and the zeros are calibrated; feet
  // that drag with 13 N lean it farther.
  static constexpr double kLoaded_rad = 0.0524;
  static constexpr double kShown_s = 5.0;

  /// True in the step in which the harness has swung back by `least_m` from where it was farthest out: once in each half of a stride. A
  /// slow drift to one side swings but once.
  [[nodiscard]] bool swings(double side_m, double least_m) noexcept {
    const double out_m = to_right_ ? side_m : -side_m;
    if (!(out_m <= farthest_m_)) farthest_m_ = out_m;
    if (farthest_m_ - out_m < least_m) return false;
    to_right_ = !to_right_;
    farthest_m_ = -out_m;
    return true;
  }

  double leaning_s_ = 0, drawn_s_ = 0, upright_s_ = 0;
  double farthest_m_ = 0;  // in the direction of the swing
  bool to_right_ = true;
};

}  // namespace hoist::core
