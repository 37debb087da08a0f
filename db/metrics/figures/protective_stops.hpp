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
    using contract::Mode;
    const std::vector<Mode>& modes = a.walk.modes;
    if (a.walk.count() == 0) return no_figure(NoFigure::no_motion);
    int stops = 0;
    for (std::size_t i = 0; i + 1 < modes.size(); ++i) {
      const Mode next = modes[i + 1];
      const bool stopped = next == Mode::protective_stop || next == Mode::fault || next == Mode::emergency_stop;
      stops += stopped && contract::kModes[static_cast<std::size_t>(modes[i])].moving ? 1 : 0;
    }
    return counted(a, stops);
  }
};

}  // namespace hoist::db::figures
