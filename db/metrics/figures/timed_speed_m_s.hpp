// Mean speed over the timed middle of the line: setting off and stopping do not count.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TimedSpeed {
  static constexpr MetricInfo kInfo{
      .key = "timed_speed_m_s",
      .version = 2,
      .unit = "m/s",
      .nullable = true,
      .inputs = "mode x_m y_m psi_rad dpsi_rad distance_m start_mark standing_still gaps exercise",
      .formula =
          "the line without its edges / time from passing the first edge to passing the second, by progress along the line (D27), "
          "between two recorded steps by proportion",
      .gate = kTaskGate,
      .source = "10 m walk test: Bohannon 1997",
      .doc = "Mean speed over the timed middle of the line: setting off and stopping do not count",
      .title_en = "Speed over the timed part",
      .title_de = "Tempo auf der Messstrecke",
      .group = MetricGroup::task,
      .screen_unit = "m/s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return of_task(a, &TaskResult::timed_speed_m_s); }
};

}  // namespace hoist::db::figures
