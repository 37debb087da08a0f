// Shortest time for once along the exercise.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct LapTimeBest {
  static constexpr MetricInfo kInfo{
      .key = "lap_time_best_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "shortest of the lap times",
      .gate = kLapGate,
      .source = "usual in path following",
      .doc = "Shortest time for once along the exercise",
      .title_en = "Time for one lap, shortest",
      .title_de = "Zeit für eine Runde, kürzeste",
      .group = MetricGroup::path,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return lapped(a, a.comparison.lap_best_s); }
};

}  // namespace hoist::db::figures
