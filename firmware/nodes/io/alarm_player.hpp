// Plays the alarm signals of the input node: buzzer and lights by the patterns of alarms.def (IEC 60601-1-8). The computer says which priority
// sounds and which is lit; when it is gone the node signals high by itself, until it is told again or loses its power (hazard H23).
#pragma once
#include <cstdint>

#include "control/contract/alarms.hpp"
#include "control/contract/can_dictionary.hpp"

namespace hoist::firmware {

class AlarmPlayer {
 public:
  /// The computer's word. From here on its silence is an alarm.
  void command(std::uint8_t byte) {
    told_ = contract::alarm_command(byte);
    known_ = true;
    lost_ = false;
  }
  /// The computer has fallen silent. One that has never spoken is not missed.
  void lose_computer() { lost_ = known_; }
  /// The node was taken out of operation: what it was told holds no longer. A computer that was lost before stays lost.
  void forget() { told_ = {}; }

  /// The outputs in this millisecond (kBuzzer, kRedLight, kYellowLight, kCyanLight). Call once each millisecond.
  std::uint8_t step_1ms() {
    constexpr contract::AlarmCommand kHigh{contract::AlarmLevel::high, contract::AlarmLevel::high};
    const contract::AlarmCommand now = lost_ ? kHigh : told_;
    return static_cast<std::uint8_t>((sounds(now.sound) ? contract::canopen::kBuzzer : 0U) | light(now.light));
  }

 private:
  // A pattern begins with its first pulse whenever another one is asked for.
  bool sounds(contract::AlarmLevel level) {
    if (level != sounding_) {
      sounding_ = level;
      pulse_ = 0;
      on_ = true;
      left_ms_ = level == contract::AlarmLevel::none ? std::uint16_t{0} : contract::alarm_info(level).pulse_ms;
    }
    if (level == contract::AlarmLevel::none) return false;
    const contract::AlarmInfo& alarm = contract::alarm_info(level);
    const bool now = on_;
    if (--left_ms_ == 0) {
      left_ms_ = on_ ? contract::alarm_gap_ms(alarm, pulse_) : alarm.pulse_ms;
      if (on_ && ++pulse_ == alarm.pulses) pulse_ = 0;
      on_ = !on_;
    }
    return now;
  }

  unsigned light(contract::AlarmLevel level) {
    if (level != lit_) {
      lit_ = level;
      light_ms_ = 0;
    }
    if (level == contract::AlarmLevel::none) return 0;
    const contract::AlarmInfo& alarm = contract::alarm_info(level);
    const bool on = alarm.flash_ms == 0 || light_ms_ < alarm.lit_ms;
    light_ms_ = light_ms_ + 1U < alarm.flash_ms ? static_cast<std::uint16_t>(light_ms_ + 1U) : std::uint16_t{0};
    if (!on) return 0;
    switch (alarm.colour) {
      case contract::AlarmColour::red:
        return contract::canopen::kRedLight;
      case contract::AlarmColour::yellow:
        return contract::canopen::kYellowLight;
      default:
        return contract::canopen::kCyanLight;
    }
  }

  contract::AlarmCommand told_;
  contract::AlarmLevel sounding_ = contract::AlarmLevel::none, lit_ = contract::AlarmLevel::none;
  std::uint16_t left_ms_ = 0, light_ms_ = 0;
  std::uint8_t pulse_ = 0;
  bool on_ = false, known_ = false, lost_ = false;
};

}  // namespace hoist::firmware
