// Ramp: a value follows its target by at most `max_rate` per second (page 6, "the reference speed ... is rate-limited").
#pragma once

#include "control/core/law/finite.hpp"

namespace hoist::law {

template <typename Real>
struct RateLimitState {
  Real value{};
};

/// One step towards the target. A target or rate that is not finite, or a negative rate, leaves the value where it is.
template <typename Real>
inline Real rate_limit_step(Real max_rate, RateLimitState<Real>& state, Real target, Real dt_s) {
  const Real largest_step = max_rate * dt_s;
  if (!finite(target) || !(largest_step >= Real(0)) || !finite(largest_step)) return state.value;
  const Real wanted_step = target - state.value;
  if (wanted_step > largest_step) {
    state.value += largest_step;
  } else if (wanted_step < -largest_step) {
    state.value -= largest_step;
  } else {
    state.value = target;
  }
  return state.value;
}

}  // namespace hoist::law
