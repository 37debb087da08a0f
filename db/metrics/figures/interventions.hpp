// How often patient-led walking was broken off: by a stop, a fault or the therapist.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct Interventions {
  static constexpr MetricInfo kInfo{
      .key = "interventions",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode gaps",
      .formula = "ends of USER, without the last one when it goes to STANDBY and no motion follows",
      .gate = "the patient led; at most 0.5 s missing",
      .source = "usual in gait training",
      .doc = "How often patient-led walking was broken off: by a stop, a fault or the therapist",
      .title_en = "Patient's lead broken off",
      .title_de = "Führung des Patienten beendet",
      .group = MetricGroup::dose,
      .screen_unit = "",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    return a.walk.modes.led() ? counted(a, a.walk.modes.interventions()) : no_figure(NoFigure::not_led);
  }
};

}  // namespace hoist::db::figures
