// The servo loop of a drive: Fig. 6 and page 6, "semi-cascaded controller with current limit in internal loop and velocity-mode PI servo
// controller in external loop", 1 kHz.
//
//   target -> ramp -> (+) -> PI ----------> current limit -> duty
//                      ^(-)   ^------ integral <----|
//   position -> difference -> low-pass
//
// The limiter works on the applied voltage: it may rise in one tick by at most `limiter_v_per_a` for each ampere of head-room and must fall
// by as much for each ampere too many. With the winding as a first-order lag this is an integrating current controller that acts only at
// the limit; it needs no other motor model. The amount removed by the limiter is subtracted from the integral in the same tick, so that a
// blocked wheel causes no wind-up.
#pragma once

#include <cmath>
#include <cstdint>

#include "control/core/law/finite.hpp"
#include "control/core/law/low_pass.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/rate_limit.hpp"

namespace hoist::law {

/// Defaults suit the 24 V, 100 W motor model of the simulator (1.2 ohm, 1.5 mH, 0.115 V s/rad, 4.3e-4 kg m^2) at 1 ms; speeds are at
/// the motor shaft, before the gear.
template <typename Real>
struct ServoConfig {
  Real counts_per_turn{Real(2000)};
  Real acceleration_max_rad_s2{Real(400)};  ///< steepness of the reference's ramp
  Real current_limit_a{Real(4)};
  Real k_p_v_s_rad{Real(0.18)};         ///< volts per rad/s of error
  Real k_i_v_rad{Real(2.7)};            ///< volts per second and rad/s of error
  Real speed_low_pass_s{Real(0.004)};   ///< one count in 1 ms is 3.1 rad/s; this smooths it
  Real speed_low_pass_share{};          ///< low_pass_share() of it, stored by the caller; 0: computed in every step
  Real limiter_v_per_a{Real(0.48)};     ///< 0.4 times the winding's resistance; stable up to several times that
  Real supply_min_v{Real(6)};           ///< below this no duty is computed from the supply
  Real command_timeout_s{Real(0.040)};  ///< an older command counts as "stand still"
};

template <typename Real>
struct ServoState {
  RateLimitState<Real> reference_rad_s{};
  LowPassState<Real> speed_rad_s{};
  Real integral_v{};
  Real applied_v{};
  std::int32_t position_counts{};
  bool started{false};  ///< the first tick only notes the position
};

template <typename Real>
struct ServoInput {
  Real target_rad_s{};
  Real command_age_s{};  ///< time since the last command arrived
  std::int32_t position_counts{};
  Real current_a{};  ///< positive drives forward
  Real supply_v{Real(24)};
  /// A better speed than the difference of two positions (from edge times), if the caller has one; it is low-passed too.
  bool speed_measured{false};
  Real speed_rad_s{};
};

template <typename Real>
struct ServoOutput {
  Real duty_norm{};        ///< [-1, 1] of the supply
  Real reference_rad_s{};  ///< where the ramp is
  Real speed_rad_s{};      ///< filtered shaft speed
  bool limited{false};     ///< the current or the supply held the PI back
  bool command_stale{false};
  bool refused{false};  ///< an input was invalid; duty is zero and the loop restarts
};

/// nullptr when the parameters are usable, else a sentence naming the first that is not, with its range.
template <typename Real>
[[nodiscard]] inline const char* refusal(const ServoConfig<Real>& config) {
  const auto positive = [](Real x) { return x > Real(0) && finite(x); };
  const auto not_negative = [](Real x) { return x >= Real(0) && finite(x); };
  if (!positive(config.counts_per_turn)) return "counts_per_turn: > 0";
  if (!positive(config.acceleration_max_rad_s2)) return "acceleration_max_rad_s2: > 0";
  if (!not_negative(config.current_limit_a)) return "current_limit_a: >= 0";
  if (!not_negative(config.k_p_v_s_rad)) return "k_p_v_s_rad: >= 0";
  if (!not_negative(config.k_i_v_rad)) return "k_i_v_rad: >= 0";
  if (!not_negative(config.speed_low_pass_s)) return "speed_low_pass_s: >= 0";
  if (!positive(config.limiter_v_per_a)) return "limiter_v_per_a: > 0";
  if (!positive(config.supply_min_v)) return "supply_min_v: > 0";
  if (!not_negative(config.command_timeout_s)) return "command_timeout_s: >= 0";
  return nullptr;
}

/// One tick, dt_s = 1 ms. For any input, duty is finite and within [-1, 1].
template <typename Real>
inline ServoOutput<Real> servo_step(const ServoConfig<Real>& config, ServoState<Real>& state, const ServoInput<Real>& input, Real dt_s) {
  ServoOutput<Real> output;
  if (!finite(input.target_rad_s) || !finite(input.current_a) || !finite(input.speed_rad_s) || !(input.supply_v >= config.supply_min_v) ||
      !finite(input.supply_v) || !(dt_s > Real(0)) || !finite(dt_s)) {
    state = {};
    output.refused = true;
    return output;
  }
  // Speed: difference of position, low-pass. delta32 handles the wrap of the counter.
  const std::int32_t moved_counts = state.started ? delta32(input.position_counts, state.position_counts) : 0;
  state.started = true;
  state.position_counts = input.position_counts;
  constexpr Real kTurnRad = Real(6.283185307179586);
  const Real raw_rad_s =
      input.speed_measured ? input.speed_rad_s : static_cast<Real>(moved_counts) * (kTurnRad / (config.counts_per_turn * dt_s));
  output.speed_rad_s = config.speed_low_pass_share > Real(0) ? low_pass_by_share(config.speed_low_pass_share, state.speed_rad_s, raw_rad_s)
                                                             : low_pass_step(config.speed_low_pass_s, state.speed_rad_s, raw_rad_s, dt_s);

  // Reference: a command that is too old (or of unknown age) is a command to stand still; the same ramp brings it there.
  output.command_stale = !(input.command_age_s <= config.command_timeout_s);
  const Real target_rad_s = output.command_stale ? Real(0) : input.target_rad_s;
  output.reference_rad_s = rate_limit_step(config.acceleration_max_rad_s2, state.reference_rad_s, target_rad_s, dt_s);

  // PI on the speed, in volts.
  const Real error_rad_s = output.reference_rad_s - output.speed_rad_s;
  state.integral_v += config.k_i_v_rad * error_rad_s * dt_s;
  const Real wanted_v = config.k_p_v_s_rad * error_rad_s + state.integral_v;

  // Current limit, then the supply.
  const Real highest_v = state.applied_v + config.limiter_v_per_a * (config.current_limit_a - input.current_a);
  const Real lowest_v = state.applied_v + config.limiter_v_per_a * (-config.current_limit_a - input.current_a);
  Real applied_v = wanted_v > highest_v ? highest_v : (wanted_v < lowest_v ? lowest_v : wanted_v);
  applied_v = applied_v > input.supply_v ? input.supply_v : (applied_v < -input.supply_v ? -input.supply_v : applied_v);

  // Feedback to the integral: it ends the tick as if the PI had requested the applied voltage.
  state.integral_v += applied_v - wanted_v;
  state.applied_v = applied_v;
  if (!finite(applied_v) || !finite(state.integral_v)) {
    state = {};
    output = {};
    output.refused = true;
    return output;
  }
  output.limited = applied_v != wanted_v;
  output.duty_norm = applied_v / input.supply_v;
  return output;
}

/// Forgets everything but the parameters: on enable, disable and every fault. The next step only notes the position.
template <typename Real>
inline void servo_reset(ServoState<Real>& state) {
  state = {};
}

}  // namespace hoist::law
