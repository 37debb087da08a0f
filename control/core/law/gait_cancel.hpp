// Removes the sway of the gait from lean and turn, so that a walking pelvis does not steer with every step. Not in the paper, where the
// dead-band and the slow filters of the two laws absorb it.
//
// The sideways sway is gait only (dy never drives the machine), so it is the reference. An adaptive oscillator, the second-order
// generalised integrator with a frequency-locked loop (Rodriguez et al., IEEE Transactions on Power Electronics 27, 2012; offset state
// after Karimi-Ghartemani et al., 2011), follows it: `cosine_m` is the sway, `sine_m` the same a quarter stride later. Two Fourier linear
// combiners (Vaz & Thakor, IEEE Transactions on Biomedical Engineering 36, 1989) learn the share of the turn at stride frequency and of the
// lean at twice that, two weights each, from the remainder after the removal.
//
// It neither rings nor delays: weights times sway is removed, so the removal ends with the sway, within about half a second. The weights
// learn from the high-passed remainder, limited to the size of a gait, so that a slow wish does not count as gait and a quick turn changes
// them little. Without a sway that the oscillator follows, nothing is removed.
#pragma once

#include <cmath>

#include "control/core/law/finite.hpp"

namespace hoist::law {

template <typename Real>
struct GaitCancelConfig {
  /// Stride frequencies of slow walking, with room on both sides (paper: 0.4 to 0.7 Hz at these speeds).
  Real omega_min_rad_s{Real(1.9)};
  Real omega_max_rad_s{Real(8.8)};
  Real omega_start_rad_s{Real(3.6)};
  Real damping{Real(1.2)};        ///< k of the integrator: follows within about two thirds of a stride
  Real offset_share{Real(0.25)};  ///< of the offset state
  Real lock_per_s{Real(1.4)};     ///< of the frequency loop
  Real learn_per_s{Real(0.18)};   ///< of the combiners after convergence: delays a slow wish by less than 30 ms
  Real first_learn_per_s{Real(2.0)};
  Real first_learn_s{Real(4)};        ///< this much walking until then
  Real high_pass_s{Real(0.25)};       ///< anything slower is a wish
  Real largest_turn_rad{Real(0.06)};  ///< of a remainder that is still learnt from: gait, not a turn begun
  Real largest_lean_m{Real(0.02)};
  Real sway_none_m{Real(0.004)};  ///< below: standing
  Real sway_full_m{Real(0.008)};  ///< above: walking
};

template <typename Real>
struct Combiner {
  Real cosine{}, sine{};  ///< weights, per metre of sway
  Real slow{};            ///< low-passed remainder
};

template <typename Real>
struct GaitCancelState {
  Real cosine_m{}, sine_m{}, offset_m{};
  Real omega_rad_s{};  ///< 0 = not begun
  Real error_m{};      ///< mean size of what the oscillator does not explain
  Real learnt_s{};
  Combiner<Real> turn, lean;
};

template <typename Real>
struct GaitPart {
  Real lean_m{}, turn_rad{}, sway_m{};
  Real stride_hz{};  ///< 0 while nobody walks
};

namespace detail {
// One combiner: what to remove, and one step of learning. `a`, `b`: the two basis signals, `omega` theirs, `size` their amplitude.
template <typename Real>
[[nodiscard]] inline Real combine(Combiner<Real>& c, Real a, Real b, Real omega, Real size, Real input, Real share, Real rate_per_s,
                                  Real largest, Real high_pass_s, Real dt_s) {
  const Real part = c.cosine * a + c.sine * b;
  const Real left = input - part;
  c.slow += (left - c.slow) * (dt_s / high_pass_s);
  Real quick = left - c.slow;
  quick = quick > largest ? largest : (quick < -largest ? -largest : quick);
  // The basis through the same high-pass, or the weights would turn round instead of settling.
  const Real x = omega * high_pass_s, square = x * x, below = Real(1) / (Real(1) + square);
  const Real turn_a = square * below, turn_b = x * below;
  const Real high_a = turn_a * a - turn_b * b, high_b = turn_a * b + turn_b * a;
  // Mean square of the high-passed basis: size^2 / 2 times the square of the high-pass.
  const Real step = rate_per_s * dt_s * Real(2) / (size * size * turn_a);
  c.cosine += step * quick * high_a;
  c.sine += step * quick * high_b;
  return share * part;
}
}  // namespace detail

/// One step. Subtract the returned values from the measured ones. Inputs that are not finite or beyond 2 m or rad, or a non-finite state,
/// cause a reset: nothing is removed then.
template <typename Real>
[[nodiscard]] inline GaitPart<Real> gait_cancel_step(const GaitCancelConfig<Real>& config, GaitCancelState<Real>& state, Real lean_m,
                                                     Real sway_m, Real turn_rad, Real dt_s) {
  // Beyond the reach of harness and struts: not a gait.
  const auto believable = [](Real x) { return x < Real(2) && x > Real(-2); };
  if (!believable(lean_m) || !believable(sway_m) || !believable(turn_rad)) {
    state = {};
    return {};
  }
  GaitCancelState<Real> s = state;
  if (!(s.omega_rad_s > Real(0))) {
    s = {};
    s.omega_rad_s = config.omega_start_rad_s;
    s.offset_m = sway_m;
    s.lean.slow = lean_m;
    s.turn.slow = turn_rad;
  }
  // The oscillator. Each state uses the newest value of the other, which keeps the amplitude at this step size.
  const Real error_m = sway_m - s.offset_m - s.cosine_m;
  s.cosine_m += s.omega_rad_s * (config.damping * error_m - s.sine_m) * dt_s;
  s.sine_m += s.omega_rad_s * s.cosine_m * dt_s;
  s.offset_m += config.offset_share * s.omega_rad_s * error_m * dt_s;
  const Real square = s.cosine_m * s.cosine_m + s.sine_m * s.sine_m;
  const Real size_m = std::sqrt(square);
  const bool walking = size_m > config.sway_none_m;
  if (walking) s.omega_rad_s -= config.lock_per_s * config.damping * s.omega_rad_s * error_m * s.sine_m / square * dt_s;
  s.omega_rad_s = s.omega_rad_s < config.omega_min_rad_s
                      ? config.omega_min_rad_s
                      : (s.omega_rad_s > config.omega_max_rad_s ? config.omega_max_rad_s : s.omega_rad_s);
  s.error_m += (std::fabs(error_m) - s.error_m) * dt_s / Real(0.5);

  GaitPart<Real> part;
  if (!walking) {
    // The first step starts from the present posture.
    s.turn.slow += (turn_rad - s.turn.slow) * (dt_s / config.high_pass_s);
    s.lean.slow += (lean_m - s.lean.slow) * (dt_s / config.high_pass_s);
  } else {
    const auto unit = [](Real x) { return x < Real(0) ? Real(0) : (x > Real(1) ? Real(1) : x); };
    const Real followed = unit(Real(1.6) - Real(3) * s.error_m / size_m);
    const Real share = followed * unit((size_m - config.sway_none_m) / (config.sway_full_m - config.sway_none_m));
    const Real rate_per_s = share * (s.learnt_s < config.first_learn_s ? config.first_learn_per_s : config.learn_per_s);
    if (share > Real(0.5) && s.learnt_s < config.first_learn_s) s.learnt_s += dt_s;
    part.turn_rad = detail::combine(s.turn, s.cosine_m, s.sine_m, s.omega_rad_s, size_m, turn_rad, share, rate_per_s,
                                    config.largest_turn_rad, config.high_pass_s, dt_s);
    // Twice the stride, with the same amplitude.
    const Real double_cosine_m = (s.cosine_m * s.cosine_m - s.sine_m * s.sine_m) / size_m,
               double_sine_m = Real(2) * s.cosine_m * s.sine_m / size_m;
    part.lean_m = detail::combine(s.lean, double_cosine_m, double_sine_m, Real(2) * s.omega_rad_s, size_m, lean_m, share, rate_per_s,
                                  config.largest_lean_m, config.high_pass_s, dt_s);
    part.sway_m = share * s.cosine_m;
    part.stride_hz = share > Real(0) ? s.omega_rad_s / Real(6.283185307179586) : Real(0);
  }
  const Real sum = s.cosine_m + s.sine_m + s.offset_m + s.omega_rad_s + s.error_m + s.turn.cosine + s.turn.sine + s.turn.slow +
                   s.lean.cosine + s.lean.sine + s.lean.slow + part.lean_m + part.turn_rad;
  if (!finite(sum)) {
    state = {};
    return {};
  }
  state = s;
  return part;
}

}  // namespace hoist::law
