// Time of a stride (two steps), from the sideways sway of the harness.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StrideTime {
  static constexpr MetricInfo kInfo{
      .key = "stride_time_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula =
          "T: first peak of A(m) = sum x_i x_(i+m) / (N-m) at 0.6 to 3.5 s that has 0.85 of the highest, by a parabola; x is dy minus its "
          "mean over 301 samples around, in bouts of 9 s or more, without their first and last 2 s",
      .gate = kStrideGate,
      .source = "Moe-Nilssen & Helbostad 2004",
      .doc = "Time of a stride (two steps), from the sideways sway of the harness",
      .title_en = "Time of a stride",
      .title_de = "Dauer eines Doppelschritts",
      .group = MetricGroup::stride,
      .screen_unit = "s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return strided(a, a.rhythm.stride_s); }
};

}  // namespace hoist::db::figures
