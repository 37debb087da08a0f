// H7, part of tilt_implausible: one strut hangs still beside one that swings.
//
// Both struts carry one rigid bar, so with every step they swing sideways alike. A strut whose strap is cut, or that has come off its joint,
// springs upright: mean lean and turn then tell half of what the patient does, and a fall shows as half of one. In every motion faster than 0.1
// m/s: one whose mean square is below a tenth of its twin's, which swings by 0.5 degrees or more, for 1.5 s. R2 within 8 s of walking; a patient
// who does not sway shows nothing.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/law/low_pass.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

enum class Strut : std::uint8_t { none, left, right };

class StillStrut {
 public:
  static constexpr contract::Fault kFault = contract::Fault::tilt_implausible;

  /// One step: the strut that has hung still for long enough.
  Strut step(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    const bool rolling = view.moving && !(std::fabs(sensed.odometry.speed_m_s) <= threshold<kFault, "still_rolling">(kRolling_m_s));
    const law::StrutAngles<double> struts = sensed.relative();
    if (!rolling || sensed.tilts_stale()) {
      left_.begin(struts.beta_left_rad);
      right_.begin(struts.beta_right_rad);
    }
    left_.step(struts.beta_left_rad, view.dt_s);
    right_.step(struts.beta_right_rad, view.dt_s);
    const double swing_rad = threshold<kFault, "still_swing">(kSwing_rad);
    const std::uint16_t ticks = hold<kFault, "still_time">(kTicks);
    const bool left = left_still_.step(left_.still_beside(right_, swing_rad), ticks);
    const bool right = right_still_.step(right_.still_beside(left_, swing_rad), ticks);
    return left ? Strut::left : right ? Strut::right : Strut::none;
  }

 private:
  struct Swing {
    law::LowPassState<double> mean_rad{}, square_rad2{};
    void begin(double beta_rad) noexcept {
      mean_rad = {beta_rad};
      square_rad2 = {};
    }
    void step(double beta_rad, double dt_s) noexcept {
      const double out_rad = beta_rad - law::low_pass_step(kMean_s, mean_rad, beta_rad, dt_s);
      law::low_pass_step(kSquare_s, square_rad2, out_rad * out_rad, dt_s);
    }
    [[nodiscard]] bool still_beside(const Swing& twin, double swing_rad) const noexcept {
      return twin.square_rad2.value > swing_rad * swing_rad &&
             square_rad2.value < threshold<kFault, "still_share", Laxer::lower>(kShare) * twin.square_rad2.value;
    }
  };

  static constexpr double kRolling_m_s = 0.1;
  static constexpr double kMean_s = 2.0, kSquare_s = 1.0;  // a stride takes 0.9 to 1.7 s
  static constexpr double kSwing_rad = 0.0087266;          // 0.5 degrees
  // Of the mean squares: a third of the swing. DECISIONS.md, 159.
  static constexpr double kShare = 0.1;
  static constexpr std::uint16_t kTicks = 150;

  Swing left_, right_;
  Lasting left_still_, right_still_;
};

}  // namespace hoist::core
