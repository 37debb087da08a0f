// What the simulated patient sets out to do. One row per scenario; `hoist-sim --list` prints them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/reference_path.hpp"

namespace hoist::sim {

enum class Figure : std::uint8_t { eight, square, straight, none };

struct Scenario {
  std::string_view name;
  std::string_view title;
  Figure figure;
  double length_m;       ///< of a straight: where the patient stops; 0 for figures that go round
  double trip_after_s;   ///< the patient stumbles this long after setting off; 0 = never
  bool slippery{false};  ///< wheels lose the floor for moments, again and again
};

/// Sizes of the figures are the contract's (D34): eight c = 1, R = 0.8; square of 3.2 m.
inline constexpr std::array kScenarios{
    Scenario{"figure-eight", "walks the figure of eight (c = 1 m, R = 0.8 m) without end", Figure::eight, 0.0, 0.0},
    Scenario{"square", "walks the square of 3.2 m without end", Figure::square, 0.0, 0.0},
    Scenario{"straight", "walks 10 m straight ahead, then stands", Figure::straight, 10.0, 0.0},
    Scenario{"stand", "stands still", Figure::none, 0.0, 0.0},
    Scenario{"slippery", "walks the figure of eight over wet patches and overpowers the frame there", Figure::eight, 0.0, 0.0, true},
    Scenario{"trip", "walks straight ahead and stumbles after 6 s", Figure::straight, 10.0, 6.0},
};

constexpr const Scenario* find_scenario(std::string_view name) {
  for (const Scenario& scenario : kScenarios)
    if (scenario.name == name) return &scenario;
  return nullptr;
}

/// The line on the floor; a standing patient has a straight line that is not walked.
inline contract::ReferencePath scenario_path(const Scenario& scenario) {
  switch (scenario.figure) {
    case Figure::eight:
      return contract::ReferencePath::eight();
    case Figure::square:
      return contract::ReferencePath::square();
    case Figure::straight:
      return contract::ReferencePath::straight(scenario.length_m);
    case Figure::none:
      break;
  }
  return contract::ReferencePath::straight();
}

}  // namespace hoist::sim
