// Fits the simulated patient to a recorded session.
//
// Method: output error. The patient of firmware/sim is put into a hoist that moves as recorded (replay.hpp), and the sum of squares between
// its lean and turn and the recorded ones, both averaged over a stride, is made least (Levenberg-Marquardt, Nielsen's damping; several
// starts drawn from the seed). The ranges of usual patients are weak knowledge before the data (a normal distribution of the same
// variance), so that a value that the session does not tell stays usual and keeps its wide spread. The gait comes before: stride and asymmetry from
// the figures of the session (db/metrics/rhythm.hpp), amplitudes by the replayed sway.
// The walker leads in the replay, also when the recorded hoist does not answer. One that may come to distrust a hoist that does not
// answer it stops leading for good, and the sum of squares is flat there: that was a trap for the search.
// Spread: two or three times the square root of the diagonal of the inverse of the normal equations, the residuals' correlation in time
// counted (blocks of 5 s).
// Sources: Ljung, System Identification, 2nd edition, 7.3 (output error), 9.4 (spread); field.md 4, "patient twin".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "deploy/tools/hoist/twin/led_session.hpp"
#include "firmware/sim/patient.hpp"

namespace hoist::tool::twin {

/// One value of the patient, as fitted.
struct FittedValue {
  std::string_view name, unit;
  double value = 0;
  double spread = 0;        ///< standard deviation
  double usual = 0;         ///< of people before any recording: mean …
  double usual_spread = 0;  ///< … and standard deviation
  std::string_view alike;   ///< the value that it is told from least; empty for none
  double alike_norm = 0;    ///< correlation of both errors, -1 to 1

  /// Less than half of what was unknown before is left.
  [[nodiscard]] bool told() const { return spread < 0.5 * usual_spread; }
  /// Its error is not mostly that of another value (|correlation| below 0.9).
  [[nodiscard]] bool told_apart() const { return alike_norm < 0.9 && alike_norm > -0.9; }
};

struct Fit {
  sim::PatientParams patient;
  std::vector<FittedValue> values;              ///< those that were fitted, named as in PatientParams
  std::vector<FittedValue> derived;             ///< what people ask for: delay, stiffness, cadence, asymmetry, turning lead
  std::vector<std::vector<double>> alike_norm;  ///< correlation of the errors of each two of `values`
  double rms_lean_m = 0, rms_turn_rad = 0;      ///< what the patient does not explain, of averages over a stride

  [[nodiscard]] const FittedValue& operator[](std::string_view name) const;
};

/// The patient with these values in the order of Fit::values, each held inside its bounds.
[[nodiscard]] sim::PatientParams with_values(sim::PatientParams patient, const std::vector<double>& values);
/// Its values in that order.
[[nodiscard]] std::vector<double> fitted_values(const sim::PatientParams& patient);

/// The same session and seed give the same fit.
[[nodiscard]] Fit fit_patient(const LedSession& session, std::uint64_t seed);

}  // namespace hoist::tool::twin
