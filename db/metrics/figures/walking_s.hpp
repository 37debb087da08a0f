// Time in bouts of more than 0.05 m/s that last a second or longer.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct WalkingTime {
  static constexpr MetricInfo kInfo{
      .key = "walking_s",
      .version = 1,
      .unit = "s",
      .nullable = false,
      .inputs = "mode speed_m_s",
      .formula = "length of all bouts",
      .gate = "",
      .source = "usual in gait training",
      .doc = "Time in bouts of more than 0.05 m/s that last a second or longer",
      .title_en = "Time walking",
      .title_de = "Gehzeit",
      .group = MetricGroup::dose,
      .screen_unit = "s",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return figure(static_cast<double>(a.bouts.samples) * kSample_s); }
};

}  // namespace hoist::db::figures
