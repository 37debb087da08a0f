// H15: the patient falls, or hangs at the stop. Judged on the lean of the harness, the mean of both struts against the chassis: a turn
// moves the struts against each other and leaves the mean.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class FallDetected {
 public:
  static constexpr contract::Fault kFault = contract::Fault::fall_detected;

  bool check(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    const StrutAngles<double> struts = sensed.relative();
    const double alpha_rad = (struts.alpha_left_rad + struts.alpha_right_rad) / 2;
    const double beta_rad = (struts.beta_left_rad + struts.beta_right_rad) / 2;
    const double square = alpha_rad * alpha_rad + beta_rad * beta_rad;
    const auto beyond = [square](double limit_rad) { return square > limit_rad * limit_rad; };
    resting_s_ = beyond(view.params.fall_static_tilt_rad) ? resting_s_ + view.dt_s : 0;
    if (view.mode == contract::Mode::protective_stop) {
      // Nothing new can trip here, and what tripped lasts until the patient stands again.
      return view.has(kFault) && beyond(view.params.fall_tilt_rad);
    }
    if (!view.moving) return false;
    if (resting_s_ > view.params.fall_static_s - view.dt_s / 2) return true;
    if (!beyond(view.params.fall_tilt_rad)) return false;
    const double alpha_rate =
        (sensed.left_strut.alpha_rate_rad_s() + sensed.right_strut.alpha_rate_rad_s()) / 2 - sensed.base.alpha_rate_rad_s();
    const double beta_rate =
        (sensed.left_strut.beta_rate_rad_s() + sensed.right_strut.beta_rate_rad_s()) / 2 - sensed.base.beta_rate_rad_s();
    // d|tilt|/dt times |tilt|: outward is positive.
    return alpha_rad * alpha_rate + beta_rad * beta_rate > view.params.fall_rate_rad_s * std::sqrt(square);
  }

 private:
  double resting_s_ = 0;
};

}  // namespace hoist::core
