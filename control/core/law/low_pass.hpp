// First-order low-pass, as the drive uses on its speed (page 6, "filtering the result using a first order low-pass filter").
#pragma once

#include "control/core/law/finite.hpp"

namespace hoist::law {

template <typename Real>
struct LowPassState {
  Real value{};
};

/// Share of the difference to its input that the filter takes in one step. The only division: a caller at 1 kHz stores it.
template <typename Real>
[[nodiscard]] constexpr Real low_pass_share(Real tau_s, Real dt_s) {
  return dt_s / (tau_s + dt_s);
}

/// The same step with that share at hand.
template <typename Real>
inline Real low_pass_by_share(Real share, LowPassState<Real>& state, Real input) {
  const Real next = state.value + share * (input - state.value);
  if (finite(next)) state.value = next;
  return state.value;
}

/// Backward Euler of tau y' + y = x: stable for every tau >= 0 and dt > 0, one division, no exponential on a processor without one.
/// tau = 0 passes the input through. An input that is not finite is ignored.
template <typename Real>
inline Real low_pass_step(Real tau_s, LowPassState<Real>& state, Real input, Real dt_s) {
  return low_pass_by_share(low_pass_share(tau_s, dt_s), state, input);
}

}  // namespace hoist::law
