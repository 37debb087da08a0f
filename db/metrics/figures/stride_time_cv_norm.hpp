// How much the time of a stride varies, as a share of its mean.
#pragma once
#include <cmath>

#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StrideVariability {
  static constexpr MetricInfo kInfo{
      .key = "stride_time_cv_norm",
      .version = 1,
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
    if (a.rhythm.why_no_spread != NoFigure::none) return no_figure(a.rhythm.why_no_spread);
    const double middle_s = mean(a.rhythm.strides_s);
    double squares = 0;
    for (const double stride_s : a.rhythm.strides_s) squares += (stride_s - middle_s) * (stride_s - middle_s);
    return figure(std::sqrt(squares / static_cast<double>(a.rhythm.strides_s.size() - 1)) / middle_s);
  }
};

}  // namespace hoist::db::figures
