// How alike successive steps are, left to right: 1 = all the same.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StepRegularity {
  static constexpr MetricInfo kInfo{
      .key = "step_regularity_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula = "|A(T/2)| / A(0)",
      .gate = kStrideGate,
      .source = "Moe-Nilssen & Helbostad 2004",
      .doc = "How alike successive steps are, left to right: 1 = all the same",
      .title_en = "Regularity of steps",
      .title_de = "Gleichmaß der Schritte",
      .group = MetricGroup::stride,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return strided(a, a.rhythm.step_regularity); }
};

}  // namespace hoist::db::figures
