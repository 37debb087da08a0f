// Distance across the path, root mean square.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct LateralError {
  static constexpr MetricInfo kInfo{
      .key = "rms_lateral_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "sqrt(mean(e^2)), e = (y-y_r) cos psi_r - (x-x_r) sin psi_r",
      .gate = kComparedGate,
      .source = "equation 24",
      .doc = "Distance across the path, root mean square",
      .title_en = "Typical sideways error",
      .title_de = "Typischer seitlicher Fehler",
      .group = MetricGroup::path,
      .screen_unit = "cm",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return compared_along(a, a.comparison.lateral_rms_m); }
};

}  // namespace hoist::db::figures
