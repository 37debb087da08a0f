// From a fault to the beginning of braking and to rest, in the whole loop in virtual time: the real control step, the shipped nodes' sources,
// the bus, the machine and a walking patient. Each fault is tried at many moments: every millisecond of the control step, many patients'
// steps, several speeds.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace hoist::reactions {

struct Reaction {
  std::string hazard, fault, answer;
  int budget_ms = 0;    // from the fault to the beginning of braking
  int worst_ms = 0;     // the slowest of all tries
  int stopped_ms = 0;   // longest time from the fault to standstill; 0 where no stop is required
  int distance_cm = 0;  // longest distance from the fault to standstill
  int tries = 0, missed = 0;
};

/// Every row, each tried so many times.
[[nodiscard]] std::vector<Reaction> measure(int tries);

/// The same machine, but for one thing that the simulator assumes: what it makes of a fall and of the emergency stop.
struct Machine {
  std::string what;
  Reaction fall, emergency_stop;
};
[[nodiscard]] std::vector<Machine> measure_machines(int tries);

/// The committed page, and its values of a row (budget, worst, stopped, distance as in Reaction; tries 0 without that row).
[[nodiscard]] std::string page(const std::vector<Reaction>& rows, const std::vector<Machine>& machines);
[[nodiscard]] Reaction read_row(std::string_view page, std::string_view fault);
inline constexpr std::string_view kPage = "control/REACTIONS.gen.md";
/// So many tries stand behind the page.
inline constexpr int kPageTries = 30;

}  // namespace hoist::reactions
