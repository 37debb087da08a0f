// H12: the two halves of the 24 V supply drift apart: one battery is worn out and will sag first, long before the sum shows it.
//
// battery_uneven_v over one second; warning within 2 s.
#pragma once
#include <cmath>

#include "control/core/base/mutation.hpp"
#include "control/core/monitor/battery_mean.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class BatteryUneven {
 public:
  static constexpr contract::Fault kFault = contract::Fault::battery_uneven;

  bool check(const MonitorView& view) noexcept {
    const IoSensor& io = view.sensed.io;
    if (!io.battery_known()) return false;
    const double mean_v = mean_.step(io.battery_a_v() - io.battery_b_v(), view.dt_s);
    const double limit_v = threshold<kFault, "difference">(view.params.battery_uneven_v);
    uneven_ = !(std::fabs(mean_v) <= (uneven_ ? limit_v - kHysteresis_v : limit_v));
    return uneven_;
  }

 private:
  // Only ever makes the warning last: it must not come and go with every step.
  static constexpr double kHysteresis_v = 0.1;

  BatteryMean<kFault> mean_;
  bool uneven_ = false;
};

}  // namespace hoist::core
