// H15: the patient falls, or lies in the stop. Judged on the lean of the harness, the mean of both struts against the chassis: a turn
// moves the struts against each other and leaves the mean.
//
// fall_tilt_rad with fall_rate_rad_s outward, at once; fall_static_tilt_rad for fall_static_s. R2 within 30 ms; the servo goes on holding.
// Sideways, where a lean asks for nothing, a quick one counts kAside_norm times.
//
// A hoist that brakes or speeds up swings the body on its springs: m a / k, 7 degrees for 75 kg at 0.5 m/s2, 11 at 0.8. That is no fall, and
// braking harder would only throw the body farther. So while the hoist itself changes its speed by kOwn_m_s2 or more, and for 0.3 s after,
// a quick lean in the direction in which that throws the body is left to the resting rule where it brakes, and a resting lean that began
// then may last kThrown_s longer, which is how long the swing of a heavy body stays out there. Where it speeds up, a body that falls back
// would not even be braked for: there the quick lean must go kThrownBack_rad farther. Less than kOwnChange_m_s since the change began throws no
// body; the end of each creeping motion is that. In a protective stop only the resting rule is left, kThrown_s longer: the servo holds already,
// but the alarm says what has happened, and its release waits until the patient stands. Angles that no longer come tell nothing of the patient.
//
// On standby straps are fastened and struts moved by hand, so a lean alone is no fall. But a body in the stops pushes the hoist with more than its
// brakes hold: 79 kg rolled it to 0.5 m/s within 6 s, 96 kg to 1.3 (simulated; brakes 178 N). A resting lean on wheels that turn faster than
// kUnheld_m_s is therefore a fall there, too, and the servo, which gives more than twice as much, holds the patient.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class FallDetected {
 public:
  static constexpr contract::Fault kFault = contract::Fault::fall_detected;

  bool check(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    const law::StrutAngles<double> struts = sensed.relative();
    const double alpha_rad = (struts.alpha_left_rad + struts.alpha_right_rad) / 2;
    const double beta_rad = (struts.beta_left_rad + struts.beta_right_rad) / 2;
    const double square = alpha_rad * alpha_rad + beta_rad * beta_rad;
    // Written so that NaN is beyond every limit.
    const auto beyond = [square](double limit_rad) { return !(square <= limit_rad * limit_rad); };
    const double tilt_rad = threshold<kFault, "tilt">(view.params.fall_tilt_rad);
    const double aside_rad = threshold<kFault, "aside", Laxer::lower>(kAside_norm) * beta_rad;
    const double quick_square = alpha_rad * alpha_rad + aside_rad * aside_rad;
    const auto quickly_beyond = [quick_square](double limit_rad) { return !(quick_square <= limit_rad * limit_rad); };
    resting_s_ = beyond(threshold<kFault, "static_tilt">(view.params.fall_static_tilt_rad)) ? resting_s_ + view.dt_s : 0;
    if (resting_s_ == 0) thrown_out_ = false;
    note_own_acceleration(view);
    const bool stopped = view.mode == contract::Mode::protective_stop;
    stopped_s_ = stopped ? stopped_s_ + view.dt_s : 0;
    if (stopped) {
      if (sensed.tilts_lost()) return false;
      // The body that the ramp throws comes back; one that does not has fallen. What tripped lasts until the patient stands again.
      return (view.has(kFault) && quickly_beyond(tilt_rad)) ||
             rests_for(view, std::min(resting_s_, stopped_s_), hold<kFault, "thrown_time">(kThrown_s));
    }
    if (!view.moving) return rolls_unheld(view) && rests_for(view, resting_s_, 0);
    const bool thrown_there = thrown(alpha_rad, beta_rad);
    // Thrown along the way it goes, or went until it stood: it brakes.
    const bool brakes = command_m_s_ == 0 || forward_ == (command_m_s_ > 0);
    if (thrown_there && brakes && resting_s_ > 0) thrown_out_ = true;
    const double longer_s = thrown_out_ ? hold<kFault, "thrown_time">(kThrown_s) : 0;
    if (rests_for(view, resting_s_, longer_s)) return true;
    if (thrown_there && brakes) return false;
    if (!quickly_beyond(thrown_there ? tilt_rad + threshold<kFault, "thrown_back">(kThrownBack_rad) : tilt_rad)) return false;
    const double alpha_rate =
        (sensed.left_strut.alpha_rate_rad_s() + sensed.right_strut.alpha_rate_rad_s()) / 2 - sensed.base.alpha_rate_rad_s();
    const double beta_rate =
        (sensed.left_strut.beta_rate_rad_s() + sensed.right_strut.beta_rate_rad_s()) / 2 - sensed.base.beta_rate_rad_s();
    // d|tilt|/dt times |tilt|: outward is positive.
    return !(alpha_rad * alpha_rate + beta_rad * beta_rate <= threshold<kFault, "rate">(view.params.fall_rate_rad_s) * std::sqrt(square));
  }

 private:
  static constexpr double kOwn_m_s2 = 0.4;  // below every stop ramp, above what walking asks for
  // A body of 75 kg on 300 N/m is thrown by 2 cm, 1.2 degrees.
  static constexpr double kOwnChange_m_s = 0.04;
  static constexpr std::uint8_t kSwingTicks = 30;  // a quarter of a swing of 75 kg on 300 N/m, twice as long for heavier ones with legs

  // The tilt filter shows a sideways fall up to 20 ms later than one along the way: half a degree (simulated).
  static constexpr double kAside_norm = 1.05;
  // 1.5 degrees beyond fall_tilt_rad, as far as 120 kg are thrown (simulated): earlier than the resting lean and its 0.1 s.
  static constexpr double kThrownBack_rad = 0.0262;
  // As for every other rule of a hoist that rolls.
  static constexpr double kUnheld_m_s = 0.1;
  // 97 kg stopped from 0.5 m/s swing to 14 degrees and stay beyond 13 for about 0.4 s (simulated).
  static constexpr double kThrown_s = 0.5;

  [[nodiscard]] static bool rests_for(const MonitorView& view, double resting_s, double longer_s) noexcept {
    return resting_s > hold<kFault, "static_time">(view.params.fall_static_s) + longer_s - view.dt_s / 2;
  }

  [[nodiscard]] static bool rolls_unheld(const MonitorView& view) noexcept {
    const Odometry& odometry = view.sensed.odometry;
    const double unheld_m_s = threshold<kFault, "unheld">(kUnheld_m_s);
    return view.mode == contract::Mode::standby && !view.sensed.drives_lost() &&
           !(std::max(std::fabs(odometry.wheel_left_m_s), std::fabs(odometry.wheel_right_m_s)) <= unheld_m_s);
  }

  void note_own_acceleration(const MonitorView& view) noexcept {
    const double command_m_s = (view.left_command_m_s + view.right_command_m_s) / 2;
    const double step_m_s = command_m_s - std::exchange(command_m_s_, command_m_s);
    change_m_s_ = step_m_s * change_m_s_ > 0 ? change_m_s_ + step_m_s : step_m_s;
    if (std::fabs(step_m_s / view.dt_s) >= threshold<kFault, "own_acceleration", Laxer::lower>(kOwn_m_s2) &&
        std::fabs(change_m_s_) >= threshold<kFault, "own_change", Laxer::lower>(kOwnChange_m_s)) {
      forward_ = step_m_s < 0;
      swing_ticks_ = hold<kFault, "swing">(kSwingTicks);
    } else if (swing_ticks_ > 0) {
      --swing_ticks_;
    }
  }
  /// Whether the hoist's own change of speed throws the body there: along the way, and not mainly to a side.
  [[nodiscard]] bool thrown(double alpha_rad, double beta_rad) const noexcept {
    return swing_ticks_ > 0 && (alpha_rad > 0) == forward_ && std::fabs(beta_rad) <= std::fabs(alpha_rad);
  }

  double resting_s_ = 0, stopped_s_ = 0, command_m_s_ = 0;
  double change_m_s_ = 0;  // of the hoist's own speed, since it changes this way
  std::uint8_t swing_ticks_ = 0;
  bool forward_ = false, thrown_out_ = false;  // thrown_out_: the resting lean is still the one that the brake began
};

}  // namespace hoist::core
