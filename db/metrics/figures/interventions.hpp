// How often patient-led walking was broken off: by a stop, a fault or the therapist.
#pragma once
#include <algorithm>

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
    using contract::Mode;
    const std::vector<Mode>& modes = a.walk.modes;
    const auto moving = [](Mode mode) { return contract::kModes[static_cast<std::size_t>(mode)].moving; };
    if (std::ranges::count(modes, Mode::user) == 0) return no_figure(NoFigure::no_motion);
    int ends = 0;
    for (std::size_t i = 0; i + 1 < modes.size(); ++i) {
      const auto next = modes.begin() + static_cast<std::ptrdiff_t>(i) + 1;
      const bool last = *next == Mode::standby && std::none_of(next, modes.end(), moving);
      ends += modes[i] == Mode::user && !last ? 1 : 0;
    }
    return counted(a, ends);
  }
};

}  // namespace hoist::db::figures
