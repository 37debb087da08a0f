// Turns of the hoist to the left by 45 degrees or more.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct TurnsLeft {
  static constexpr MetricInfo kInfo{
      .key = "turns_left",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode psi_rad gaps",
      .formula = kTurns,
      .gate = kTurnCountGate,
      .source = "after El-Gohary 2014",
      .doc = "Turns of the hoist to the left by 45 degrees or more",
      .title_en = "Turns to the left",
      .title_de = "Drehungen nach links",
      .group = MetricGroup::turning,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) { return counted(a, a.turns.left); }
};

}  // namespace hoist::db::figures
