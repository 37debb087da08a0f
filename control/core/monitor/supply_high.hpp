// H12: the supply is so high that the drives are about to brake less, to spare it: a charger that fails, or batteries that take no more.
//
// Both batteries above kSupplyHigh_v over one second: R1 and no new start, within 2 s. On a charger a full pair has 28.8 V, 29.4 V in the cold.
#pragma once
#include "control/contract/can_dictionary.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/battery_mean.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

/// Half a volt below where the drives begin.
inline constexpr double kSupplyHigh_v = contract::find_object(contract::NodeKind::drive, 0x2231, 1)->default_value -
                                        static_cast<double>(contract::canopen::drive::kOverVoltageFold_v) - 0.5;

class SupplyHigh {
 public:
  static constexpr contract::Fault kFault = contract::Fault::supply_high;

  bool check(const MonitorView& view) noexcept {
    const IoSensor& io = view.sensed.io;
    if (!io.battery_known()) return false;
    const double mean_v = mean_.step(io.battery_a_v() + io.battery_b_v(), view.dt_s);
    const double limit_v = threshold<kFault, "voltage">(kSupplyHigh_v);
    high_ = !(mean_v <= (high_ ? limit_v - kHysteresis_v : limit_v));
    return high_;
  }

 private:
  // Only ever makes the alarm last: it must not come and go with every step.
  static constexpr double kHysteresis_v = 0.3;

  BatteryMean<kFault> mean_;
  bool high_ = false;
};

}  // namespace hoist::core
