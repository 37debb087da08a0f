// What the simulated patient sets out to do. One row per scenario; `hoist-sim --list` prints them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/exercises.hpp"

namespace hoist::sim {

using Figure = contract::ExerciseShape;

struct Scenario {
  std::string_view name;
  std::string_view title;
  Figure figure;         ///< with its usual sizes (exercises.def)
  double trip_after_s;   ///< the patient stumbles this long after setting off; 0 = never
  bool slippery{false};  ///< wheels lose the floor for moments, again and again
};

inline constexpr std::array kScenarios{
    Scenario{"figure-eight", "walks the figure of eight (c = 1 m, R = 0.8 m) without end", Figure::eight, 0.0},
    Scenario{"square", "walks the square of 3.2 m without end", Figure::square, 0.0},
    Scenario{"straight", "walks 10 m straight ahead, then stands", Figure::straight, 0.0},
    Scenario{"stand", "stands still", Figure::free, 0.0},
    Scenario{"slippery", "walks the figure of eight over wet patches and overpowers the frame there", Figure::eight, 0.0, true},
    Scenario{"trip", "walks straight ahead and stumbles after 6 s", Figure::straight, 6.0},
    Scenario{"slalom", "walks round four poles, then stands", Figure::slalom, 0.0},
};

constexpr const Scenario* find_scenario(std::string_view name) {
  for (const Scenario& scenario : kScenarios)
    if (scenario.name == name) return &scenario;
  return nullptr;
}

/// The line on the floor; a standing patient has a straight line that is not walked.
inline contract::ReferencePath scenario_path(const Scenario& scenario) {
  return figure_of(contract::usual_exercise(scenario.figure == Figure::free ? Figure::straight : scenario.figure));
}

}  // namespace hoist::sim
