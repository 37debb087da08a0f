// H9: the floor slopes. From here on nothing goes faster than base_tilt_speed_m_s_max (decide in tick.cpp), and the console says why.
//
// base_tilt_slow_rad for 100 ms; warning and cap within 200 ms.
#pragma once
#include <cstdint>

#include "control/core/base/lasting.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/base_tilt.hpp"

namespace hoist::core {

class BaseTiltHigh {
 public:
  static constexpr contract::Fault kFault = contract::Fault::base_tilt_high;

  bool check(const MonitorView& view) noexcept {
    const double limit_rad = threshold<kFault, "angle">(view.params.base_tilt_slow_rad);
    const bool slopes = base_leans_beyond(view.sensed, high_ ? limit_rad - kHysteresis_rad : limit_rad);
    high_ = slopes_.step(slopes, hold<kFault, "time">(kBaseTiltTicks));
    return view.mode != contract::Mode::init && high_;
  }

 private:
  // One degree: braking and starting lean the chassis by a few tenths, and the cap must not come and go with them. Only makes it last.
  static constexpr double kHysteresis_rad = 0.0174532925;

  Lasting slopes_;
  bool high_ = false;
};

}  // namespace hoist::core
