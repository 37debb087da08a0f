// H12: the batteries, both together, over one second so that the sag of a start does not count.
//
// battery_low: battery_low_v, warning. battery_empty: battery_empty_v, R1 and no new start. Both within 2 s.
#pragma once
#include "control/core/base/mutation.hpp"
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
    law::low_pass_step(hold<kFault, "filter">(kFilter_s), filter_, now_v, view.dt_s);
    const double limit_v = threshold<kFault, "voltage", Laxer::lower>(view.params.*kThreshold_v);
    low_ = !(filter_.value >= (low_ ? limit_v + kHysteresis_v : limit_v));
    return low_;
  }

 private:
  static constexpr double kFilter_s = 1.0;  // H12
  // A resting battery recovers by a few tenths of a volt; the alarm must not come and go with every step. Only ever makes the alarm last.
  static constexpr double kHysteresis_v = 0.3;

  law::LowPassState<double> filter_;
  bool known_ = false, low_ = false;
};

}  // namespace hoist::core
