// The translational controller of the paper: proportional + filtered proportional (PfP), equations (4)-(7) and Algorithm 1, pages 2-3.
//
// Read literally (D7-D11): the dead-band is |u| < D, inside it the input is discarded, the speed that decides about a reversal is the
// previous OUTPUT, and the limit on the filtered part follows both outer branches. Speeds are in the paper's "speed units"; how many
// metres per second a unit is, is the caller's scale.
#pragma once

#include <cmath>

namespace hoist::law {

/// Parameters of Algorithm 1; the defaults are the paper's (page 3).
template <typename Real>
struct PfpConfig {
  Real deadband_norm{Real(0.05)};  ///< D_x, in units of u (Fig. 2), not of the width 2 (D6)
  Real tau_n_s{Real(10)};          ///< time constant in normal operation
  Real tau_dec_s{Real(2)};         ///< time constant inside the dead-band
  Real l_dec{Real(2)};             ///< shape of the braking curve
  Real k_2r{Real(1e-4)};           ///< input gain while reversing
  Real k_p{Real(2)};               ///< gain of the direct part, units
  Real k_pf{Real(50)};             ///< gain of the filtered part, units
  Real v_f_max_units{Real(50)};    ///< bound of the filtered part; not printed, never acts at 50 (D19)
  /// Option, off in the paper: braking is never weaker than releasing (tau = min(tau, tau_dec)). Without it a slight backward lean
  /// brakes more slowly than standing upright, the more so the larger L_dec (D14).
  bool brake_at_least_as_released{false};
};

/// What the algorithm remembers. All zero at every change of mode, stop and fault (D11).
template <typename Real>
struct PfpState {
  Real v_units{};    ///< last output
  Real v_f_units{};  ///< filtered part
};

enum class PfpBranch : unsigned char {
  kDeadband,
  kReversal,
  kNormal,
  /// An input was not usable. The output then fades as in the dead-band, or is zero when state or time step were not usable.
  kRefused,
};

/// nullptr when the parameters are usable, else a sentence naming the first that is not, with its range.
template <typename Real>
[[nodiscard]] inline const char* refusal(const PfpConfig<Real>& config) {
  // Written as "not inside" so that a NaN is refused too.
  if (!(config.deadband_norm >= Real(0) && config.deadband_norm < Real(1))) return "deadband_norm: 0 <= D < 1";
  if (!(config.tau_n_s > Real(0) && std::isfinite(config.tau_n_s))) return "tau_n_s: > 0";
  if (!(config.tau_dec_s > Real(0) && std::isfinite(config.tau_dec_s))) return "tau_dec_s: > 0";
  if (!(config.l_dec > Real(0) && std::isfinite(config.l_dec))) return "l_dec: > 0";
  if (!(config.k_2r >= Real(0) && std::isfinite(config.k_2r))) return "k_2r: >= 0";
  if (!(config.k_p >= Real(0) && std::isfinite(config.k_p))) return "k_p: >= 0";
  if (!(config.k_pf >= Real(0) && std::isfinite(config.k_pf))) return "k_pf: >= 0";
  if (!(config.v_f_max_units >= Real(0))) return "v_f_max_units: >= 0";
  return nullptr;
}

/// Second row of (6), drawn in Fig. 2: tau = dT L_dec / (|u| - D) while reversing. Infinite on the edge of the dead-band; inside it tau_dec
/// applies instead, so the result there is NaN (not defined).
template <typename Real>
[[nodiscard]] inline Real tau_brake_s(Real u_norm, Real deadband_norm, Real l_dec, Real dt_s) {
  const Real beyond = std::fabs(u_norm) - deadband_norm;
  if (beyond > Real(0)) return dt_s * l_dec / beyond;
  return beyond == Real(0) ? Real(HUGE_VALF) : Real(NAN);
}

/// One step of Algorithm 1. `u_norm` is held to [-1, 1]. The braking factor of line 8 is PER STEP (D13): keep dt_s at the paper's 10 ms,
/// and never scale one factor alone. The result is always finite.
template <typename Real>
inline PfpBranch pfp_step(const PfpConfig<Real>& config, PfpState<Real>& state, Real u_norm, Real dt_s) {
  if (!(dt_s > Real(0)) || !std::isfinite(dt_s) || !std::isfinite(state.v_units) || !std::isfinite(state.v_f_units)) {
    state = {};
    return PfpBranch::kRefused;
  }
  if (!std::isfinite(u_norm)) {
    // Unknown intent: fade as if the patient stood upright.
    state.v_f_units *= std::exp(-(dt_s / config.tau_dec_s));
    state.v_units = state.v_f_units;
    if (!std::isfinite(state.v_units)) state = {};
    return PfpBranch::kRefused;
  }
  const Real u = u_norm > Real(1) ? Real(1) : (u_norm < Real(-1) ? Real(-1) : u_norm);
  const Real magnitude = std::fabs(u);
  PfpBranch branch = PfpBranch::kNormal;
  if (magnitude < config.deadband_norm) {                     // line 2
    state.v_f_units *= std::exp(-(dt_s / config.tau_dec_s));  // line 3
    state.v_units = state.v_f_units;                          // line 4
    branch = PfpBranch::kDeadband;
  } else {
    const Real forced_units = u * config.k_pf;  // line 6
    if (u * state.v_units < Real(0)) {          // line 7
      branch = PfpBranch::kReversal;
      Real exponent = (magnitude - config.deadband_norm) / config.l_dec;
      if (config.brake_at_least_as_released) {
        const Real released = dt_s / config.tau_dec_s;
        exponent = exponent < released ? released : exponent;
      }
      state.v_f_units = std::exp(-exponent) * state.v_f_units + config.k_2r * forced_units;  // line 8
    } else {
      const Real keep = std::exp(-(dt_s / config.tau_n_s));
      state.v_f_units = keep * state.v_f_units + (Real(1) - keep) * forced_units;  // line 10
    }
    const Real limit = config.v_f_max_units;  // line 11
    state.v_f_units = state.v_f_units > limit ? limit : (state.v_f_units < -limit ? -limit : state.v_f_units);
    state.v_units = config.k_p * u + state.v_f_units;  // line 12
  }
  // Parameters that refusal() would have refused, or products that overflow: stop rather than remember nonsense.
  if (!std::isfinite(state.v_units) || !std::isfinite(state.v_f_units)) {
    state = {};
    return PfpBranch::kRefused;
  }
  return branch;
}

}  // namespace hoist::law
