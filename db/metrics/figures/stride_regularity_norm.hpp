// How alike successive strides are: 1 = all the same.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StrideRegularity {
  static constexpr MetricInfo kInfo{
      .key = "stride_regularity_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula = "A(T) / A(0)",
      .gate = kStrideGate,
      .source = "Moe-Nilssen & Helbostad 2004",
      .doc = "How alike successive strides are: 1 = all the same",
      .title_en = "Regularity of strides",
      .title_de = "Gleichmaß der Doppelschritte",
      .group = MetricGroup::stride,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return strided(a, a.rhythm.stride_regularity); }
};

}  // namespace hoist::db::figures
