// H22 and hazard table 2.3: counts protective stops for the same fault of the machine.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/core/base/mutation.hpp"

namespace hoist::core {

/// What is known of earlier stops when the core starts, and what it hands out to be stored: plain bytes in whole words.
struct StopHistory {
  struct Stop {
    std::int64_t time_ns = 0;  // on the core's clock; negative for one before that clock began
    std::uint64_t fault = 0;
  };
  // Each of the faults that count may be one short of its limit (at most 5), and so many different ones have never been seen together.
  std::array<Stop, 32> stops{};
  std::uint64_t count = 0;           // of `stops`, the oldest first
  std::uint64_t out_of_service = 0;  // faults of the stop that led to FAULT, control_fault among them; 0 = not out of service for it
};

class RepeatWatch {
 public:
  /// A stop for this fault. True when it was one too many: `fault_stops_max` of them within `fault_stops_window_s`.
  [[nodiscard]] bool note(std::uint8_t fault, std::uint64_t time_ns, const contract::Params& params) noexcept {
    constexpr contract::Fault kFault = contract::Fault::control_fault;
    const auto now_ns = static_cast<std::int64_t>(time_ns);
    if (history_.count == history_.stops.size()) drop_oldest();
    history_.stops[history_.count++] = {now_ns, fault};
    const double window_s = threshold<kFault, "window", Laxer::lower>(params.fault_stops_window_s);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < history_.count; ++i) {
      const StopHistory::Stop& stop = history_.stops[i];
      if (stop.fault == fault && static_cast<double>(now_ns - stop.time_ns) * 1e-9 <= window_s) ++count;
    }
    return count >= threshold<kFault, "stops">(params.fault_stops_max);
  }

  /// Once per step: drops the oldest stop when it has left the window. True then: the history must be stored again, because a restart of the
  /// computer makes every stored stop count as recent.
  [[nodiscard]] bool expire(std::uint64_t time_ns, const contract::Params& params) noexcept {
    constexpr contract::Fault kFault = contract::Fault::control_fault;
    const double window_s = threshold<kFault, "window", Laxer::lower>(params.fault_stops_window_s);
    if (history_.count == 0 || static_cast<double>(static_cast<std::int64_t>(time_ns) - history_.stops[0].time_ns) * 1e-9 <= window_s)
      return false;
    drop_oldest();
    return true;
  }

  void forget() noexcept { *this = RepeatWatch{}; }

  /// Its stops; whether the hoist is out of service is the supervisor's to add.
  [[nodiscard]] const StopHistory& history() const noexcept { return history_; }
  void restore(const StopHistory& history) noexcept {
    history_ = history;
    history_.out_of_service = 0;
    if (history_.count > history_.stops.size()) history_.count = history_.stops.size();
  }

 private:
  void drop_oldest() noexcept {
    for (std::size_t i = 1; i < history_.stops.size(); ++i) history_.stops[i - 1] = history_.stops[i];
    --history_.count;
  }

  StopHistory history_;
};

}  // namespace hoist::core
