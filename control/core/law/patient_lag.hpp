// Share of its speed that the hoist keeps for a patient who lags behind it (GUIDED). Not in the paper, where the hoist never leads.
//
// A patient who walks slower than the hoist is pulled, and the struts lean against the motion by the lag. Up to start_rad the share is 1,
// from stop_rad on 0, linear in between. The lag integrates the difference of the two speeds, so this is a loop of gain v / (d (stop -
// start)), 6.6 1/s at 0.6 m/s on struts of 0.8 m, around a body of unknown mass and reaction time. Two measures keep it stable: the share
// uses the lag predicted lead_s ahead (the delay of drive, limiter and sensors), and its rate is limited, falling (which suppresses most of
// the sway) and even more rising. Tested with bodies of 30 to 150 kg: tests/loop/patient_lag_test.cpp.
#pragma once

#include <cmath>

namespace hoist::law {

template <typename Real>
struct PatientLagConfig {
  Real start_rad{};  ///< from here on slower
  /// Share 0 from here on; above start_rad. 9 degrees: with a zero error of 1 degree still within the hanging monitor's 10.
  Real stop_rad{Real(0.157079633)};
  Real lead_s{Real(0.2)};
  Real fall_per_s{Real(1.0)};
  Real rise_per_s{Real(0.4)};
};

/// The next share, 0 to 1. `lag_rad`: lean of the struts against the motion; `lag_rate_rad_s`: its rate. A non-finite value counts as the
/// largest lag.
template <typename Real>
[[nodiscard]] inline Real patient_lag_step(const PatientLagConfig<Real>& config, Real share_norm, Real lag_rad, Real lag_rate_rad_s,
                                           Real dt_s) {
  const Real wanted = (config.stop_rad - lag_rad - config.lead_s * lag_rate_rad_s) / (config.stop_rad - config.start_rad);
  const Real target = wanted >= Real(1) ? Real(1) : (wanted > Real(0) ? wanted : Real(0));
  const Real least = share_norm - config.fall_per_s * dt_s, most = share_norm + config.rise_per_s * dt_s;
  return target < least ? least : (target > most ? most : target);
}

}  // namespace hoist::law
