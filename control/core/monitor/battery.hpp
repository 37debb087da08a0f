// H12: the batteries, both together, over one second so that the sag of a start does not count.
#pragma once
#include "control/core/law/low_pass.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <contract::Fault kWhich, double contract::Params::*kThreshold_v>
class BatteryBelow {
 public:
  static constexpr contract::Fault kFault = kWhich;

  bool check(const MonitorView& view) noexcept {
    const IoSensor& io = view.sensed.io;
    if (!io.battery_known()) return false;
    const double now_v = io.battery_a_v() + io.battery_b_v();
    if (!known_) filter_.value = now_v;
    known_ = true;
    law::low_pass_step(kFilter_s, filter_, now_v, view.dt_s);
    const double threshold_v = view.params.*kThreshold_v;
    low_ = filter_.value < (low_ ? threshold_v + kHysteresis_v : threshold_v);
    return low_;
  }

 private:
  static constexpr double kFilter_s = 1.0;
  // A resting battery recovers by a few tenths of a volt; the alarm must not come and go with every step.
  static constexpr double kHysteresis_v = 0.3;

  law::LowPassState<double> filter_;
  bool known_ = false, low_ = false;
};

}  // namespace hoist::core
