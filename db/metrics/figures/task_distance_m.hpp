// Way walked in the time of the task.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TaskDistance {
  static constexpr MetricInfo kInfo{
      .key = "task_distance_m",
      .version = 1,
      .unit = "m",
      .nullable = true,
      .inputs = "mode speed_m_s distance_m start_mark standing_still gaps exercise",
      .formula = "sum |v| × 10 ms from the first sample in which a wheel turned, over the time of the task; standing counts as time",
      .gate = kTaskGate,
      .source = "2- and 6-minute walk: ATS 2002",
      .doc = "Way walked in the time of the task",
      .title_en = "Distance of the task",
      .title_de = "Strecke der Aufgabe",
      .group = MetricGroup::task,
      .screen_unit = "m",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::distance_m); }
};

}  // namespace hoist::db::figures
