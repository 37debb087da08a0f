// How often the hoist stopped by itself or by the emergency stop.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct ProtectiveStops {
  static constexpr MetricInfo kInfo{
      .key = "protective_stops",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode gaps",
      .formula = "changes from a moving mode to PROTECTIVE_STOP, FAULT or EMERGENCY_STOP",
      .gate = "under way; at most 0.5 s missing",
      .source = "usual in gait training",
      .doc = "How often the hoist stopped by itself or by the emergency stop",
      .title_en = "Protective stops",
      .title_de = "Schutzhalte",
      .group = MetricGroup::dose,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return a.walk.samples == 0 ? no_figure(NoFigure::no_motion) : counted(a, a.walk.modes.protective_stops());
  }
};

}  // namespace hoist::db::figures
