// Logarithmic dimensionless jerk of the forward speed of the longest bout: nearer to 0 is smoother.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Ldlj {
  static constexpr MetricInfo kInfo{
      .key = "ldlj",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s",
      .formula =
          "-ln(T^3 / v_peak^2 sum((v_(i+1) - 2 v_i + v_(i-1))^2 / dt^4) dt), v: means over dt = 0.1 s of the longest bout, T: their number "
          "times dt",
      .gate = kSmoothGate,
      .source = "Balasubramanian 2012, 2015",
      .doc = "Logarithmic dimensionless jerk of the forward speed of the longest bout: nearer to 0 is smoother",
      .title_en = "Smoothness of speed, LDLJ",
      .title_de = "Gleichmaß des Tempos, LDLJ",
      .group = MetricGroup::smoothness,
      .screen_unit = "",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return smooth(a, &ldlj); }
};

}  // namespace hoist::db::figures
