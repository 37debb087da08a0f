// The rotational controller of the paper: Algorithm 2, page 3. PfP without the logic for reversing and without a limit.
#pragma once

#include <cmath>

namespace hoist::law {

/// How line 7 (omega = K_P u + omega_f) is read inside the dead-band.
enum class TurnDeadband : unsigned char {
  /// The input is discarded, as Algorithm 1 does: omega = omega_f. A patient who stands still does not creep. The default.
  kDiscardInput,
  /// Line 7 is common to both branches (D9): K_P u stays active, at most 0.1 unit (0.1 deg/s) at the edge.
  kLiteral,
};

/// Parameters of Algorithm 2; the numbers are the paper's (page 3).
template <typename Real>
struct PfpTurnConfig {
  Real deadband_norm{Real(0.05)};  ///< D_psi, in units of u_psi
  Real tau_n_s{Real(2)};
  Real tau_dec_s{Real(0.1)};
  Real k_p{Real(2)};
  Real k_pf{Real(50)};
  TurnDeadband deadband{TurnDeadband::kDiscardInput};
};

template <typename Real>
struct PfpTurnState {
  Real omega_units{};    ///< last output
  Real omega_f_units{};  ///< filtered part
};

enum class PfpTurnBranch : unsigned char { kDeadband, kNormal, kRefused };

/// nullptr when the parameters are usable, else a sentence naming the first that is not, with its range.
template <typename Real>
[[nodiscard]] inline const char* refusal(const PfpTurnConfig<Real>& config) {
  if (!(config.deadband_norm >= Real(0) && config.deadband_norm < Real(1))) return "deadband_norm: 0 <= D < 1";
  if (!(config.tau_n_s > Real(0) && std::isfinite(config.tau_n_s))) return "tau_n_s: > 0";
  if (!(config.tau_dec_s > Real(0) && std::isfinite(config.tau_dec_s))) return "tau_dec_s: > 0";
  if (!(config.k_p >= Real(0) && std::isfinite(config.k_p))) return "k_p: >= 0";
  if (!(config.k_pf >= Real(0) && std::isfinite(config.k_pf))) return "k_pf: >= 0";
  return nullptr;
}

/// One step of Algorithm 2. `u_norm` is held to [-1, 1]; non-finite input is refused as in pfp_step, and the result is always finite.
/// |omega| <= K_P + max(|omega_f|, K_Pf) always.
template <typename Real>
inline PfpTurnBranch pfp_turn_step(const PfpTurnConfig<Real>& config, PfpTurnState<Real>& state, Real u_norm, Real dt_s) {
  if (!(dt_s > Real(0)) || !std::isfinite(dt_s) || !std::isfinite(state.omega_units) || !std::isfinite(state.omega_f_units)) {
    state = {};
    return PfpTurnBranch::kRefused;
  }
  if (!std::isfinite(u_norm)) {
    state.omega_f_units *= std::exp(-(dt_s / config.tau_dec_s));
    state.omega_units = state.omega_f_units;
    if (!std::isfinite(state.omega_units)) state = {};
    return PfpTurnBranch::kRefused;
  }
  const Real u = u_norm > Real(1) ? Real(1) : (u_norm < Real(-1) ? Real(-1) : u_norm);
  PfpTurnBranch branch = PfpTurnBranch::kNormal;
  if (std::fabs(u) < config.deadband_norm) {                      // line 2
    state.omega_f_units *= std::exp(-(dt_s / config.tau_dec_s));  // line 3
    const bool literal = config.deadband == TurnDeadband::kLiteral;
    state.omega_units = literal ? config.k_p * u + state.omega_f_units  // line 7
                                : state.omega_f_units;
    branch = PfpTurnBranch::kDeadband;
  } else {
    const Real forced_units = config.k_pf * u;  // line 5
    const Real keep = std::exp(-(dt_s / config.tau_n_s));
    state.omega_f_units = keep * state.omega_f_units + (Real(1) - keep) * forced_units;  // line 6
    state.omega_units = config.k_p * u + state.omega_f_units;                            // line 7
  }
  // Parameters that refusal() would have refused, or products that overflow: stop rather than remember nonsense.
  if (!std::isfinite(state.omega_units) || !std::isfinite(state.omega_f_units)) {
    state = {};
    return PfpTurnBranch::kRefused;
  }
  return branch;
}

}  // namespace hoist::law
