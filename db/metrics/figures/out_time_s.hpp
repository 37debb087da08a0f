// Walk, turn, walk back: time of the way out.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct OutTime {
  static constexpr MetricInfo kInfo{
      .key = "out_time_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark standing_still gaps exercise",
      .formula =
          "from the first sample in which a wheel turned to the last before the turn in which the heading is within 20 degrees of the "
          "first one",
      .gate = kPhaseGate,
      .source = "after Podsiadlo & Richardson 1991, without standing up and sitting down",
      .doc = "Walk, turn, walk back: time of the way out",
      .title_en = "Time of the way out",
      .title_de = "Zeit für den Hinweg",
      .group = MetricGroup::task,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::out_s, a.task.why_no_phases); }
};

}  // namespace hoist::db::figures
