// Steps a minute, two to a stride.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Cadence {
  static constexpr MetricInfo kInfo{
      .key = "cadence_steps_min",
      .version = 1,
      .unit = "1/min",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula = "120 / T",
      .gate = kStrideGate,
      .source = "Moe-Nilssen & Helbostad 2004",
      .doc = "Steps a minute, two to a stride",
      .title_en = "Steps a minute",
      .title_de = "Schritte je Minute",
      .group = MetricGroup::stride,
      .screen_unit = "/min",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return strided(a, 120.0 / a.rhythm.stride_s); }
};

}  // namespace hoist::db::figures
