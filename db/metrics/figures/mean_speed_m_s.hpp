// walked_m over motion_s: standing does not count.
#pragma once
#include "db/metrics/figures/motion_s.hpp"
#include "db/metrics/figures/walked_m.hpp"
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct MeanSpeed {
  static constexpr MetricInfo kInfo{
      .key = "mean_speed_m_s",
      .version = 2,
      .unit = "m/s",
      .nullable = true,
      .inputs = "mode speed_m_s standing_still",
      .formula = "walked_m / motion_s",
      .gate = "a wheel turned",
      .source = "decision 21",
      .doc = "walked_m over motion_s: standing does not count",
      .title_en = "Mean speed in motion",
      .title_de = "Mittleres Tempo in Bewegung",
      .group = MetricGroup::dose,
      .screen_unit = "m/s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    const double motion_s = *MotionTime::of(a).value;
    return motion_s > 0 ? figure(*Walked::of(a).value / motion_s) : no_figure(NoFigure::no_motion);
  }
};

}  // namespace hoist::db::figures
