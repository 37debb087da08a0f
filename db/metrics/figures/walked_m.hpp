// Way walked, forward and backward: absolute speed times 10 ms, summed over the time under way.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Walked {
  static constexpr MetricInfo kInfo{
      .key = "walked_m",
      .version = 1,
      .unit = "m",
      .nullable = false,
      .inputs = "mode speed_m_s",
      .formula = "sum |v| × 10 ms",
      .gate = "",
      .source = "decision 86",
      .doc = "Way walked, forward and backward: absolute speed times 10 ms, summed over the time under way",
      .title_en = "Distance",
      .title_de = "Strecke",
      .group = MetricGroup::dose,
      .screen_unit = "m",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return figure(a.walk.walked_m); }
};

}  // namespace hoist::db::figures
