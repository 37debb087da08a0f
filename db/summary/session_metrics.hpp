// How well a session's exercise was walked: the paper's C and J_N and a few plain figures, from the columns as they are exported.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/summary/moving_part.hpp"

namespace hoist::db {

/// With more motion missing a walk is not compared with its exercise. At 0.65 m/s it is a third of a metre, which the projection onto the
/// figure bridges (kProjectionWindow_m); a lost begin of that length leaves the start of the figure within its reach, too.
inline constexpr double kMissingMost_s = 0.5;

struct SessionMetrics {
  SessionId session = 0;
  std::uint64_t moving_samples = 0;  ///< samples in a mode in which the wheels may turn: only these count
  double moving_s = 0;
  double missing_s = 0;  ///< motion that is not recorded: all figures are of the rest
  double distance_m = 0;
  double mean_speed_m_s = 0;
  double max_speed_m_s = 0;
  std::string track;  ///< which track was compared: "fused" (encoders and gyroscope, slip repaired) or "encoders" (older sessions)
  // With an exercise only.
  std::string shape;                     ///< empty without an exercise
  std::optional<double> correlation;     ///< C; absent without an exercise or where it is not defined (nothing turned)
  std::optional<double> normalised_ise;  ///< J_N
  std::optional<double> path_length_m;   ///< L: progress along the pattern
  std::string why_absent;                ///< a sentence when there is an exercise and still no figure
};

/// Errors: not_found, corrupt, io. A session without movement gives zeros and no C, J_N.
Result<SessionMetrics> session_metrics(Database& database, SessionId session);
/// The same of a part that is read already: decoding a long session is what takes the time.
Result<SessionMetrics> session_metrics(Database& database, SessionId session, const MovingPart& part);

}  // namespace hoist::db
