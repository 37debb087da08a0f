// Steps taken in bouts of walking, two to a stride.
#pragma once
#include <cmath>

#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Steps {
  static constexpr MetricInfo kInfo{
      .key = "steps",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula = "2 × time in bouts / stride time, to the nearest whole number",
      .gate = kStrideGate,
      .source = "two steps to a stride",
      .doc = "Steps taken in bouts of walking, two to a stride",
      .title_en = "Steps",
      .title_de = "Schritte",
      .group = MetricGroup::dose,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return strided(a, std::round(2.0 * static_cast<double>(walking_samples(a)) * kSample_s / a.rhythm.stride_s));
  }
};

}  // namespace hoist::db::figures
