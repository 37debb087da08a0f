// USER: the patient leads. Algorithm 1 for speed and Algorithm 2 for turning, pages 2 and 3, on the lean and turn of the harness.
#pragma once
#include <cmath>

#include "control/core/law/differential_drive.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/standstill.hpp"

namespace hoist::core {

struct UserMode {
  static constexpr contract::Mode kMode = contract::Mode::user;

  /// Both filters begin at zero: nothing of an earlier walk pushes this one (D11).
  static void enter(CoreState& state) noexcept {
    state.lean = {};
    state.turn = {};
  }

  static Wish step(CoreState& state, double dt_s) noexcept {
    if (state.in_mode.leaving) {
      enter(state);
      return {0, 0, state.in_mode.braking, at_rest(state)};
    }
    // While the drives are being enabled the filters stay at zero, so that no stored speed is released afterwards.
    if (!state.in_mode.powered) return {};
    const contract::Params& p = state.live;
    law::PfpConfig<double> lean;
    lean.deadband_norm = p.lean_dead_band_norm;
    lean.tau_n_s = p.lean_tau_normal_s;
    lean.tau_dec_s = p.lean_tau_release_s;
    lean.l_dec = p.braking_softness_norm;
    lean.k_2r = p.reversal_gain_norm;
    lean.k_p = p.lean_gain_direct_units;
    lean.k_pf = p.lean_gain_filtered_units;
    // Speed that a cap does not let it drive is not built up either: the end of the cap would release it without a lean, and standing upright
    // would not slow the hoist until it had faded. Algorithm 1 bounds it outside of the dead-band only.
    lean.v_f_max_units = std::fmin(p.lean_filtered_units_max, cap_m_s(state) / p.speed_per_unit_m_s);
    state.lean.v_f_units = std::fmax(-lean.v_f_max_units, std::fmin(state.lean.v_f_units, lean.v_f_max_units));
    law::PfpTurnConfig<double> turn;
    turn.deadband_norm = p.turn_dead_band_norm;
    turn.tau_n_s = p.turn_tau_normal_s;
    turn.tau_dec_s = p.turn_tau_release_s;
    turn.k_p = p.turn_gain_direct_units;
    turn.k_pf = p.turn_gain_filtered_units;
    // Standing still means standing still: inside the dead-band the input is discarded (D9, the product's reading).
    turn.deadband = law::TurnDeadband::kDiscardInput;
    law::pfp_step(lean, state.lean, state.intent.lean_norm(), dt_s);
    law::pfp_turn_step(turn, state.turn, state.intent.turn_norm(), dt_s);
    const auto speed =
        law::platform_speed<double>(state.lean.v_units, state.turn.omega_units, {p.speed_per_unit_m_s, p.yaw_rate_per_unit_rad_s});
    return {speed.v_m_s, speed.omega_rad_s, Braking::none, false};
  }

 private:
  /// This patient's cap and, on a slope, the limit there; the limiter has both, too.
  [[nodiscard]] static double cap_m_s(const CoreState& state) noexcept {
    const contract::Params& p = state.params;
    const double patient_m_s = p.speed_m_s_max * p.speed_cap_norm;
    const bool slopes = (state.latched & contract::fault_bit(contract::Fault::base_tilt_high)) != 0;
    return slopes ? std::fmin(patient_m_s, p.base_tilt_speed_m_s_max) : patient_m_s;
  }
};

}  // namespace hoist::core
