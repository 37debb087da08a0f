// What a study does: runs, subjects, exclusions and the assumptions about virtual subjects, from a JSON file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/exercises.hpp"

namespace hoist::tool::study {

/// Most runs and subjects of a study: what a page can show.
inline constexpr std::size_t kMostRuns = 12, kMostSubjects = 99;

struct Run {
  int number = 0;  ///< as recordings name it: their note begins with "run N"
  contract::ExerciseShape shape = contract::ExerciseShape::eight;
  bool by_patient = false;  ///< else the therapist drives
  bool injured = false;     ///< with the orthosis that simulates an injury
};

/// Evenly drawn between both.
using Range = std::array<double, 2>;

/// What is put in for people: none of it is measured.
struct Assumptions {
  Range wish_m_s{0.20, 0.28};         ///< preferred speed
  Range anticipation_norm{0.5, 0.9};  ///< of the line ahead, by a subject who follows, in the first run …
  double learning_norm = 0.04;        ///< … and more with each run done
  double trailing_s = 0.2;            ///< by how much the pelvis of a follower trails behind the hoist
  double limp_norm = 0.2;             ///< the orthosis: asymmetry of steps …
  double injured_sway_norm = 1.2;     ///< … and how much wider the gait sways
  double therapist_m_s = 0.25;        ///< speed with which the therapist drives
  double therapist_delay_s = 0.35;
  double misjudgement_m = 0.15;            ///< standard deviation of where the therapist sees the hoist, sideways
  double misjudgement_rad = 0.0872664626;  ///< and of its heading: 5 degrees
};

struct Protocol {
  std::string title;
  std::string preset = "walk";
  double laps = 2;
  bool random_order = false;
  std::vector<Run> runs;
  std::vector<std::pair<int, int>> excluded;  ///< subject, run
  std::vector<std::pair<int, int>> compared;  ///< pairs of runs
  std::vector<int> drawn_subjects, drawn_runs;
  Assumptions assumed;

  [[nodiscard]] bool has(int subject, int run) const;
  [[nodiscard]] const Run* find(int run) const;
};

/// The paper's protocol (Tables I to III), as `hoist study --protocol-text` prints it.
[[nodiscard]] std::string_view paper_protocol();
/// Nothing, and `problem` names the field and what is allowed, for a text that is no protocol.
[[nodiscard]] std::optional<Protocol> read_protocol(std::string_view text, std::string& problem);

}  // namespace hoist::tool::study
