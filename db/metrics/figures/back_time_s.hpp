// Walk, turn, walk back: time of the way back.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct BackTime {
  static constexpr MetricInfo kInfo{
      .key = "back_time_s",
      .version = 2,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark standing_still gaps exercise",
      .formula =
          "from the end of the turn to the end of the task: 0.3 m or less from the place of the first movement, both "
          "between two recorded steps by proportion",
      .gate = kPhaseGate,
      .source = "after Podsiadlo & Richardson 1991, without standing up and sitting down",
      .doc = "Walk, turn, walk back: time of the way back",
      .title_en = "Time of the way back",
      .title_de = "Zeit für den Rückweg",
      .group = MetricGroup::task,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::back_s, a.task.why_no_phases); }
};

}  // namespace hoist::db::figures
