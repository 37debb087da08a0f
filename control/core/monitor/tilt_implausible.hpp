// H7: angles that this mechanism cannot have.
//
// tilt_rad_max and tilt_rate_rad_s_max at once: R2 within 100 ms. strut_twist_rad_max and strut_apart_rad_max for 100 ms. A strut that hangs
// still beside one that swings (still_strut.hpp): R2 within 8 s of walking.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"
#include "control/core/monitor/still_strut.hpp"

namespace hoist::core {

class TiltImplausible {
 public:
  static constexpr contract::Fault kFault = contract::Fault::tilt_implausible;

  bool check(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    const law::StrutAngles<double> struts = sensed.relative();
    // The stop of the ball joints is at 15 degrees against the chassis.
    const double angle_rad = threshold<kFault, "angle">(view.params.tilt_rad_max);
    const bool steep = beyond(struts.alpha_left_rad, angle_rad) || beyond(struts.alpha_right_rad, angle_rad) ||
                       beyond(struts.beta_left_rad, angle_rad) || beyond(struts.beta_right_rad, angle_rad) ||
                       beyond(sensed.base.alpha_rad(), angle_rad) || beyond(sensed.base.beta_rad(), angle_rad);
    const double rate_rad_s = threshold<kFault, "rate">(view.params.tilt_rate_rad_s_max);
    const bool fast =
        too_fast(sensed.left_strut, rate_rad_s) || too_fast(sensed.right_strut, rate_rad_s) || too_fast(sensed.base, rate_rad_s);
    const bool apart = beyond(struts.beta_left_rad - struts.beta_right_rad, threshold<kFault, "apart">(view.params.strut_apart_rad_max));
    const bool twist = beyond(struts.alpha_left_rad - struts.alpha_right_rad, threshold<kFault, "twist">(view.params.strut_twist_rad_max));
    const bool stay_apart = apart_.step(apart, hold<kFault, "apart_time">(kLastsTicks));
    const bool stay_twisted = twisted_.step(twist, hold<kFault, "twist_time">(kLastsTicks));
    const Strut still = still_.step(view);
    const bool beyond_limits = steep || fast || stay_apart;
    code_ = beyond_limits           ? std::uint16_t{0}
            : stay_twisted          ? kTwisted
            : still == Strut::left  ? kLeftStill
            : still == Strut::right ? kRightStill
                                    : std::uint16_t{0};
    if (view.mode == contract::Mode::init) return false;
    // A falling patient hits the mechanical stop, and every accelerometer shows the impact. The fall alarm covers that;
    // a sensor that is wrong is still wrong after the acknowledgement.
    if (view.has(contract::Fault::fall_detected) && !view.has(kFault)) return false;
    return beyond_limits || stay_twisted || still != Strut::none;
  }
  /// Its detail code (HOIST_DETAIL): a twist alone is within what both struts can do, and a patient turns that far; a strap comes off.
  [[nodiscard]] std::uint16_t code() const noexcept { return code_; }

 private:
  // The top bar is rigid: both struts lean sideways alike, and twist no farther than a pelvis turns. For 100 ms, because the three sensors
  // do not sample together, and a step shakes each its own way. DECISIONS.md, 170.
  static constexpr std::uint8_t kLastsTicks = 10;
  static constexpr std::uint16_t kTwisted = 1, kLeftStill = 2, kRightStill = 3;

  [[nodiscard]] static bool beyond(double angle, double limit) noexcept { return !(std::fabs(angle) <= limit); }
  [[nodiscard]] static bool too_fast(const TiltSensor& tilt, double limit_rad_s) noexcept {
    return tilt.fresh().now() && (beyond(tilt.alpha_rate_rad_s(), limit_rad_s) || beyond(tilt.beta_rate_rad_s(), limit_rad_s));
  }

  std::uint16_t code_ = 0;
  Lasting apart_, twisted_;
  StillStrut still_;
};

}  // namespace hoist::core
