// How far the hoist would still roll if the link to its driver, or the control computer, failed now. An upper bound
// that exceeds the true distance by less than a fifth on average (tests/loop/stop_distance_test.cpp cuts at random and
// measures).
//
//   patient leads       the link has no driver; the protective stop, as after STOP
//   therapist drives    the last command goes on, scaled down from remote_slow_age_s, and at remote_stop_age_s the driver's ramp begins
//   any stop in force   its own ramp, from where it is
//   computer dies       the drives keep their last command until its deadline, then each stops its wheel on its quick-stop ramp
//
// The wheels follow all of this with a lag. A first-order lag rolls just lag x speed farther than its command, whatever the command does.
#pragma once
#include <cmath>

#include "control/contract/can_dictionary.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/output/limiter.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

struct StopDistance {
  double link_m = 0;
  double computer_m = 0;
};

namespace stopping {

/// Servo, gears and patient behind the command, measured in the closed loop over random patients and never passed there. A patient who
/// leads holds against the stop with the springs; on their own quick stop the drives need no news from the bus.
inline constexpr double kLagDriven_s = 0.067, kLagLed_s = 0.06, kLagAloneDriven_s = 0.037, kLagAloneLed_s = 0.045;
/// From the decision to the wheels: the rest of this step, the bus, and the drive's millisecond.
inline constexpr double kStep_s = 0.012;
/// A wheel that a patient pushes does not stop to the millimetre.
inline constexpr double kFloor_m = 0.001;
/// The ageing of the last command is computed in steps of this length; finer ones change less than a millimetre.
inline constexpr double kPiece_s = 0.025;
inline constexpr int kPiecesMax = 24;

inline constexpr double kDeadline_s = contract::find_object(contract::NodeKind::drive, 0x1400, 5)->default_value * 0.001;
inline constexpr double kQuickStop_rad_s2 = contract::find_object(contract::NodeKind::drive, 0x6085, 0)->default_value;

[[nodiscard]] inline double ramp_m(double speed_m_s, double rate_m_s2) noexcept { return speed_m_s * speed_m_s / (2.0 * rate_m_s2); }

/// The limiter while the last command ages: Limiter::follow_speed in longer steps. A little gentler than that when it slows, so that the way
/// never comes out too short.
[[nodiscard]] inline double last_command_m(const CoreState& state, double wish_m_s) noexcept {
  const contract::Params& p = state.params;
  const double most_m_s = p.speed_m_s_max * p.speed_cap_norm;
  double speed = state.limiter.speed_m_s(), acceleration = state.limiter.acceleration_m_s2(), way_m = 0;
  double age_s = state.remote.age_s(state.time_ns);
  for (int i = 0; i < kPiecesMax && age_s < p.remote_stop_age_s; ++i) {
    const double piece_s = std::fmin(kPiece_s, p.remote_stop_age_s - age_s);
    const double middle_s = age_s + piece_s / 2.0;
    age_s += piece_s;
    const double share =
        middle_s <= p.remote_slow_age_s ? 1.0 : (p.remote_stop_age_s - middle_s) / (p.remote_stop_age_s - p.remote_slow_age_s);
    const double gap = std::fmin(std::fmax(wish_m_s * share, -most_m_s), most_m_s) - speed;
    // The acceleration from which the gap is met while it falls by the jerk.
    const double meets = std::sqrt(2.0 * p.jerk_m_s3_max * std::fabs(gap));
    const double gentle = gap * speed < 0 ? std::fmax(meets - p.jerk_m_s3_max * kTick_s / 2.0, 0.0) : meets;
    const double largest = std::fmin(std::fmin(p.acceleration_m_s2_max, gentle), std::fabs(gap) / piece_s);
    const double wanted = gap < 0 ? -largest : largest, change = p.jerk_m_s3_max * piece_s;
    acceleration = std::fmin(std::fmax(wanted, acceleration - change), acceleration + change);
    const double next = speed + acceleration * piece_s;
    way_m += std::fabs(speed + next) / 2.0 * piece_s;
    speed = next;
  }
  return way_m + ramp_m(speed, kRemoteDeceleration_m_s2);
}

}  // namespace stopping

/// Of the hoist as it moves in this step.
[[nodiscard]] inline StopDistance stop_distance(const CoreState& state) noexcept {
  using namespace stopping;
  const Odometry& wheels = state.sensed.odometry;
  const double rolling_m_s = std::fabs(wheels.speed_m_s), command_m_s = std::fabs(state.limiter.speed_m_s());
  const bool led = state.mode == contract::Mode::user;
  const bool drives = mode_row_of(state.mode).drives;
  StopDistance out;
  if (!drives) {
    // The drives are off and their brakes hold; a person who pushes the hoist controls it.
    return out;
  }
  // Braked by the core.
  const Braking braking = state.in_mode.braking;
  double way_m = 0;
  if (braking != Braking::none) {
    way_m = ramp_m(command_m_s, deceleration_m_s2(braking, state.params));
  } else if (led) {
    way_m = ramp_m(command_m_s, deceleration_m_s2(Braking::protective, state.params));
  } else if (!state.remote.held() || state.remote.awaits_neutral()) {
    way_m = ramp_m(command_m_s, kRemoteDeceleration_m_s2);
  } else {
    // The wish of a command that already ages is scaled down; the command itself is not. An exercise may be about to go faster again,
    // behind a bend: it counts with the speed that was chosen for it, within the cap before it is scaled. The stick's wish meets its cap after.
    const contract::Params& p = state.params;
    const double full_m_s = state.mode == contract::Mode::guided
                                ? std::fmin(state.guided.wish().speed_m_s, p.speed_m_s_max * p.speed_cap_norm)
                                : state.remote.speed_norm() * p.remote_speed_m_s_max;
    way_m = last_command_m(state, full_m_s);
  }
  out.link_m = way_m + kStep_s * command_m_s + (led ? kLagLed_s : kLagDriven_s) * rolling_m_s;
  // Braked by each drive: in a bend the outer wheel takes longer, and the middle goes on with it.
  const double rate_m_s2 = kQuickStop_rad_s2 * 2.0 / (state.derived.left_motor_per_m + state.derived.right_motor_per_m);
  const double wheels_m = (ramp_m(state.left_command_m_s, rate_m_s2) + ramp_m(state.right_command_m_s, rate_m_s2)) / 2.0;
  out.computer_m = wheels_m + (kDeadline_s + kStep_s) * command_m_s + (led ? kLagAloneLed_s : kLagAloneDriven_s) * rolling_m_s;
  if (rolling_m_s > 0 || command_m_s > 0) {
    out.link_m += kFloor_m;
    out.computer_m += kFloor_m;
  }
  return out;
}

}  // namespace hoist::core
