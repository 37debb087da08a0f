// H1: the wheels do not follow their command.
//
// While the drives follow: the hoist is faster than speed_m_s_max + overspeed_margin_m_s for 50 ms, or a wheel is following_error_m_s_max
// beside its command for following_error_s. R2 within 150 ms. The drives have their own absolute limit (R3, 20 ms, firmware/nodes/drive).
// In every mode: a current flows through a bridge that is off, for 50 ms (estimate/driven_wheel.hpp). A hoist whose drives are off may be pushed
// by hand.
//
// When such a stop fails, output/runaway_watch.hpp cuts the motors' supply.
#pragma once
#include <cmath>
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/estimate/driven_wheel.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class Overspeed {
 public:
  static constexpr contract::Fault kFault = contract::Fault::overspeed;

  bool check(const MonitorView& view) noexcept {
    const Odometry& odometry = view.sensed.odometry;
    const bool known = !view.sensed.drives_lost();
    const bool stray =
        stray_current(view.sensed.left_drive, odometry.wheel_left_m_s) || stray_current(view.sensed.right_drive, odometry.wheel_right_m_s);
    if (stray_.step(stray, hold<kFault, "stray_time">(kFastTicks))) {
      code_ = 0;
      return true;
    }
    if (!view.powered || !known) {
      left_.value = odometry.wheel_left_m_s;
      right_.value = odometry.wheel_right_m_s;
      fast_ = {};
      apart_s_ = 0;
      code_ = 0;
      return false;
    }
    follow(left_.value, view.left_command_m_s, view.dt_s);
    follow(right_.value, view.right_command_m_s, view.dt_s);
    const bool fast =
        !(std::fabs(odometry.speed_m_s) <= view.params.speed_m_s_max + threshold<kFault, "margin">(view.params.overspeed_margin_m_s));
    const double apart_m_s = threshold<kFault, "following_error">(view.params.following_error_m_s_max);
    // Per wheel, because a single wheel that runs away moves the middle by only half.
    const bool left_apart = !(std::fabs(odometry.wheel_left_m_s - left_.value) <= apart_m_s);
    const bool right_apart = !(std::fabs(odometry.wheel_right_m_s - right_.value) <= apart_m_s);
    const bool apart = left_apart || right_apart;
    const double push_a = kPushShare * view.params.drive_current_limit_a;
    const bool held_back = apart && !fast &&
                           (!left_apart || held(odometry.wheel_left_m_s, left_.value, view.sensed.left_drive.current_a(), push_a)) &&
                           (!right_apart || held(odometry.wheel_right_m_s, right_.value, view.sensed.right_drive.current_a(), push_a));
    code_ = held_back ? kHeldBack : std::uint16_t{0};
    const bool stays_fast = fast_.step(fast, hold<kFault, "time_above">(kFastTicks));
    apart_s_ = apart ? apart_s_ + view.dt_s : 0;
    return stays_fast || apart_s_ > hold<kFault, "following_time">(view.params.following_error_s) - view.dt_s / 2;
  }

  /// Its detail code (HOIST_DETAIL).
  [[nodiscard]] std::uint16_t code() const noexcept { return code_; }

 private:
  struct Reference {
    double value = 0;
  };
  // One position report that a late SYNC moved by some milliseconds must not trip: 50 ms in a row.
  static constexpr std::uint8_t kFastTicks = 5;
  // A drive follows its command with about this lag (0.08 s in the closed-loop model, plus one step each way on the bus); without it
  // every bumper stop would differ by a x lag = 0.15 m/s.
  static constexpr double kFollow_s = 0.1;
  static constexpr std::uint16_t kHeldBack = 1;
  // Half of the current limit is far above what rolling takes: the motor pushes against something. A bridge or motor that gives no torque
  // draws less, and that is the machine's own fault.
  static constexpr double kPushShare = 0.5;

  /// Slower than it should be, in the same direction or standing, while the motor pushes.
  [[nodiscard]] static bool held(double wheel_m_s, double reference_m_s, double current_a, double push_a) noexcept {
    return std::fabs(wheel_m_s) < std::fabs(reference_m_s) && wheel_m_s * reference_m_s >= 0 && std::fabs(current_a) >= push_a;
  }

  static void follow(double& value, double command, double dt_s) noexcept { value += (command - value) * (dt_s / kFollow_s); }

  Reference left_, right_;
  double apart_s_ = 0;
  std::uint16_t code_ = 0;
  Lasting fast_, stray_;
};

}  // namespace hoist::core
