// How much longer the harness takes from right to left than back, as a share of their mean.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StepAsymmetry {
  static constexpr MetricInfo kInfo{
      .key = "step_asymmetry_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s dy_m",
      .formula =
          "2 (L - R) / (L + R), L: from -rms to rms of the mean stride on the way from its right-most to its left-most place, R: from rms "
          "to -rms on the way back; the strides of stride_time_cv_norm drawn to 100 points, their mean smoothed to 4 harmonics",
      .gate = "20 strides; otherwise as stride_time_s",
      .source = "Robinson 1987",
      .doc = "How much longer the harness takes from right to left than back, as a share of their mean",
      .title_en = "Asymmetry of steps",
      .title_de = "Asymmetrie der Schritte",
      .group = MetricGroup::stride,
      .screen_unit = "%",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return a.rhythm.why_no_spread == NoFigure::none ? figure(a.rhythm.asymmetry) : no_figure(a.rhythm.why_no_spread);
  }
};

}  // namespace hoist::db::figures
