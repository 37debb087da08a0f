// A recorded session in which the patient led, as the fit of a twin needs it: what reached the patient's senses, and how the harness moved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "firmware/sim/scenario.hpp"

namespace hoist::tool::twin {

/// One control step, 10 ms.
struct LedStep {
  double x_m = 0, y_m = 0, psi_rad = 0;      ///< where the hoist was, in the frame of its exercise
  double speed_m_s = 0, yaw_rate_rad_s = 0;  ///< and how it moved
  double dx_m = 0, dy_m = 0, dpsi_rad = 0;   ///< equations (1) to (3)
  bool released = false;                     ///< both drives powered, brakes open
};

struct LedSession {
  const sim::Scenario* scenario = nullptr;  ///< the simulator's walk along the same exercise
  contract::Params params;                  ///< in force when it began
  std::vector<LedStep> steps;               ///< in USER, from brakes open to the end of the walk, without a gap
  // Figures of the session (db/metrics).
  double c = 0, stride_s = 0, stride_cv_norm = 0;
  std::optional<double> asymmetry_norm;  ///< absent: too few strides
  bool simulated = false;                ///< recorded on a simulated hoist

  [[nodiscard]] double led_s() const { return static_cast<double>(steps.size()) * db::kSample_s; }
  /// Of the steps led in which the hoist moved.
  [[nodiscard]] double speed_rms_m_s() const;
  /// Of the steps led in bouts of walking.
  [[nodiscard]] double mean_speed_m_s() const;
};

/// Slower than this the hoist stands.
inline constexpr double kStands_m_s = 0.02;
/// Least of a session that tells a patient: this long led, with the strides that the figures of rhythm ask for.
inline constexpr double kLeastLed_s = 30.0, kMostLed_s = 900.0;

/// Why a session cannot bear a fit; the error's message names it in brackets.
enum class NoTwin : std::uint8_t {
  not_led,         ///< the patient did not lead
  led_again,       ///< the patient led several times in one recording
  too_short,       ///< led for less than kLeastLed_s
  too_long,        ///< led for more than kMostLed_s
  off_start,       ///< the walk did not begin at the start of its exercise
  no_exercise,     ///< none was chosen
  other_exercise,  ///< the simulator has no such line
  no_parameters,   ///< not recorded
  not_recorded,    ///< a column is missing
  no_figure        ///< C or the stride time is not valid (a gap, settings changed, few strides …); the message says why
};

/// Errors: those of the store, and bad_value with the reason why the session cannot bear a fit.
[[nodiscard]] db::Result<LedSession> read_led_session(db::Database& database, db::SessionId session);

/// The same from records in memory, as a walk in virtual time gives them. An error as above.
[[nodiscard]] db::Result<LedSession> led_session_of(const std::vector<contract::TickRecord>& records, const sim::Scenario& scenario,
                                                    const contract::Params& params);

/// The figures of such records on this line, as of a session.
[[nodiscard]] db::Analysis analysis_of(const std::vector<contract::TickRecord>& records, const contract::ReferencePath& path);
[[nodiscard]] const db::Figure& figure_of(const db::Figures& figures, std::string_view key);

}  // namespace hoist::tool::twin
