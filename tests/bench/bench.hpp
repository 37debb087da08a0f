// What a measurement reports: a value, the floor measured beside it in the same run, their ratio, and the goal of the design.
// Absolute times on a shared machine drift by a factor of two; the ratios hold.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace hoist::bench {

struct Row {
  std::string what;
  double value = 0;
  std::string unit;
  double floor = 0;  // 0: no floor, the value stands alone
  std::string floor_what;
  double goal_ratio = 0;  // largest ratio wanted; 0: none
  double goal_value = 0;  // for rows without a floor; 0: none
  bool more_is_better = false;
  std::string note;
};
using Rows = std::vector<Row>;

// Nanoseconds per call: the median of several rounds, each long enough to read the clock.
double nanoseconds_per_call(const std::function<void(int)>& calls);

Rows measure_law_and_tick();
Rows measure_shared_memory();
Rows measure_simulator();
// These two start the real programs from `bin`.
Rows measure_loop(const std::string& bin, double seconds);
Rows measure_websocket(const std::string& bin, int clients, double seconds);

}  // namespace hoist::bench
