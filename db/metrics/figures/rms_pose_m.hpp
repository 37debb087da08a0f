// What J_N is made of in plain units: distance and heading error together, root mean square, 1 rad as 1 m.
#pragma once
#include <cmath>

#include "db/metrics/figures/J_N.hpp"
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct PoseError {
  static constexpr MetricInfo kInfo{
      .key = "rms_pose_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark gaps exercise",
      .formula = "sqrt(J_N L / N): root mean square of path and heading error together, 1 rad counts as 1 m",
      .gate = kComparedGate,
      .source = "D29",
      .doc = "What J_N is made of in plain units: distance and heading error together, root mean square, 1 rad as 1 m",
      .title_en = "Typical error, path and heading",
      .title_de = "Typischer Fehler, Weg und Richtung",
      .group = MetricGroup::path,
      .screen_unit = "cm",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    const Figure j = PathError::of(a);
    return j.value ? figure(std::sqrt(*j.value * a.comparison.ise->length_m / static_cast<double>(a.walk.samples))) : j;
  }
};

}  // namespace hoist::db::figures
