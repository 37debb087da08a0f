// How much before the hoist the pelvis turns.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TurnLead {
  static constexpr MetricInfo kInfo{
      .key = "turn_lead_s",
      .version = 1,
      .unit = "s",
      .nullable = true,
      .inputs = "mode psi_rad dpsi_rad",
      .formula = "the shift of up to 2 s at which dpsi and the turn rate (heading over 0.5 s) correlate most",
      .gate = "one turn; a correlation of 0.3",
      .source = "after El-Gohary 2014",
      .doc = "How much before the hoist the pelvis turns",
      .title_en = "Pelvis turns before the hoist by",
      .title_de = "Becken dreht vor dem Gerät um",
      .group = MetricGroup::turning,
      .screen_unit = "s",
      .digits = 2,
  };
  static Figure of(const Analysis& a) {
    constexpr double kAlike = 0.3;
    if (a.turns.count() == 0) return no_figure(NoFigure::no_turn);
    const std::optional<BestLag>& lead = a.turns.lead;
    return lead && lead->c >= kAlike ? figure(lead->lag * kSample_s) : no_figure(NoFigure::no_lead);
  }
};

}  // namespace hoist::db::figures
