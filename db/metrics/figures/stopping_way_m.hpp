// Way that the hoist rolls after the patient has leant back.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct StoppingWay {
  static constexpr MetricInfo kInfo{
      .key = "stopping_way_m",
      .version = 2,
      .unit = "m",
      .nullable = true,
      .inputs = "mode lean_norm dx_m dy_m speed_m_s parameter_version gaps parameters",
      .formula =
          "mean over the bouts led by the patient and ended by the lean: sum |v| × 10 ms from the last return of the lean into "
          "lean_dead_band_norm to 0.01 m/s",
      .gate = "the patient led; settings not changed since the session's begin; a stop by the lean",
      .source = "control feel",
      .doc = "Way that the hoist rolls after the patient has leant back",
      .title_en = "Stopping distance",
      .title_de = "Anhalteweg",
      .group = MetricGroup::control,
      .screen_unit = "cm",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return mean_of_lead(a, a.lead.stopping_m, NoFigure::no_stop); }
};

}  // namespace hoist::db::figures
