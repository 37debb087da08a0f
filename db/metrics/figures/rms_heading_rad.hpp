// Angle against the exercise, root mean square.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct HeadingError {
  static constexpr MetricInfo kInfo{
      .key = "rms_heading_rad",
      .version = 1,
      .unit = "rad",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "sqrt(mean((psi-psi_r)^2)), wrapped to half a turn",
      .gate = kComparedGate,
      .source = "D29",
      .doc = "Angle against the exercise, root mean square",
      .title_en = "Typical heading error",
      .title_de = "Typischer Richtungsfehler",
      .group = MetricGroup::path,
      .screen_unit = "°",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return compared_along(a, a.comparison.heading_rms_rad); }
};

}  // namespace hoist::db::figures
