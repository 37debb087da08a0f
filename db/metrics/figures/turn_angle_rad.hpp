// Mean angle of the turns.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TurnAngle {
  static constexpr MetricInfo kInfo{
      .key = "turn_angle_rad",
      .version = 1,
      .unit = "rad",
      .nullable = true,
      .inputs = "mode psi_rad",
      .formula = "mean |psi at its end - psi at its begin| of these turns",
      .gate = "one turn",
      .source = "after El-Gohary 2014",
      .doc = "Mean angle of the turns",
      .title_en = "Angle of a turn",
      .title_de = "Winkel einer Drehung",
      .group = MetricGroup::turning,
      .screen_unit = "°",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return a.turns.count() == 0 ? no_figure(NoFigure::no_turn) : figure(a.turns.angle_rad / a.turns.count());
  }
};

}  // namespace hoist::db::figures
