// The recorded runs of a study, evaluated by the figures that everything else shows (db/summary/session_metrics.hpp).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/metrics/no_figure.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"

namespace hoist::tool::study {

/// Of a run, by subject: what the tables need; absent where the run is.
using Column = std::vector<std::optional<double>>;

/// A run that does not count: a figure is not valid, or too few laps were walked.
struct LeftOut {
  std::string subject;
  int run = 0;
  std::string_view figure;  ///< "C" or "J_N"; empty: too few laps
  db::NoFigure why = db::NoFigure::none;
  double laps = 0;  ///< walked
};
[[nodiscard]] std::string sentence(const LeftOut& one);

/// Which of a file's sessions are the study's.
struct Selection {
  std::optional<std::int64_t> study = {};  ///< those of this study of virtual subjects
  std::optional<std::string> tag = {};     ///< those whose note holds this word
  std::vector<db::SessionId> only = {};    ///< sorted: none but these; empty: any
};

struct Results {
  std::vector<std::string> subjects;                                  ///< codes, in the order of the rows
  std::map<std::pair<std::size_t, int>, db::SessionId> runs;          ///< session of a row and a run's number
  std::map<std::string, std::map<int, Column>, std::less<>> columns;  ///< by figure and run
  std::vector<LeftOut> left_out;                                      ///< runs that do not count, and why

  [[nodiscard]] const Column& column(std::string_view figure, int run) const { return columns.find(figure)->second.at(run); }
};

/// The figures that a study tells.
inline constexpr std::string_view kTold[] = {
    "C", "C_best", "J_N", "rms_position_m", "rms_heading_rad", "walking_speed_m_s", "lap_time_mean_s"};

/// Sessions of people whose note begins with "run N" and that have a patient's code; of several of one subject and run the newest. With
/// `study`: the sessions of that study, by their subject and run. A run that does not reach the protocol's laps, or whose C or J_N is not valid,
/// is left out as a whole.
[[nodiscard]] db::Result<Results> evaluate(db::Database& database, const Protocol& protocol, const Selection& selection = {});

/// The mean of the subjects present; none without subjects.
[[nodiscard]] std::optional<double> mean_of(const Column& column);

}  // namespace hoist::tool::study
