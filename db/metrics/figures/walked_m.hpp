// Way walked, forward and backward: absolute speed times 10 ms, summed over the time under way.
#pragma once
#include <cmath>

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
  static Figure of(const Analysis& a) {
    double walked_m = 0;
    for (const double speed : a.walk.speed_m_s) walked_m += std::fabs(speed) * kSample_s;
    return figure(walked_m);
  }
};

}  // namespace hoist::db::figures
