// How often walking was interrupted for a second or longer.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Stops {
  static constexpr MetricInfo kInfo{
      .key = "stops",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode speed_m_s gaps",
      .formula = "bouts that follow another one after 1 s or more",
      .gate = "one bout; at most 0.5 s missing",
      .source = "usual in gait training",
      .doc = "How often walking was interrupted for a second or longer",
      .title_en = "Pauses",
      .title_de = "Pausen",
      .group = MetricGroup::dose,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return a.bouts.count == 0 ? no_figure(why_no_bout(a.walk)) : counted(a, a.bouts.pauses); }
};

}  // namespace hoist::db::figures
