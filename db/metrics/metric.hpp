// What a figure's file says of it, and what the files share.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "db/metrics/analysis.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/smoothness.hpp"

namespace hoist::db {

/// Where screens and pages show a figure.
enum class MetricGroup : std::uint8_t { task, path, dose, stride, smoothness, turning, control };
struct MetricGroupInfo {
  std::string_view name, title_en, title_de;
};
inline constexpr std::array kMetricGroups{MetricGroupInfo{"task", "Task", "Aufgabe"},
                                          MetricGroupInfo{"path", "Path", "Weg"},
                                          MetricGroupInfo{"dose", "Amount", "Umfang"},
                                          MetricGroupInfo{"stride", "Steps", "Schritte"},
                                          MetricGroupInfo{"smoothness", "Smoothness", "Gleichmaß"},
                                          MetricGroupInfo{"turning", "Turning", "Drehen"},
                                          MetricGroupInfo{"control", "Leading the hoist", "Führen des Geräts"}};

struct MetricInfo {
  std::string_view key;  ///< its name in JSON; with the version it names one definition
  unsigned version;      ///< raised when the same recording gives another answer
  std::string_view unit;
  bool nullable;            ///< some sessions have none
  std::string_view inputs;  ///< what it is computed from, a blank between: recorded columns, "gaps", "exercise" (with its task),
                            ///< "parameters" (those of WalkSettings). x_m, y_m and psi_rad stand for
                            ///< their fused_ twins where these are recorded; "mode" belongs to all, it says which steps count
  std::string_view formula;
  std::string_view gate;  ///< what a session must have; the reasons when it has not: no_figure.def
  std::string_view source;
  std::string_view doc;
  std::string_view title_en, title_de;
  MetricGroup group;
  std::string_view screen_unit;  ///< on screens: the unit, or cm for m, ° for rad, % for a share
  int digits;                    ///< behind the point, on screens
};

/// What a value is multiplied by for the screen.
[[nodiscard]] constexpr double screen_factor(const MetricInfo& metric) {
  if (metric.screen_unit == metric.unit || metric.screen_unit.empty() || metric.screen_unit == "/min") return 1.0;
  return metric.screen_unit == "°" ? 1.0 / kDegree_rad : 100.0;
}

namespace figures {

inline constexpr std::string_view kComparedGate =
    "an exercise; one walk, begun at its mark or at a clear place of the exercise; at most 0.5 s missing";
inline constexpr std::string_view kTurnedGate =
    "an exercise; one walk, begun at its mark or at a clear place of the exercise; at most 0.5 s missing; path and pelvis turned";
inline constexpr std::string_view kLapGate =
    "an exercise; one walk, begun at its mark or at a clear place of the exercise; at most 0.5 s missing; one lap walked";
inline constexpr std::string_view kStrideGate = "8 steady strides; sway of 2 mm or more, root mean square; A(T) of 0.3 A(0) or more";
inline constexpr std::string_view kSmoothGate = "one bout; the longest has at most 600 s";
inline constexpr std::string_view kTurnCountGate = "at most 0.5 s missing";
inline constexpr std::string_view kTurns =
    "turns: rate (heading over 0.5 s) beyond 1 deg/s of one sign, less than 0.3 s bridged, with a peak beyond 15 deg/s and more than 45 "
    "deg";

inline constexpr std::string_view kTaskGate =
    "a repetition of such a task, from its start mark to its end; one walk; at most 0.5 s missing";
inline constexpr std::string_view kPhaseGate =
    "a repetition of such a task, from its start mark to its end; one walk; at most 0.5 s missing; turned by 160 degrees before the end";
inline constexpr std::string_view kLedGate = "the patient led; settings not changed since the session's begin";

/// Of a task's result; `absent`: why a task that was done has none.
inline Figure of_task(const Analysis& a, std::optional<double> TaskResult::*member, NoFigure absent = NoFigure::no_task) {
  if (a.task.why != NoFigure::none) return no_figure(a.task.why);
  const std::optional<double>& value = a.task.*member;
  return value ? figure(*value) : no_figure(absent);
}
/// Of the comparison with the exercise: a number that is there, or why it is not.
inline Figure compared(const Analysis& a, const std::optional<double>& value) {
  if (a.comparison.why != NoFigure::none) return no_figure(a.comparison.why);
  return value ? figure(*value) : no_figure(NoFigure::too_short);
}
template <class Part>
Figure compared(const Analysis& a, const std::optional<Part>& part, double Part::*member) {
  return compared(a, part ? std::optional{(*part).*member} : std::nullopt);
}
/// Only where the reference covered a length.
inline Figure compared_along(const Analysis& a, double value) {
  return compared(a, a.comparison.ise ? std::optional{value} : std::nullopt);
}
/// A count is one only where all of the walk was recorded.
inline Figure counted(const Analysis& a, int count) {
  return missing_s(a.walk) > kMissingMost_s ? no_figure(NoFigure::part_missing) : figure(count);
}
inline Figure strided(const Analysis& a, double value) { return a.rhythm.why == NoFigure::none ? figure(value) : no_figure(a.rhythm.why); }
inline Figure smooth(const Analysis& a, std::optional<double> (*of)(std::span<const double>)) {
  const std::span<const double> bout = a.bouts.longest_m_s;
  if (bout.empty()) return no_figure(why_no_bout(a.walk));
  if (static_cast<double>(bout.size()) * kSample_s > kSmoothMost_s) return no_figure(NoFigure::too_long);
  const std::optional<double> value = of(bout);
  return value ? figure(*value) : no_figure(NoFigure::too_short);
}
inline Figure lapped(const Analysis& a, const std::optional<double>& value_s) {
  if (a.comparison.why != NoFigure::none) return no_figure(a.comparison.why);
  return value_s ? figure(*value_s) : no_figure(NoFigure::no_lap);
}
/// The mean of what the lead has some of.
inline Figure mean_of_lead(const Analysis& a, const MeanOf& values, NoFigure none) {
  if (a.lead.why != NoFigure::none) return no_figure(a.lead.why);
  return values.count == 0 ? no_figure(none) : figure(values.value());
}

}  // namespace figures
}  // namespace hoist::db
