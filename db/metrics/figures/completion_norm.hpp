// Share of the exercise that was walked; laps beyond the first count on.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Completion {
  static constexpr MetricInfo kInfo{
      .key = "completion_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "progress along the exercise / its length; 1 = once, laps count on",
      .gate = kComparedGate,
      .source = "usual in path following",
      .doc = "Share of the exercise that was walked; laps beyond the first count on",
      .title_en = "Exercise walked",
      .title_de = "Übung gegangen",
      .group = MetricGroup::path,
      .screen_unit = "%",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    if (a.comparison.why != NoFigure::none) return no_figure(a.comparison.why);
    return figure((a.comparison.end_m - a.comparison.start_m) / a.comparison.lap_m);
  }
};

}  // namespace hoist::db::figures
