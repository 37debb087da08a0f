// Squared error of the walk over time per metre of path: J_N without the sampling rate.
#pragma once
#include "db/metrics/figures/J_N.hpp"
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct PathErrorTime {
  static constexpr MetricInfo kInfo{
      .key = "J_T_m_s",
      .version = 1,
      .unit = "m s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "J_N / 100 Hz",
      .gate = kComparedGate,
      .source = "equation 24",
      .doc = "Squared error of the walk over time per metre of path: J_N without the sampling rate",
      .title_en = "Path error over time",
      .title_de = "Wegfehler über die Zeit",
      .group = MetricGroup::path,
      .screen_unit = "m s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    const Figure j = PathError::of(a);
    return j.value ? figure(*j.value / kMetricRate_hz) : j;
  }
};

}  // namespace hoist::db::figures
