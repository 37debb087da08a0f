// Progress along the exercise.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct ReferenceLength {
  static constexpr MetricInfo kInfo{
      .key = "reference_length_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "length of the line through the reference samples",
      .gate = kComparedGate,
      .source = "equation 24, L",
      .doc = "Progress along the exercise",
      .title_en = "Way along the exercise",
      .title_de = "Weg entlang der Übung",
      .group = MetricGroup::path,
      .screen_unit = "m",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return compared(a, a.comparison.ise, &NormalisedIse::length_m); }
};

}  // namespace hoist::db::figures
