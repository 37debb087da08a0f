// Distance from the exercise, root mean square.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct PositionError {
  static constexpr MetricInfo kInfo{
      .key = "rms_position_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "sqrt(mean((x-x_r)^2 + (y-y_r)^2))",
      .gate = kComparedGate,
      .source = "D29",
      .doc = "Distance from the exercise, root mean square",
      .title_en = "Typical path error",
      .title_de = "Typischer Wegfehler",
      .group = MetricGroup::path,
      .screen_unit = "cm",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return compared_along(a, a.comparison.position_rms_m); }
};

}  // namespace hoist::db::figures
