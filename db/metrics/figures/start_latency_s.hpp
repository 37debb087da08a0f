// From leaning to moving off: how long until the hoist follows at 0.05 m/s.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StartLatency {
  static constexpr MetricInfo kInfo{
      .key = "start_latency_s",
      .version = 2,
      .unit = "s",
      .nullable = true,
      .inputs = "mode lean_norm dx_m dy_m speed_m_s parameter_version gaps parameters",
      .formula =
          "mean over the bouts led by the patient, begun after 0.5 s at 0.05 m/s or less: from the sample in which |lean_norm| passes "
          "lean_dead_band_norm to the begin of the bout",
      .gate = "the patient led; settings not changed since the session's begin; a start from rest",
      .source = "control feel",
      .doc = "From leaning to moving off: how long until the hoist follows at 0.05 m/s",
      .title_en = "Delay of setting off",
      .title_de = "Verzögerung beim Losgehen",
      .group = MetricGroup::control,
      .screen_unit = "s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) { return mean_of_lead(a, a.lead.latency_s, NoFigure::no_start); }
};

}  // namespace hoist::db::figures
