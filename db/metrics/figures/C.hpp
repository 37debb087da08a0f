// Correlation of pelvis turn and path turn at zero lag, -1 to 1: whether the patient turns where the path turns. No measure of
// distance from the path.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Correlation {
  static constexpr MetricInfo kInfo{
      .key = "C",
      .version = 2,
      .unit = "1",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad dpsi_rad distance_m start_mark gaps exercise",
      .formula =
          "sum(dpsi Omega_r) / sqrt(sum dpsi^2 sum Omega_r^2), means not removed; Omega_r is the turn rate of the nearest place on the "
          "exercise",
      .gate = kTurnedGate,
      .source = "Table II, D27, D28",
      .doc =
          "Correlation of pelvis turn and path turn at zero lag, -1 to 1: whether the patient turns where the path turns. No measure of "
          "distance from the path",
      .title_en = "Turning with the path",
      .title_de = "Drehen mit dem Weg",
      .group = MetricGroup::path,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return compared(a, a.comparison.c); }
};

}  // namespace hoist::db::figures
