// Mean speed in these bouts: setting off, stopping and standing hardly count.
#pragma once
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
    return a.bouts.count == 0 ? no_figure(why_no_bout(a.walk)) : figure(a.bouts.walked_m_s / static_cast<double>(a.bouts.samples));
  }
};

}  // namespace hoist::db::figures
