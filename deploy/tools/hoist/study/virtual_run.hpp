// One run of one virtual subject through the shipped core, firmware and bus in virtual time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/signals.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/loop/closed_loop.hpp"

namespace hoist::tool::study {

struct VirtualRun {
  int subject = 0, run = 0;
  std::vector<contract::TickRecord> records;  ///< from the start mark to standing again
  std::vector<double> parameters;             ///< in force, in the order of contract::kParams
  std::string unfinished;                     ///< why the run ended early; empty for a whole one
};

/// The same seed gives the same runs, independent of earlier ones. `runs_done`: by this subject in this study.
[[nodiscard]] VirtualRun walk(const Protocol& protocol, const Run& run, int subject, int runs_done, std::uint64_t seed);

/// One run led by the patient of these options, so many times along the exercise of their scenario.
[[nodiscard]] VirtualRun walk_led(const loop::ClosedLoopOptions& options, double laps);

/// The runs of a subject in the order in which they are done.
[[nodiscard]] std::vector<Run> order_of(const Protocol& protocol, int subject, std::uint64_t seed);

}  // namespace hoist::tool::study
