// H-bridge at 20 kHz on CT16B0 and the converter that watches it (UM10398, chapters 20 and 25).
//
// In a period the output is low first and high from the match on, so the ON part ends with the period. The converter is started by a
// second match in the middle of the ON part, where the current has its average; when the ON part is too short for that, in the middle
// of the OFF part, where it has it too.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>

#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"

namespace hoist::firmware::lpc11c24 {

namespace pwm {
using Control = Register<0x4000C004>;
using Counter = Register<0x4000C008>;
using Prescale = Register<0x4000C00C>;
using MatchControl = Register<0x4000C014>;
using Match0 = Register<0x4000C018>;
using Match1 = Register<0x4000C01C>;
using Match3 = Register<0x4000C024>;
using Mode = Register<0x4000C074>;
inline constexpr std::uint32_t kPeriod = kClock_hz / 20'000;
inline constexpr std::uint32_t kShortestOn = kPeriod / 10;  // 5 us: twice a conversion
inline constexpr std::uint32_t kPeriod_loops = 1000;        // of at least 5 clocks: more than two periods
}  // namespace pwm

class Converter {
 public:
  // 4.36 MHz, below the 4.5 MHz that the data sheet allows; a conversion takes 11 clocks, 2.5 us.
  void start() {
    syscon::AhbClocks::set(syscon::kAdc);
    syscon::PowerDown::clear(syscon::kAdcOff);
    InterruptEnable::write(0);
    Control::write(kDivider);
  }

  // One conversion now. NaN when the converter does not answer.
  [[nodiscard]] float convert(std::uint32_t channel) {
    Control::write(kDivider);
    Control::write((1U << channel) | kDivider | kStartNow);
    std::uint32_t result = 0;
    for (std::uint32_t i = 0; i < kLoopsMax; ++i) {
      result = read_word(channel);
      if ((result & kDone) != 0) break;
    }
    Control::write(kDivider);
    return value(result);
  }
  // From now on the timer's second match starts a conversion in every period.
  void follow_timer(std::uint32_t channel) { Control::write((1U << channel) | kDivider | kStartAtMatch1); }
  // The newest of those. NaN when none has ended since the last call.
  [[nodiscard]] float newest(std::uint32_t channel) { return value(read_word(channel)); }

 private:
  using Control = Register<0x4001C000>;
  using InterruptEnable = Register<0x4001C00C>;
  static constexpr std::uint32_t kDivider = 10U << 8;
  static constexpr std::uint32_t kStartNow = 1U << 24;
  static constexpr std::uint32_t kStartAtMatch1 = 7U << 24;  // CT16B0_MAT1, rising
  static constexpr std::uint32_t kDone = 1U << 31;
  static constexpr std::uint32_t kLoopsMax = 200;  // of at least 5 cycles: 20 us

  static std::uint32_t read_word(std::uint32_t channel) { return cortex_m0::read_word(0x4001C010 + 4 * channel); }
  static float value(std::uint32_t result) {
    if ((result & kDone) == 0) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>((result >> 6) & 0x3FFU);
  }
};

class Bridge {
 public:
  // First thing after reset: the driver asleep, both of its inputs low. The pins are inputs until then and held by resistors.
  static void outputs_off() {
    syscon::AhbClocks::set(syscon::kGpio | syscon::kIocon);
    write_pin<kBridgeAwake>(false);
    write_pin<kBridgeEnable>(false);
    write_pin<kBridgePhase>(false);
    set_pin<kBridgeAwake>(0, kPinFloating);
    set_pin<kBridgeEnable>(0, kPinFloating);
    set_pin<kBridgePhase>(0, kPinFloating);
    make_output<kBridgeAwake>();
    make_output<kBridgeEnable>();
    make_output<kBridgePhase>();
  }

  void start() {
    set_pin<kBridgeFault>(0, kPinPullUp | kPinHysteresis);
    syscon::AhbClocks::set(syscon::kTimer16_0);
    pwm::Control::write(2);
    pwm::Prescale::write(0);
    pwm::Match3::write(pwm::kPeriod - 1);
    set_on_time(0);
    pwm::MatchControl::write(1U << 10);  // match 3 restarts the period
    pwm::Mode::write(3);                 // outputs 0 and 1
    pwm::Control::write(1);
    set_pin<kBridgeEnable>(2, kPinFloating);
  }

  // Off is the driver's sleep: its four transistors are off and the motor coasts. Waking takes a millisecond without voltage; the current
  // limiter and the ramp of the first tick are slower than that.
  void set(bool enabled, float duty_norm) {
    if (!enabled || duty_norm != duty_norm) {
      write_pin<kBridgeAwake>(false);
      set_on_time(0);
      awake_ = false;
      return;
    }
    const bool forward = duty_norm >= 0;
    const float size = forward ? duty_norm : -duty_norm;
    const std::uint32_t on = size >= 1.0F ? pwm::kPeriod : static_cast<std::uint32_t>(size * static_cast<float>(pwm::kPeriod));
    if (forward != forward_) end_on_part();
    forward_ = forward;
    write_pin<kBridgePhase>(forward);
    set_on_time(on);
    write_pin<kBridgeAwake>(true);
    awake_ = true;
  }

  [[nodiscard]] static bool fault_line_high() { return read_pin<kBridgeFault>(); }
  [[nodiscard]] bool awake() const { return awake_; }

 private:
  // Before the direction changes: the old duty must not act in the new direction. A match value counts at once, but an output that is
  // already high stays high until the period ends (UM10398, rules for single edge controlled PWM outputs). This waits for that end, at most
  // the old ON part: 50 us at full duty, almost nothing where a servo passes through zero.
  static void end_on_part() {
    const std::uint32_t rise = pwm::Match0::read();
    pwm::Match0::write(pwm::kPeriod);
    std::uint32_t before = pwm::Counter::read();
    if (before < rise) return;  // low, and it rises no more
    for (std::uint32_t i = 0; i < pwm::kPeriod_loops; ++i) {
      const std::uint32_t now = pwm::Counter::read();
      if (now < before) return;
      before = now;
    }
  }
  static void set_on_time(std::uint32_t on) {
    const std::uint32_t off = pwm::kPeriod - on;
    pwm::Match0::write(off);  // kPeriod is never reached: all low. 0: all high
    pwm::Match1::write(on >= pwm::kShortestOn ? off + on / 2 : off / 2);
  }

  bool forward_ = true, awake_ = false;
};

}  // namespace hoist::firmware::lpc11c24
