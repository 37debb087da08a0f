// A voltage of the batteries over one second, so that what a start takes or braking gives back for a moment does not count.
#pragma once
#include "control/core/base/mutation.hpp"
#include "control/core/law/low_pass.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <contract::Fault kFault>
class BatteryMean {
 public:
  /// The mean, with the voltage of this step; begins at the first one.
  double step(double now_v, double dt_s) noexcept {
    if (!known_) filter_.value = now_v;
    known_ = true;
    law::low_pass_step(hold<kFault, "filter">(kFilter_s), filter_, now_v, dt_s);
    return filter_.value;
  }

 private:
  static constexpr double kFilter_s = 1.0;  // H12

  law::LowPassState<double> filter_;
  bool known_ = false;
};

}  // namespace hoist::core
