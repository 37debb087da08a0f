// Of that, time in which a wheel turned at 0.02 m/s or more.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct MotionTime {
  static constexpr MetricInfo kInfo{
      .key = "motion_s",
      .version = 1,
      .unit = "s",
      .nullable = false,
      .inputs = "mode standing_still",
      .formula = "samples in which a wheel turned at 0.02 m/s or more × 10 ms",
      .gate = "",
      .source = "decision 21",
      .doc = "Of that, time in which a wheel turned at 0.02 m/s or more",
      .title_en = "Time in motion",
      .title_de = "Zeit in Bewegung",
      .group = MetricGroup::dose,
      .screen_unit = "s",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return figure(static_cast<double>(a.walk.in_motion) * kSample_s); }
};

}  // namespace hoist::db::figures
