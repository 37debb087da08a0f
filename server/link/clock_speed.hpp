// How fast the core's time passes beside this computer's, in windows of two seconds. Only a simulated clock may differ.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace hoist::server {

class ClockSpeed {
 public:
  static constexpr std::uint64_t kWindow_ns = 2'000'000'000;
  static constexpr double kSlow_norm = 0.9, kNormal_norm = 0.95;  // two bounds, so that the notice does not flicker
  static constexpr int kStep_percent = 5;                         // coarse enough to stand still on the screen

  /// One look at both clocks; a core that says nothing new keeps its old time.
  void look(std::uint64_t steady_ns, std::uint64_t core_ns) {
    if (!begun_ || core_ns < core_ns_ || steady_ns < steady_ns_) {
      begin(steady_ns, core_ns);
      return;
    }
    if (steady_ns - steady_ns_ < kWindow_ns) return;
    const double speed = static_cast<double>(core_ns - core_ns_) / static_cast<double>(steady_ns - steady_ns_);
    slow_ = speed < (slow_ ? kNormal_norm : kSlow_norm);
    percent_ = static_cast<int>(std::lround(std::min(speed, 1.0) * 100 / kStep_percent)) * kStep_percent;
    begin(steady_ns, core_ns);
  }
  /// There is no simulated clock (any more).
  void forget() { *this = {}; }

  /// Of real time, while simulated time runs slow.
  [[nodiscard]] std::optional<int> slow_percent() const { return slow_ ? std::optional(percent_) : std::nullopt; }

 private:
  void begin(std::uint64_t steady_ns, std::uint64_t core_ns) {
    begun_ = true;
    steady_ns_ = steady_ns;
    core_ns_ = core_ns;
  }
  bool begun_ = false, slow_ = false;
  int percent_ = 100;
  std::uint64_t steady_ns_ = 0, core_ns_ = 0;
};

}  // namespace hoist::server
