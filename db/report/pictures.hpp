// Drawings of a report, as SVG within its page.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "db/report/words.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db::report {

/// The walked path over the planned one, on a grid of 1 m; `label` is read aloud in its place. Empty without samples.
/// Errors: not_found, corrupt, io.
[[nodiscard]] Result<std::string> path_picture(Database& database, const SessionInfo& session, const std::string& label);

struct ProgressPoint {
  std::string day;              ///< as it is shown
  std::optional<double> value;  ///< none: not valid, and the line breaks there
};
/// A figure over the sessions, oldest first. Empty below two values.
[[nodiscard]] std::string progress_picture(const MetricInfo& figure, const std::vector<ProgressPoint>& points, const std::string& label,
                                           Language language);

}  // namespace hoist::db::report
