// H1: last resort. When a stop fails, the relay cuts the motors' supply.
//
// Watched in every mode that is not meant to move (what moves differently than commanded in the others is stopped first, by
// monitor/overspeed.hpp). Any of three things for kStop_s:
//   driven     a motor turns its wheel although nothing asks for it, or is fed through a bridge that is off (estimate/driven_wheel.hpp), in so
//              many more steps than not; in a PROTECTIVE_STOP a small current counts, too
//   unslowed   before the first standstill of a PROTECTIVE_STOP a wheel is off its ramp and does not slow down, although its motor does not brake
//              it harder than the holding brake would
//   spinning   the same, of the whole hoist by its gyroscope, while a drive is silent
// The last two need no current sensor to find a failure; a current only excuses a wheel. They end with the first standstill, because from then on
// hands may push a hoist whose drives have failed; and a shorted bridge whose current no sensor sees, on a hoist that stood, is not told from such
// a push. Nor is one while a body pushes within 10 N of what the brake holds, until it pushes otherwise.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/estimate/driven_wheel.hpp"
#include "control/core/estimate/estimate.hpp"

namespace hoist::core {

class RunawayWatch {
 public:
  /// Once in every step, with what the wheels were last told. True while the stop does not stop.
  [[nodiscard]] bool step(contract::Mode mode, bool moving, const Estimate& sensed, double left_m_s, double right_m_s, double track_m,
                          double dt_s) noexcept {
    const Odometry& wheels = sensed.odometry;
    follow(left_m_s_, left_m_s, dt_s);
    follow(right_m_s_, right_m_s, dt_s);
    if (mode != contract::Mode::protective_stop) stood_ = {};
    const bool left_fed = left_fed_.step(sensed.left_drive, wheels.wheel_left_m_s, dt_s),
               right_fed = right_fed_.step(sensed.right_drive, wheels.wheel_right_m_s, dt_s);
    if (moving) {
      driven_s_ = 0;
      left_ = right_ = turn_ = {};
      return false;
    }
    const bool stops = mode == contract::Mode::protective_stop;
    const bool driven = motor_drives(sensed.left_drive, wheels.wheel_left_m_s, left_m_s_) ||
                        motor_drives(sensed.right_drive, wheels.wheel_right_m_s, right_m_s_) ||
                        stray_current(sensed.left_drive, wheels.wheel_left_m_s) ||
                        stray_current(sensed.right_drive, wheels.wheel_right_m_s) || (stops && (left_fed || right_fed));
    // A step that says otherwise counts against, and does not begin anew: a position that comes late makes the next speeds wrong.
    driven_s_ = std::max(0.0, driven_s_ + (driven ? dt_s : -dt_s));
    bool goes_on = false;
    if (stops && !stood(sensed)) {
      const auto watch = [&](Unslowed& wheel, const DriveSensor& drive, double now_m_s, double command_m_s) {
        wheel.step(!drive.fresh().lost() && !motor_brakes(drive, now_m_s), now_m_s, command_m_s,
                   threshold<kFault, "unslowed_speed">(kBeside_m_s), kSlowing_m_s, dt_s);
      };
      watch(left_, sensed.left_drive, wheels.wheel_left_m_s, left_m_s_);
      watch(right_, sensed.right_drive, wheels.wheel_right_m_s, right_m_s_);
      const bool blind = sensed.drives_lost() && !sensed.base.rates_fresh().lost();
      turn_.step(blind, sensed.base.yaw_rate_rad_s(), (right_m_s_ - left_m_s_) / track_m, threshold<kFault, "spinning_rate">(kBeside_rad_s),
                 kSlowing_rad_s, dt_s);
      const double stop_s = hold<kFault, "unslowed_time">(kStop_s) - dt_s / 2;
      goes_on = left_.s > stop_s || right_.s > stop_s || turn_.s > stop_s;
    } else {
      left_ = right_ = turn_ = {};
    }
    return goes_on || driven_s_ > hold<kFault, "driven_time">(kStop_s) - dt_s / 2;
  }

 private:
  static constexpr contract::Fault kFault = contract::Fault::overspeed;

  // Design, section 6: a stop that does not stop within 0.3 s.
  static constexpr double kStop_s = 0.3;
  // A drive follows its command with about this lag (monitor/overspeed.hpp).
  static constexpr double kFollow_s = 0.1;
  // As the following error that stops (following_error_m_s_max), and about the same of the hoist's turn with one wheel alone.
  static constexpr double kBeside_m_s = 0.15, kBeside_rad_s = 0.25;
  // The closed brake alone slows a wheel by 1.2 m/s2 or more; a fifth of that is no brake. Over kStop_s.
  static constexpr double kSlowing_m_s = 0.2 * 1.2 * kStop_s, kSlowing_rad_s = kSlowing_m_s / 0.35;
  // As in hold_watch.hpp: wheels and gyroscope of a hoist that stands.
  static constexpr double kStands_m_s = 0.05, kStands_rad_s = 0.07;
  static constexpr std::uint8_t kStoodTicks = 10;

  // How long something has been faster than it was told without slowing down.
  struct Unslowed {
    double s = 0, from = 0;

    void step(bool counts, double now, double command, double beside, double slowing, double dt_s) noexcept {
      const double fast = std::fabs(now);
      const bool obeys = !counts || fast <= std::fabs(command) + beside || fast < from - slowing;
      if (obeys || fast > from) from = fast;
      s = obeys ? 0 : s + dt_s;
    }
  };

  static void follow(double& value, double command, double dt_s) noexcept { value += (command - value) * (dt_s / kFollow_s); }

  /// Whether this stop has come to rest once: two of the three tell of standing and none of motion. One alone does not know: a hoist turns about a
  /// wheel that stands, and rolls straight without turning.
  [[nodiscard]] bool stood(const Estimate& sensed) noexcept {
    if (stood_.reached(kStoodTicks)) return true;
    int stand = 0, move = 0;
    const auto hear = [&](const Freshness& fresh, double now, double stands) {
      if (!fresh.lost()) ++(std::fabs(now) < stands ? stand : move);
    };
    hear(sensed.left_drive.fresh(), sensed.odometry.wheel_left_m_s, kStands_m_s);
    hear(sensed.right_drive.fresh(), sensed.odometry.wheel_right_m_s, kStands_m_s);
    hear(sensed.base.rates_fresh(), sensed.base.yaw_rate_rad_s(), kStands_rad_s);
    return stood_.step(stand >= 2 && move == 0, kStoodTicks);
  }

  double left_m_s_ = 0, right_m_s_ = 0;  // what the wheels should do by now
  double driven_s_ = 0;
  FedWheel left_fed_, right_fed_;
  Unslowed left_, right_, turn_;
  Lasting stood_;
};

}  // namespace hoist::core
