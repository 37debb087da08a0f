// Other parameters tried on a twin: the fitted patient walks the exercise of its session through the shipped core, the nodes' firmware, the
// bus and the simulated machine, before and after the change, with the same seeds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "deploy/tools/hoist/parameter_change.hpp"
#include "deploy/tools/hoist/twin/fit.hpp"

namespace hoist::tool::twin {

/// What is told of a walk, in SI units. Those of db/metrics have its keys.
enum class Told : std::uint8_t {
  c,
  j_n,
  rms_lateral_m,
  walking_speed_m_s,
  lap_time_mean_s,
  speed_rms_m_s,
  lean_mean_norm,
  turn_mean_norm,
  stop_m
};
struct ToldInfo {
  std::string_view name, unit, doc;
};
inline constexpr std::array kTold{
    ToldInfo{"C", "", "pelvis turns where the path turns"},
    ToldInfo{"J_N", "", "error of the path per metre"},
    ToldInfo{"rms_lateral_m", "m", "distance across the path"},
    ToldInfo{"walking_speed_m_s", "m/s", "mean speed of walking"},
    ToldInfo{"lap_time_mean_s", "s", "time for once along the exercise"},
    ToldInfo{"speed_rms_m_s", "m/s", "root mean square of the speed in motion"},
    ToldInfo{"lean_mean_norm", "", "mean lean while walking, share of full"},
    ToldInfo{"turn_mean_norm", "", "mean turn of the pelvis while walking, share of full"},
    ToldInfo{"stop_distance_m", "m", "longest way to a stop by STOP"},
};
/// So many of them, from the first, are figures of db/metrics.
inline constexpr std::size_t kFiguresTold = 5;
using Outcome = std::array<std::optional<double>, kTold.size()>;

/// A walk in virtual time, or why it did not come to its end.
struct WalkOutcome {
  Outcome told{};
  std::string unfinished;
};
[[nodiscard]] Outcome outcome_of(const std::vector<contract::TickRecord>& records, const contract::ReferencePath& path);
/// `walker` on the scenario's line with these parameters; the same seed gives the same walk.
[[nodiscard]] WalkOutcome walk_twin(const sim::PatientParams& walker, const sim::Scenario& scenario, const contract::Params& params,
                                    std::uint64_t seed);

/// Of the walks that came to their end.
struct Spread {
  double mean = 0, spread = 0;  ///< standard deviation (n - 1)
  int walks = 0;                ///< with this figure
};
[[nodiscard]] Spread spread_of(std::span<const WalkOutcome> walks, std::size_t told);
/// Of the differences of both, walk by walk: only where both have the figure.
[[nodiscard]] Spread change_of(std::span<const WalkOutcome> before, std::span<const WalkOutcome> after, std::size_t told);
/// A change that the spread over walks does not explain: more than twice its standard error, from five walks on.
[[nodiscard]] bool clear(const Spread& change);

/// How near a twin's own walks must come to a recorded one.
inline constexpr double kCheckC = 0.05, kCheckSpeed_norm = 0.10;
/// A recorded walk, and several walks of the twin along the same exercise with the same parameters: sway meets bends differently in each,
/// so the mean is compared.
struct Check {
  double c_recorded = 0, speed_rms_recorded_m_s = 0;
  Spread c_twin, speed_rms_twin_m_s;
  std::string unfinished;  ///< why the twin's walks did not come to their end; empty when they did
  [[nodiscard]] bool holds() const;
};
[[nodiscard]] Check check_twin(const sim::PatientParams& twin, const LedSession& session, std::uint64_t seed);

/// Patients as likely as the fit leaves them: the first is the fit itself, the others are drawn from its spread and correlations.
[[nodiscard]] std::vector<sim::PatientParams> likely_patients(const Fit& fit, int count, std::uint64_t seed);

struct WhatIf {
  std::vector<WalkOutcome> before, after;  ///< with the same patients and seeds
};
[[nodiscard]] WhatIf what_if(const Fit& fit, const sim::Scenario& scenario, const contract::Params& before, const contract::Params& after,
                             int walks, std::uint64_t seed);

}  // namespace hoist::tool::twin
