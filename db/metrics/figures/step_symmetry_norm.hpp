// 1 = left and right steps are as alike as successive strides.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StepSymmetry {
  static constexpr MetricInfo kInfo{
      .key = "step_symmetry_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula = "step_regularity_norm / stride_regularity_norm",
      .gate = kStrideGate,
      .source = "Moe-Nilssen & Helbostad 2004",
      .doc = "1 = left and right steps are as alike as successive strides",
      .title_en = "Step against stride regularity",
      .title_de = "Gleichmaß Schritt zu Doppelschritt",
      .group = MetricGroup::stride,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return strided(a, a.rhythm.step_regularity / a.rhythm.stride_regularity); }
};

}  // namespace hoist::db::figures
