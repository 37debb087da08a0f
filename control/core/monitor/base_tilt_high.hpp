// H9: the floor slopes. From here on nothing goes faster than base_tilt_speed_m_s_max (on_slope_m_s below), and the console says why.
//
// base_tilt_slow_rad for 100 ms; warning and cap within 200 ms.
#pragma once
#include <cstdint>

#include "control/core/monitor/base_tilt.hpp"
#include "control/core/monitor/mutation.hpp"

namespace hoist::core {

class BaseTiltHigh {
 public:
  static constexpr contract::Fault kFault = contract::Fault::base_tilt_high;

  bool check(const MonitorView& view) noexcept {
    const std::uint8_t limit_ticks = hold<kFault, "time">(kBaseTiltTicks);
    const double limit_rad = threshold<kFault, "angle">(view.params.base_tilt_slow_rad);
    const bool slopes = base_leans_beyond(view.sensed, high_ ? limit_rad - kHysteresis_rad : limit_rad);
    ticks_ = !slopes ? std::uint8_t{0} : static_cast<std::uint8_t>(ticks_ < limit_ticks ? ticks_ + 1 : limit_ticks);
    high_ = slopes && (high_ || ticks_ >= limit_ticks);
    return view.mode != contract::Mode::init && high_;
  }

 private:
  // One degree: braking and starting lean the chassis by a few tenths, and the cap must not come and go with them. Only makes it last.
  static constexpr double kHysteresis_rad = 0.0174532925;

  std::uint8_t ticks_ = 0;
  bool high_ = false;
};

/// The speed that a mode may ask for: its wish, on a slope held to the cap. The limiter's ramps lead there.
[[nodiscard]] inline double on_slope_m_s(double wish_m_s, std::uint32_t faults, const contract::Params& params) noexcept {
  if ((faults & contract::fault_bit(contract::Fault::base_tilt_high)) == 0) return wish_m_s;
  const double cap_m_s = params.base_tilt_speed_m_s_max;
  return wish_m_s > cap_m_s ? cap_m_s : (wish_m_s < -cap_m_s ? -cap_m_s : wish_m_s);
}

}  // namespace hoist::core
