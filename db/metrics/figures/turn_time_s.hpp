// Mean time of the turns.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TurnTime {
  static constexpr MetricInfo kInfo{
      .key = "turn_time_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode psi_rad",
      .formula = "mean length of these turns",
      .gate = "one turn",
      .source = "after El-Gohary 2014",
      .doc = "Mean time of the turns",
      .title_en = "Time of a turn",
      .title_de = "Dauer einer Drehung",
      .group = MetricGroup::turning,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) {
    return a.turns.count() == 0 ? no_figure(NoFigure::no_turn) : figure(a.turns.time_s / a.turns.count());
  }
};

}  // namespace hoist::db::figures
