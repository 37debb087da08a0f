// How well a session's exercise was walked: the paper's C and J_N and a few plain figures, from the columns as they are exported.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "control/contract/reference_path.hpp"
#include "db/metrics/evaluate.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/summary/moving_part.hpp"

namespace hoist::db {

/// With more motion missing a walk is not compared with its exercise. A gap of this length anywhere in an eight of 12 m changes C by at most
/// 0.02 and J_N by at most 5 % (measured and held by test_db, Metrics.AShortGap…).
inline constexpr double kMissingMost_s = 0.5;

/// Why a session has no C and J_N.
enum class NoFigure : std::uint8_t {
  none,
#define HOIST_NO_FIGURE(name, text_en, text_de) name,
#include "db/summary/no_figure.def"
#undef HOIST_NO_FIGURE
};
[[nodiscard]] std::string_view no_figure_name(NoFigure why);      ///< as REST tells it
[[nodiscard]] std::string_view no_figure_sentence(NoFigure why);  ///< in English, empty for none

struct SessionMetrics {
  SessionId session = 0;
  std::uint64_t moving_samples = 0;  ///< samples in a mode in which the wheels may turn: only these count
  double moving_s = 0;               ///< time in such a mode, standing included
  double motion_s = 0;               ///< time in which a wheel turned at 0.02 m/s or more (standing_still)
  double missing_s = 0;              ///< motion that is not recorded: all figures are of the rest
  double walked_m = 0;
  double mean_speed_m_s = 0;  ///< walked_m over motion_s: standing does not count
  double max_speed_m_s = 0;
  std::string track;  ///< which track was compared: "fused" (encoders and gyroscope, slip repaired) or "encoders" (older sessions)
  // With an exercise only.
  std::string shape;                     ///< empty without an exercise
  std::optional<double> correlation;     ///< C; absent without an exercise or where it is not defined (nothing turned)
  std::optional<double> normalised_ise;  ///< J_N
  std::optional<double> path_length_m;   ///< L: progress along the pattern
  std::optional<double> rms_position_m;  ///< from the exercise
  std::optional<double> rms_heading_rad;
  double start_m = 0;  ///< place on the figure where the walk began
  NoFigure why_absent = NoFigure::no_exercise;
  InputHashes inputs;  ///< what the figures are computed from
};

/// Errors: not_found, corrupt, io. A session without movement gives zeros and no C, J_N.
Result<SessionMetrics> session_metrics(Database& database, SessionId session);

}  // namespace hoist::db
