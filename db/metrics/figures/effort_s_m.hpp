// Effort of a metre: lean as a share of its range, times the time it is held, per metre.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Effort {
  static constexpr MetricInfo kInfo{
      .key = "effort_s_m",
      .version = 2,
      .unit = "s/m",
      .nullable = true,
      .inputs = "mode lean_norm dx_m dy_m speed_m_s parameter_version gaps parameters",
      .formula = "sum |lean_norm| × 10 ms / sum |v| × 10 ms, both in USER",
      .gate = "the patient led 1 m; settings not changed since the session's begin",
      .source = "control feel",
      .doc = "Effort of a metre: lean as a share of its range, times the time it is held, per metre",
      .title_en = "Lean held per metre",
      .title_de = "Neigung je Meter",
      .group = MetricGroup::control,
      .screen_unit = "s/m",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    if (a.lead.why != NoFigure::none) return no_figure(a.lead.why);
    return a.lead.effort_s_m ? figure(*a.lead.effort_s_m) : no_figure(NoFigure::not_led);
  }
};

}  // namespace hoist::db::figures
