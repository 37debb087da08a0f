// H6: frames keep coming, but the sensor behind them stands still.
#pragma once
#include <cmath>
#include <cstdint>

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
    const StrutAngles<double> now = {sensed.left_strut.alpha_rad(), sensed.right_strut.alpha_rad(), sensed.left_strut.beta_rad(),
                                     sensed.right_strut.beta_rad()};
    const bool same = now.alpha_left_rad == before_.alpha_left_rad && now.alpha_right_rad == before_.alpha_right_rad &&
                      now.beta_left_rad == before_.beta_left_rad && now.beta_right_rad == before_.beta_right_rad;
    const bool rolling =
        std::fabs(sensed.odometry.wheel_left_m_s) > kRolling_m_s || std::fabs(sensed.odometry.wheel_right_m_s) > kRolling_m_s;
    before_ = now;
    // Without new samples there is nothing to compare; a silent sensor is another monitor's matter.
    const bool sampled = sensed.left_strut.fresh().now() && sensed.right_strut.fresh().now();
    constant_ticks_ = !(same && rolling && sampled)
                          ? std::uint8_t{0}
                          : static_cast<std::uint8_t>(constant_ticks_ < kConstantTicks ? constant_ticks_ + 1 : kConstantTicks);
    return view.mode != contract::Mode::init && (counter_stands || constant_ticks_ == kConstantTicks);
  }

 private:
  static constexpr std::uint8_t kRepeats = 3;         // H6: 30 ms
  static constexpr std::uint8_t kConstantTicks = 30;  // H6: 300 ms
  static constexpr double kRolling_m_s = 0.1;

  [[nodiscard]] static bool stands(const TiltSensor& tilt) noexcept { return !tilt.heard().lost() && tilt.repeated_frames() >= kRepeats; }

  StrutAngles<double> before_;
  std::uint8_t constant_ticks_ = 0;
};

}  // namespace hoist::core
