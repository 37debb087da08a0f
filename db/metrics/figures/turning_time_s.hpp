// Walk, turn, walk back: time of the turn.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TurningTime {
  static constexpr MetricInfo kInfo{
      .key = "turning_time_s",
      .version = 2,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad distance_m start_mark standing_still gaps exercise",
      .formula = "from the end of the way out to the heading 160 degrees off the first one, between two recorded steps by proportion",
      .gate = kPhaseGate,
      .source = "after Podsiadlo & Richardson 1991, without standing up and sitting down",
      .doc = "Walk, turn, walk back: time of the turn",
      .title_en = "Time of the turn",
      .title_de = "Zeit für die Wende",
      .group = MetricGroup::task,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::turning_s, a.task.why_no_phases); }
};

}  // namespace hoist::db::figures
