// Squared error of the walk per metre of path, at 100 Hz: it grows with slowness, too.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct PathError {
  static constexpr MetricInfo kInfo{
      .key = "J_N",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "(1/L) sum((x-x_r)^2 + (y-y_r)^2 + (psi-psi_r)^2) over the samples at 100 Hz, 1 m^2 = 1 rad^2",
      .gate = kComparedGate,
      .source = "equation 24, D29",
      .doc = "Squared error of the walk per metre of path, at 100 Hz: it grows with slowness, too",
      .title_en = "Path error score",
      .title_de = "Wegfehler, Punktzahl",
      .group = MetricGroup::path,
      .screen_unit = "",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return compared(a, a.comparison.ise, &NormalisedIse::j); }
};

}  // namespace hoist::db::figures
