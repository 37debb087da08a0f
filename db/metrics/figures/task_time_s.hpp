// Time that the task took, from the first movement to its end.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TaskTime {
  static constexpr MetricInfo kInfo{
      .key = "task_time_s",
      .version = 2,
      .unit = "s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad dpsi_rad distance_m start_mark standing_still gaps exercise",
      .formula =
          "from the first sample in which a wheel turned to the end of the task: progress along the line (D27) within 2 cm of its end, so "
          "many times as asked; or the heading so far from that at the first movement; or so far away from its place and back within 0.3 "
          "m; between two recorded steps by proportion",
      .gate = kTaskGate,
      .source = "usual in clinical gait tests",
      .doc = "Time that the task took, from the first movement to its end",
      .title_en = "Time of the task",
      .title_de = "Zeit der Aufgabe",
      .group = MetricGroup::task,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::time_s); }
};

}  // namespace hoist::db::figures
