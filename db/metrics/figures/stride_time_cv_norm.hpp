// How much the time of a stride varies, as a share of its mean.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StrideVariability {
  static constexpr MetricInfo kInfo{
      .key = "stride_time_cv_norm",
      .version = 2,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula =
          "standard deviation (N-1) / mean of the times between upward crossings of x, here about its mean over one stride (2 round(T/2) + "
          "1 samples): each after x < -0.3 rms and more than T/2 after the one before; times over 1.6 T left out",
      .gate = "20 strides; otherwise as stride_time_s",
      .source = "Hausdorff 2001",
      .doc = "How much the time of a stride varies, as a share of its mean",
      .title_en = "Variability of stride time",
      .title_de = "Schwankung der Schrittdauer",
      .group = MetricGroup::stride,
      .screen_unit = "%",
      .digits = 1,
  };
  static Figure of(const Analysis& a) {
    return a.rhythm.why_no_spread == NoFigure::none ? figure(a.rhythm.stride_time_cv) : no_figure(a.rhythm.why_no_spread);
  }
};

}  // namespace hoist::db::figures
