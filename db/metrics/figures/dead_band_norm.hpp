// Share of the time led by the patient in which the lean asked for nothing.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct DeadBandShare {
  static constexpr MetricInfo kInfo{
      .key = "dead_band_norm",
      .version = 2,
      .unit = "1",
      .nullable = true,
      .inputs = "mode lean_norm dx_m dy_m speed_m_s parameter_version gaps parameters",
      .formula = "samples in USER with |lean_norm| of lean_dead_band_norm or less / samples in USER",
      .gate = kLedGate,
      .source = "control feel",
      .doc = "Share of the time led by the patient in which the lean asked for nothing",
      .title_en = "Lean within the dead band",
      .title_de = "Neigung in der Totzone",
      .group = MetricGroup::control,
      .screen_unit = "%",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    if (a.lead.why != NoFigure::none) return no_figure(a.lead.why);
    return a.lead.dead_band_norm ? figure(*a.lead.dead_band_norm) : no_figure(NoFigure::not_led);
  }
};

}  // namespace hoist::db::figures
