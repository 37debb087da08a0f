// H15: the patient falls, or lies in the stop. Judged on the lean of the harness, the mean of both struts against the chassis: a turn
// moves the struts against each other and leaves the mean.
//
// fall_tilt_rad with fall_rate_rad_s outward, at once; fall_static_tilt_rad for fall_static_s. R2 within 30 ms; the servo goes on holding.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/monitor/monitor.hpp"
#include "control/core/monitor/mutation.hpp"

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
    // Written so that what is no number is beyond every limit.
    const auto beyond = [square](double limit_rad) { return !(square <= limit_rad * limit_rad); };
    const double tilt_rad = threshold<kFault, "tilt">(view.params.fall_tilt_rad);
    resting_s_ = beyond(threshold<kFault, "static_tilt">(view.params.fall_static_tilt_rad)) ? resting_s_ + view.dt_s : 0;
    if (view.mode == contract::Mode::protective_stop) {
      // Nothing new can trip here, and what tripped lasts until the patient stands again.
      return view.has(kFault) && beyond(tilt_rad);
    }
    if (!view.moving) return false;
    if (resting_s_ > hold<kFault, "static_time">(view.params.fall_static_s) - view.dt_s / 2) return true;
    if (!beyond(tilt_rad)) return false;
    const double alpha_rate =
        (sensed.left_strut.alpha_rate_rad_s() + sensed.right_strut.alpha_rate_rad_s()) / 2 - sensed.base.alpha_rate_rad_s();
    const double beta_rate =
        (sensed.left_strut.beta_rate_rad_s() + sensed.right_strut.beta_rate_rad_s()) / 2 - sensed.base.beta_rate_rad_s();
    // d|tilt|/dt times |tilt|: outward is positive.
    return !(alpha_rad * alpha_rate + beta_rad * beta_rate <= threshold<kFault, "rate">(view.params.fall_rate_rad_s) * std::sqrt(square));
  }

 private:
  double resting_s_ = 0;
};

}  // namespace hoist::core
