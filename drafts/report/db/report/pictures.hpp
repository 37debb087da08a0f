// Drawings of a report, as SVG within its page.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "db/report/words.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db::report {

/// The walked path over the exercise, on a grid of 1 m. Empty without samples. Errors: not_found, corrupt, io.
[[nodiscard]] Result<std::string> path_picture(Database& database, const SessionInfo& session);

struct ProgressPoint {
  std::string day;  ///< YYYY-MM-DD
  double value = 0;
};
/// A figure over the sessions, oldest first. Empty below two points.
[[nodiscard]] std::string progress_picture(const MetricInfo& figure, const std::vector<ProgressPoint>& points, Language language);

}  // namespace hoist::db::report
