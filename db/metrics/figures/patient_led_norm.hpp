// Share of the time in motion in which the patient led.
#pragma once
#include "db/metrics/metric.hpp"

namespace hoist::db::figures {

struct PatientLed {
  static constexpr MetricInfo kInfo{
      .key = "patient_led_norm",
      .version = 1,
      .unit = "1",
      .nullable = true,
      .inputs = "mode standing_still",
      .formula = "samples in USER in which a wheel turned / samples in which a wheel turned",
      .gate = "a wheel turned",
      .source = "usual in gait training",
      .doc = "Share of the time in motion in which the patient led",
      .title_en = "Led by the patient",
      .title_de = "Vom Patienten geführt",
      .group = MetricGroup::dose,
      .screen_unit = "%",
      .digits = 0,
  };
  static Figure of(const Analysis& a) {
    if (a.walk.in_motion == 0) return no_figure(NoFigure::no_motion);
    return figure(static_cast<double>(a.walk.in_motion_led) / static_cast<double>(a.walk.in_motion));
  }
};

}  // namespace hoist::db::figures
