// Motion that is not recorded: all figures are of the rest.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct MissingTime {
  static constexpr MetricInfo kInfo{
      .key = "missing_s",
      .version = 1,
      .unit = "s",
      .nullable = false,
      .inputs = "mode gaps",
      .formula = "steps in gaps beside a moving sample × 10 ms",
      .gate = "",
      .source = "decision 14",
      .doc = "Motion that is not recorded: all figures are of the rest",
      .title_en = "Not recorded",
      .title_de = "Nicht aufgezeichnet",
      .group = MetricGroup::dose,
      .screen_unit = "s",
      .digits = 1,
  };
  static Figure of(const Analysis& a) { return figure(missing_s(a.walk)); }
};

}  // namespace hoist::db::figures
