// Mean speed in these bouts: setting off, stopping and standing hardly count.
#pragma once
#include <cmath>

#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct WalkingSpeed {
  static constexpr MetricInfo kInfo{
      .key = "walking_speed_m_s",
      .version = 1,
      .unit = "m/s",
      .nullable = true,
      .inputs = "mode speed_m_s",
      .formula = "mean |v| over all bouts",
      .gate = "one bout",
      .source = "usual in gait training",
      .doc = "Mean speed in these bouts: setting off, stopping and standing hardly count",
      .title_en = "Mean speed while walking",
      .title_de = "Mittleres Gehtempo",
      .group = MetricGroup::dose,
      .screen_unit = "m/s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    double sum = 0;
    for (const Stretch& bout : a.bouts)
      for (std::size_t i = bout.first; i < bout.end; ++i) sum += std::fabs(a.walk.speed_m_s[i]);
    return a.bouts.empty() ? no_figure(NoFigure::no_motion) : figure(sum / static_cast<double>(walking_samples(a)));
  }
};

}  // namespace hoist::db::figures
