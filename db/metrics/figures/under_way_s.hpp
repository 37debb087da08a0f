// Time in which the hoist was under way (a mode in which the wheels may turn), standing included.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct UnderWay {
  static constexpr MetricInfo kInfo{
      .key = "under_way_s",
      .version = 1,
      .unit = "s",
      .nullable = false,
      .inputs = "mode",
      .formula = "samples in a mode in which the wheels may turn × 10 ms",
      .gate = "",
      .source = "decision 8",
      .doc = "Time in which the hoist was under way (a mode in which the wheels may turn), standing included",
      .title_en = "Total time",
      .title_de = "Gesamtzeit",
      .group = MetricGroup::dose,
      .screen_unit = "s",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return figure(static_cast<double>(a.walk.samples) * kSample_s); }
};

}  // namespace hoist::db::figures
