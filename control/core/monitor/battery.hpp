// H12: the batteries, both together, over one second so that the sag of a start does not count.
//
// battery_low: battery_low_v, warning. battery_empty: battery_empty_v, R1 and no new start. Both within 2 s.
#pragma once
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/battery_mean.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <contract::Fault kWhich, double contract::Params::*kThreshold_v>
class BatteryBelow {
 public:
  static constexpr contract::Fault kFault = kWhich;

  bool check(const MonitorView& view) noexcept {
    const IoSensor& io = view.sensed.io;
    if (!io.battery_known()) return false;
    const double mean_v = mean_.step(io.battery_a_v() + io.battery_b_v(), view.dt_s);
    const double limit_v = threshold<kFault, "voltage", Laxer::lower>(view.params.*kThreshold_v);
    low_ = !(mean_v >= (low_ ? limit_v + kHysteresis_v : limit_v));
    return low_;
  }

 private:
  // A resting battery recovers by a few tenths of a volt; the alarm must not come and go with every step. Only ever makes the alarm last.
  static constexpr double kHysteresis_v = 0.3;

  BatteryMean<kFault> mean_;
  bool low_ = false;
};

}  // namespace hoist::core
