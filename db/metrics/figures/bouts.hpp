// Number of bouts of walking: a second or longer at more than 0.05 m/s.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Bouts {
  static constexpr MetricInfo kInfo{
      .key = "bouts",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s gaps",
      .formula = "bouts: |v| > 0.05 m/s for 1 s or longer",
      .gate = "at most 0.5 s missing",
      .source = "usual in gait training",
      .doc = "Number of bouts of walking: a second or longer at more than 0.05 m/s",
      .title_en = "Bouts of walking",
      .title_de = "Gehphasen",
      .group = MetricGroup::dose,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return counted(a, a.bouts.count); }
};

}  // namespace hoist::db::figures
