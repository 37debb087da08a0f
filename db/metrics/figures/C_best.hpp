// The correlation C at the shift in time at which it is largest.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct CorrelationBest {
  static constexpr MetricInfo kInfo{
      .key = "C_best",
      .version = 2,
      .unit = "1",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad dpsi_rad distance_m start_mark gaps exercise",
      .formula = "largest C with one of both shifted by up to 2 s",
      .gate = kTurnedGate,
      .source = "Table II; MATLAB xcorr",
      .doc = "The correlation C at the shift in time at which it is largest",
      .title_en = "Turning with the path, best shift",
      .title_de = "Drehen mit dem Weg, beste Verschiebung",
      .group = MetricGroup::path,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return compared(a, a.comparison.best, &BestLag::c); }
};

}  // namespace hoist::db::figures
