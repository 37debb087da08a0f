// H8: a tilt sensor reports itself invalid, or its rates are impossible.
//
// Its self-test has failed, at once; its samples are invalid or its gyroscope saturated, for 50 ms. R2 within 60 ms.
// The rates that it sends add up to more than drift_rad_max in ten seconds, which a thing that stops at 15 degrees cannot do: its gyroscope
// has lost its zero. R2 as soon as they do. Sensors that send no rates are not judged so. A sensor that leans feels part of the hoist's turn
// as pitch and roll; in a long bend that adds up like a lost zero, so the chassis' turn rate is taken off first. A hoist that is spun faster than
// it drives is not judged so: its angles show the pull outwards, too, and what they make of the turn is no rate. Where the
// wheels deny the spin it is judged all the same: a gyroscope that is off in all axes would excuse itself.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class TiltSensorFault {
 public:
  static constexpr contract::Fault kFault = contract::Fault::tilt_sensor_fault;

  bool check(const MonitorView& view) noexcept {
    const bool left = bad(view.sensed.left_strut, left_.bad);
    const bool right = bad(view.sensed.right_strut, right_.bad);
    const bool base = bad(view.sensed.base, base_.bad);
    const double drift_rad = threshold<kFault, "drift">(view.params.drift_rad_max);
    const TiltSensor& chassis = view.sensed.base;
    const double turn_rad_s = chassis.rates_fresh().lost() ? 0.0 : chassis.yaw_rate_rad_s();
    // A wheel that slides, or whose drive is silent, tells of less.
    const bool spun = std::fabs(turn_rad_s) > kSpun_rad_s &&
                      (view.sensed.drives_lost() || std::fabs(view.sensed.odometry.yaw_rate_rad_s) > kSpun_rad_s / 2);
    const bool left_drifts = drifts(view.sensed.left_strut, turn_rad_s, spun, left_.drift, drift_rad, view.dt_s);
    const bool right_drifts = drifts(view.sensed.right_strut, turn_rad_s, spun, right_.drift, drift_rad, view.dt_s);
    const bool base_drifts = drifts(view.sensed.base, turn_rad_s, spun, base_.drift, drift_rad, view.dt_s);
    return view.mode != contract::Mode::init && (left || right || base || left_drifts || right_drifts || base_drifts);
  }

 private:
  // As long as a silent sensor is given: an invalid sample is worth no more than none.
  static constexpr std::uint8_t kBadTicks = kLostTicks;

  struct Drift {
    double pitch_rad = 0, roll_rad = 0;
  };
  struct Sensor {
    Lasting bad;
    Drift drift;
  };
  static constexpr double kDrift_s = 10.0;  // H8
  // Faster than yaw_rate_rad_s_max can be set; about one wheel it pulls at a sensor 0.4 m away like a lean of 2.3 degrees.
  static constexpr double kSpun_rad_s = 1.0;

  // What the rates add up to, with a memory of ten seconds.
  [[nodiscard]] static bool drifts(const TiltSensor& tilt, double turn_rad_s, bool spun, Drift& drift, double limit_rad,
                                   double dt_s) noexcept {
    if (!spun && tilt.rates_now()) {
      // The upright seen from a sensor that leans forward and right; as it sent its angles, because its mounting leans too.
      drift.pitch_rad += (tilt.pitch_rate_rad_s() - turn_rad_s * std::sin(tilt.sent_beta_rad())) * dt_s;
      drift.roll_rad += (tilt.roll_rate_rad_s() + turn_rad_s * std::sin(tilt.sent_alpha_rad())) * dt_s;
    }
    const double keep = 1.0 - dt_s / kDrift_s;
    drift.pitch_rad *= keep;
    drift.roll_rad *= keep;
    return !(std::fabs(drift.pitch_rad) <= limit_rad && std::fabs(drift.roll_rad) <= limit_rad);
  }

  [[nodiscard]] static bool bad(const TiltSensor& tilt, Lasting& held) noexcept {
    if (tilt.heard().lost()) {
      held = {};  // a silent one is NodeLost's
      return false;
    }
    const bool useless = !tilt.has(tilt_status::kValid) || tilt.has(tilt_status::kGyroSaturated);
    // Only a valid new sample ends it; invalid and repeated ones by turns do not.
    if (useless || tilt.fresh().now()) held.step(useless, hold<kFault, "invalid">(kBadTicks));
    return tilt.has(tilt_status::kSelfTestFailed) || held.reached(hold<kFault, "invalid">(kBadTicks));
  }

  Sensor left_, right_, base_;
};

}  // namespace hoist::core
