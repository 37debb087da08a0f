// H8: a tilt sensor says itself that it cannot be trusted.
#pragma once
#include <array>
#include <cstdint>

#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

class TiltSensorFault {
 public:
  static constexpr contract::Fault kFault = contract::Fault::tilt_sensor_fault;

  bool check(const MonitorView& view) noexcept {
    const bool left = bad(view.sensed.left_strut, bad_ticks_[0]);
    const bool right = bad(view.sensed.right_strut, bad_ticks_[1]);
    const bool base = bad(view.sensed.base, bad_ticks_[2]);
    return view.mode != contract::Mode::init && (left || right || base);
  }

 private:
  // As long as a silent sensor is given: an invalid sample is worth as little as none.
  static constexpr std::uint8_t kBadTicks = kLostTicks;

  [[nodiscard]] static bool bad(const TiltSensor& tilt, std::uint8_t& ticks) noexcept {
    if (tilt.heard().lost()) {
      ticks = 0;  // NodeLost speaks for a silent one
      return false;
    }
    const bool useless = !tilt.has(tilt_status::kValid) || tilt.has(tilt_status::kGyroSaturated);
    ticks = !useless ? std::uint8_t{0} : static_cast<std::uint8_t>(ticks < kBadTicks ? ticks + 1 : kBadTicks);
    return tilt.has(tilt_status::kSelfTestFailed) || ticks == kBadTicks;
  }

  std::array<std::uint8_t, 3> bad_ticks_{};
};

}  // namespace hoist::core
