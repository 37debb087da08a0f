// The recorded runs of a study, evaluated by the figures that everything else shows (db/summary/session_metrics.hpp).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"

namespace hoist::tool::study {

/// Of a run, by subject: what the tables need; absent where the run is.
using Column = std::vector<std::optional<double>>;

struct Results {
  std::vector<std::string> subjects;                                  ///< codes, in the order of the rows
  std::map<std::pair<std::size_t, int>, db::SessionId> runs;          ///< session of a row and a run's number
  std::map<std::string, std::map<int, Column>, std::less<>> columns;  ///< by figure and run
  std::vector<std::string> left_out;                                  ///< runs that do not count, and why

  [[nodiscard]] const Column& column(std::string_view figure, int run) const { return columns.find(figure)->second.at(run); }
};

/// The figures that a study tells.
inline constexpr std::string_view kTold[] = {
    "C", "C_best", "J_N", "rms_position_m", "rms_heading_rad", "walking_speed_m_s", "lap_time_mean_s"};

/// Sessions whose note begins with "run N" and that have a patient's code; of several of one subject and run the newest. A run that does not
/// reach the protocol's laps, or whose C or J_N is not valid, is left out as a whole.
[[nodiscard]] db::Result<Results> evaluate(db::Database& database, const Protocol& protocol);

/// The mean of the subjects present; none without subjects.
[[nodiscard]] std::optional<double> mean_of(const Column& column);

}  // namespace hoist::tool::study
