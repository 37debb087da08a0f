// H6: frames arrive, but the sensor's values are frozen.
//
// Its sample counter is unchanged for 30 ms; its turn rates are equal for 200 ms; on a rolling hoist (0.1 m/s) both struts' angles are equal for
// 300 ms, or one strut glides smoothly for 300 ms while its twin does not. R2 within 500 ms, that of the slowest rule.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class TiltFrozen {
 public:
  static constexpr contract::Fault kFault = contract::Fault::tilt_frozen;

  bool check(const MonitorView& view) noexcept {
    const Estimate& sensed = view.sensed;
    // The sample counter stands: 30 ms of repeated frames.
    const bool counter_stands = stands(sensed.left_strut) || stands(sensed.right_strut) || stands(sensed.base);
    // The counter runs and the angles do not: on a rolling hoist the filters of both struts always move in their last digits.
    const law::StrutAngles<double> now = {sensed.left_strut.alpha_rad(), sensed.right_strut.alpha_rad(), sensed.left_strut.beta_rad(),
                                          sensed.right_strut.beta_rad()};
    const bool same = now.alpha_left_rad == before_.alpha_left_rad && now.alpha_right_rad == before_.alpha_right_rad &&
                      now.beta_left_rad == before_.beta_left_rad && now.beta_right_rad == before_.beta_right_rad;
    const double rolling_m_s = threshold<kFault, "rolling">(kRolling_m_s);
    const bool rolling =
        !(std::fabs(sensed.odometry.wheel_left_m_s) <= rolling_m_s && std::fabs(sensed.odometry.wheel_right_m_s) <= rolling_m_s);
    before_ = now;
    // Without new samples there is nothing to compare; a silent sensor is another fault.
    const bool sampled = sensed.left_strut.fresh().now() && sensed.right_strut.fresh().now();
    const bool constant = constant_.step(same && rolling && sampled, hold<kFault, "both_equal">(kConstantTicks));
    // One chip that repeats its last sample: the filter behind it glides smoothly to where that sample points, for many seconds, while the
    // other strut, on the same rigid bar, keeps changing its course.
    const bool glides =
        rolling && (glides_beside(sensed.left_strut, sensed.right_strut) || glides_beside(sensed.right_strut, sensed.left_strut));
    // Where a sensor sends its rates as measured: three gyroscopes whose last digit never changes.
    const bool same_rates = repeats_rates(sensed.left_strut) || repeats_rates(sensed.right_strut) || repeats_rates(sensed.base);
    return view.mode != contract::Mode::init && (counter_stands || constant || glides || same_rates);
  }

 private:
  static constexpr std::uint8_t kRepeats = 3;         // H6: 30 ms
  static constexpr std::uint8_t kConstantTicks = 30;  // H6: 300 ms
  static constexpr double kRolling_m_s = 0.1;
  // Walking at 0.2 to 0.6 m/s, figure of eight, square and straight: 12 to 30 of 30 samples of a living strut sensor are lively; of a stuck one
  // none from the third sample on, or now and then one while the filter still glides steeply. Each of those asks for more of the twin, so that more
  // than seven are never a stuck chip's (DECISIONS.md, 25).
  static constexpr int kTwinLively = 15;
  static constexpr std::uint8_t kSameRates = 20;  // H6: raw values identical for 20 samples

  [[nodiscard]] static bool stands(const TiltSensor& tilt) noexcept {
    return !tilt.heard().lost() && tilt.repeated_frames() >= hold<kFault, "counter">(kRepeats);
  }

  [[nodiscard]] static bool glides_beside(const TiltSensor& tilt, const TiltSensor& twin) noexcept {
    const int own = tilt.lively_samples(), other = twin.lively_samples();
    return tilt.fresh().now() && twin.fresh().now() && own >= 0 && other >= threshold<kFault, "twin">(kTwinLively) + 2 * own;
  }
  [[nodiscard]] static bool repeats_rates(const TiltSensor& tilt) noexcept {
    return tilt.has(tilt_status::kValid) && !tilt.heard().lost() && tilt.same_rates() >= hold<kFault, "rates">(kSameRates);
  }

  law::StrutAngles<double> before_;
  Lasting constant_;
};

}  // namespace hoist::core
