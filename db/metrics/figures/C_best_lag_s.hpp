// How much before the path the pelvis turns, by the shift of C_best.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct CorrelationLag {
  static constexpr MetricInfo kInfo{
      .key = "C_best_lag_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad dpsi_rad distance_m start_mark gaps exercise",
      .formula = "the shift of C_best: positive when the pelvis turns before the path does",
      .gate = kTurnedGate,
      .source = "Table II; MATLAB xcorr",
      .doc = "How much before the path the pelvis turns, by the shift of C_best",
      .title_en = "Pelvis turns before the path by",
      .title_de = "Becken dreht vor dem Weg um",
      .group = MetricGroup::path,
      .screen_unit = "s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    return compared(a, a.comparison.best ? std::optional{a.comparison.best->lag * kSample_s} : std::nullopt);
  }
};

}  // namespace hoist::db::figures
