// Spectral arc length of the forward speed of the longest bout: nearer to 0 is smoother.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Sparc {
  static constexpr MetricInfo kInfo{
      .key = "sparc",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s",
      .formula =
          "-sum sqrt((df / (f_2 - f_1))^2 + (dV)^2) over the spectrum V of v, largest value 1, from f_1 to f_2: its first and last value "
          "of 0.05 or more up to 10 Hz; longest bout, padded to 16 times the next power of two",
      .gate = kSmoothGate,
      .source = "Balasubramanian 2012, 2015",
      .doc = "Spectral arc length of the forward speed of the longest bout: nearer to 0 is smoother",
      .title_en = "Smoothness of speed, SPARC",
      .title_de = "Gleichmaß des Tempos, SPARC",
      .group = MetricGroup::smoothness,
      .screen_unit = "",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return smooth(a, &sparc); }
};

}  // namespace hoist::db::figures
