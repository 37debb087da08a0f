// Largest absolute speed while under way.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct MaxSpeed {
  static constexpr MetricInfo kInfo{
      .key = "max_speed_m_s",
      .version = 1,
      .unit = "m/s",
      .nullable = false,
      .inputs = "mode speed_m_s",
      .formula = "largest |v|",
      .gate = "",
      .source = "decision 8",
      .doc = "Largest absolute speed while under way",
      .title_en = "Largest speed",
      .title_de = "Größtes Tempo",
      .group = MetricGroup::dose,
      .screen_unit = "m/s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return figure(a.walk.fastest_m_s); }
};

}  // namespace hoist::db::figures
