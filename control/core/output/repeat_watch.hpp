// H22 and hazard table 2.3: the same fault of the machine that stops the hoist again and again is no chance any more.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/core/monitor/mutation.hpp"

namespace hoist::core {

class RepeatWatch {
 public:
  /// A stop for this fault. True when it was one too many: `fault_stops_max` of them within `fault_stops_window_s`.
  [[nodiscard]] bool note(std::uint8_t fault, std::uint64_t time_ns, const contract::Params& params) noexcept {
    constexpr contract::Fault kFault = contract::Fault::control_fault;
    stops_[next_] = {time_ns, fault, true};
    next_ = (next_ + 1) % stops_.size();
    const double window_s = threshold<kFault, "window", Laxer::lower>(params.fault_stops_window_s);
    std::uint32_t count = 0;
    for (const Stop& stop : stops_)
      if (stop.counts && stop.fault == fault && static_cast<double>(time_ns - stop.time_ns) * 1e-9 <= window_s) ++count;
    return count >= threshold<kFault, "stops">(params.fault_stops_max);
  }

  /// What stopped the hoist within the last second was a consequence of what is known now, and does not count.
  void forget_recent(std::uint64_t time_ns) noexcept {
    constexpr std::uint64_t kRecent_ns = 1'000'000'000;
    for (Stop& stop : stops_) stop.counts = stop.counts && time_ns - stop.time_ns > kRecent_ns;
  }
  void forget() noexcept { *this = RepeatWatch{}; }

 private:
  struct Stop {
    std::uint64_t time_ns = 0;
    std::uint8_t fault = 0;
    bool counts = false;
  };
  // Each of the faults that count may be one short of its limit (at most 5), and so many different ones have never been seen together.
  std::array<Stop, 32> stops_{};
  std::size_t next_ = 0;
};

}  // namespace hoist::core
