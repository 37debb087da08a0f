// Mean time for once along the exercise, pauses included.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct LapTimeMean {
  static constexpr MetricInfo kInfo{
      .key = "lap_time_mean_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula =
          "mean time from leaving the start (by 1 cm) until progress is a multiple of the exercise's length (less 1 cm), pauses included",
      .gate = kLapGate,
      .source = "usual in path following",
      .doc = "Mean time for once along the exercise, pauses included",
      .title_en = "Time for one lap, mean",
      .title_de = "Zeit für eine Runde, Mittel",
      .group = MetricGroup::path,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return lapped(a, a.comparison.lap_mean_s); }
};

}  // namespace hoist::db::figures
