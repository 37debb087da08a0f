// Largest distance from the exercise.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct CrossTrackMax {
  static constexpr MetricInfo kInfo{
      .key = "cross_track_max_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "largest sqrt((x-x_r)^2 + (y-y_r)^2)",
      .gate = kComparedGate,
      .source = "usual in path following",
      .doc = "Largest distance from the exercise",
      .title_en = "Largest distance from the path",
      .title_de = "Größter Abstand vom Weg",
      .group = MetricGroup::path,
      .screen_unit = "cm",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return compared_along(a, a.comparison.distance_max_m); }
};

}  // namespace hoist::db::figures
