// How much of its speed a hoist that leads keeps for a patient who lags behind it (GUIDED). Not in the paper, where the hoist never leads.
//
// A patient who walks slower than the hoist is drawn, and the struts lean against the way by the lag. Up to start_rad the whole speed is
// driven, from stop_rad on none, in between a share that falls evenly. The lag integrates the difference of the two speeds, so this is a
// loop of gain v / (d (stop - start)), 6.6 1/s at 0.6 m/s on struts of 0.8 m, around a body of unknown mass and reaction time. Two things
// keep it calm: the share is for the lag as it will be lead_s later (drive, limiter and sensors answer that late), and its rate is limited:
// falling, which leaves out most of the sway of each step, and more so rising. Tried with bodies of 30 to 150 kg: tests/loop/patient_lag_test.cpp.
#pragma once

#include <cmath>

namespace hoist::law {

template <typename Real>
struct PatientLagConfig {
  Real start_rad{};  ///< from here on slower
  /// From here on not at all; above start_rad. 9 degrees: with a zero error of 1 degree still no more than the hanging guard's 10.
  Real stop_rad{Real(0.157079633)};
  Real lead_s{Real(0.2)};
  Real fall_per_s{Real(1.0)};
  Real rise_per_s{Real(0.4)};
};

/// The next share, 0 to 1. `lag_rad`: how far the struts lean against the way; `lag_rate_rad_s`: how fast that grows. Something not finite
/// counts as the largest lag.
template <typename Real>
[[nodiscard]] inline Real patient_lag_step(const PatientLagConfig<Real>& config, Real share_norm, Real lag_rad, Real lag_rate_rad_s,
                                           Real dt_s) {
  const Real wanted = (config.stop_rad - lag_rad - config.lead_s * lag_rate_rad_s) / (config.stop_rad - config.start_rad);
  const Real target = wanted >= Real(1) ? Real(1) : (wanted > Real(0) ? wanted : Real(0));
  const Real least = share_norm - config.fall_per_s * dt_s, most = share_norm + config.rise_per_s * dt_s;
  return target < least ? least : (target > most ? most : target);
}

}  // namespace hoist::law
