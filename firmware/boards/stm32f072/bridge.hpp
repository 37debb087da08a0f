// H-bridge at 20 kHz on TIM1, the converter that watches it, and the encoder (RM0091, chapters 13, 17 and 18).
//
// As on the LPC11C24 the ON part ends with the period (PWM mode 2), and channel 4 starts a conversion in its middle, or in the middle of
// the OFF part when the ON part is too short.
#pragma once
#include <cstdint>
#include <limits>

#include "firmware/boards/stm32f072/clock.hpp"
#include "firmware/boards/stm32f072/registers.hpp"

namespace hoist::firmware::stm32f072 {

namespace pwm {
using Control = Register<0x40012C00>;
using Event = Register<0x40012C14>;
using Mode1 = Register<0x40012C18>;
using Mode2 = Register<0x40012C1C>;
using Enable = Register<0x40012C20>;
using Prescale = Register<0x40012C28>;
using Period = Register<0x40012C2C>;
using Compare1 = Register<0x40012C34>;
using Compare4 = Register<0x40012C40>;
using Outputs = Register<0x40012C44>;
inline constexpr std::uint32_t kPeriod = kClock_hz / 20'000;
inline constexpr std::uint32_t kShortestOn = kPeriod / 10;
inline constexpr std::uint32_t kMode2Preload = (7U << 4) | (1U << 3);  // low until the compare value, buffered until the period ends
}  // namespace pwm

class Converter {
 public:
  // 12 MHz; 28.5 clocks of sampling and 12.5 of converting: 3.4 us. False when the converter does not get ready.
  bool start() {
    rcc::Apb2Clocks::set(rcc::kAdc);
    Configuration2::write(2U << 30);
    Control::write(1U << 31);  // calibration
    const bool good = wait_clear(Control::read, 1U << 31);
    Status::write(1);
    SampleTime::write(3);
    // Repeated until the converter reports ready: a request within four of its clocks after calibration is lost.
    for (std::uint32_t i = 0; i < kLoopsMax; ++i) {
      Control::write(1);
      if ((Status::read() & 1U) != 0) return good;
    }
    return false;
  }
  // One conversion now. NaN when the converter does not answer.
  [[nodiscard]] float convert(std::uint32_t channel) {
    stop();
    Configuration1::write(kOverwrite);
    Channels::write(1U << channel);
    Status::write(kConverted);
    Control::write(kStart);
    const bool good = wait_set(Status::read, kConverted);
    return good ? static_cast<float>(Data::read() & 0xFFFU) : std::numeric_limits<float>::quiet_NaN();
  }
  // From now on channel 4 of the timer starts a conversion in every period.
  void follow_timer(std::uint32_t channel) {
    stop();
    Configuration1::write(kOverwrite | (1U << 10) | (1U << 6));  // rising edge of TIM1_CC4
    Channels::write(1U << channel);
    Status::write(kConverted);
    Control::write(kStart);
  }
  // The newest of those. NaN when none has ended since the last call. Reading the data takes the flag away.
  [[nodiscard]] float newest(std::uint32_t) {
    if ((Status::read() & kConverted) == 0) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>(Data::read() & 0xFFFU);
  }

 private:
  using Status = Register<0x40012400>;
  using Control = Register<0x40012408>;
  using Configuration1 = Register<0x4001240C>;
  using Configuration2 = Register<0x40012410>;
  using SampleTime = Register<0x40012414>;
  using Channels = Register<0x40012428>;
  using Data = Register<0x40012440>;
  static constexpr std::uint32_t kConverted = 1U << 2, kStart = 1U << 2, kStop = 1U << 4, kOverwrite = 1U << 12;
  static constexpr std::uint32_t kLoopsMax = 2000;

  static bool wait_set(std::uint32_t (*read)(), std::uint32_t bit) {
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((read() & bit) != 0) return true;
    return false;
  }
  static bool wait_clear(std::uint32_t (*read)(), std::uint32_t bit) {
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((read() & bit) == 0) return true;
    return false;
  }
  static void stop() {
    if ((Control::read() & kStart) == 0) return;
    Control::write(kStop | 1U);
    (void)wait_clear(Control::read, kStart | kStop);
  }
};

class Bridge {
 public:
  static void outputs_off() {
    rcc::AhbClocks::set(rcc::kPorts);
    write_pin<kBridgeAwake>(false);
    write_pin<kBridgeEnable>(false);
    write_pin<kBridgePhase>(false);
    set_pin<kBridgeAwake>(PinMode::output);
    set_pin<kBridgeEnable>(PinMode::output);
    set_pin<kBridgePhase>(PinMode::output);
  }

  void start() {
    set_pin<kBridgeFault>(PinMode::input, PinPull::up);
    rcc::Apb2Clocks::set(rcc::kTimer1);
    pwm::Prescale::write(0);
    pwm::Period::write(pwm::kPeriod - 1);
    pwm::Mode1::write(pwm::kMode2Preload);
    pwm::Mode2::write(pwm::kMode2Preload << 8);
    set_on_time(0);
    pwm::Event::write(1);
    pwm::Enable::write((1U << 0) | (1U << 12));
    pwm::Outputs::write(1U << 15);
    pwm::Control::write((1U << 7) | 1U);
    set_pin<kBridgeEnable>(PinMode::alternate, PinPull::none, 2);
  }

  // Off is the driver's sleep: all four transistors are off and the motor coasts.
  void set(bool enabled, float duty_norm) {
    if (!enabled || duty_norm != duty_norm) {
      write_pin<kBridgeAwake>(false);
      set_on_time(0);
      return;
    }
    const bool forward = duty_norm >= 0;
    const float size = forward ? duty_norm : -duty_norm;
    const std::uint32_t on = size >= 1.0F ? pwm::kPeriod : static_cast<std::uint32_t>(size * static_cast<float>(pwm::kPeriod));
    if (forward != forward_) {  // at once, not at the end of the period: the old duty must not act in the new direction
      set_on_time(0);
      pwm::Event::write(1);
    }
    forward_ = forward;
    write_pin<kBridgePhase>(forward);
    set_on_time(on);
    write_pin<kBridgeAwake>(true);
  }

  [[nodiscard]] static bool fault_line_high() { return read_pin<kBridgeFault>(); }

 private:
  static void set_on_time(std::uint32_t on) {
    const std::uint32_t off = pwm::kPeriod - on;
    pwm::Compare1::write(off);  // kPeriod is never reached: all low. 0: all high
    pwm::Compare4::write(on >= pwm::kShortestOn ? off + on / 2 : (off + 1) / 2);
  }
  bool forward_ = true;
};

// TIM3 counts the edges in hardware; TIM2 holds the microsecond of the last one. The hardware does not count a step in which both lines
// changed; the node finds that by the motor's generated voltage.
class Encoder {
 public:
  void start() {
    set_pin<kEncoderA>(PinMode::alternate, PinPull::up, 1);
    set_pin<kEncoderB>(PinMode::alternate, PinPull::up, 1);
    set_pin<kEdgeA>(PinMode::alternate, PinPull::up, 2);
    set_pin<kEdgeB>(PinMode::alternate, PinPull::up, 2);
    set_pin<kEdgeOpen>(PinMode::alternate, PinPull::down, 2);
    rcc::Apb1Clocks::set(rcc::kTimer2 | rcc::kTimer3);
    Count::write(0);
    Inputs::write(1U | (1U << 8) | (3U << 4) | (3U << 12));  // both inputs, filtered over 8 clocks
    Slave::write(3);                                         // every edge of both
    Limit::write(0xFFFF);
    CountControl::write(1);
    EdgePrescale::write(kClock_hz / 1'000'000 - 1);
    EdgeLimit::write(0xFFFFFFFF);
    EdgeControl2::write(1U << 7);  // channel 1 is the exclusive-or of the first three
    EdgeInput::write(1U | (3U << 4));
    EdgeEnable::write(1U | (1U << 1) | (1U << 3));  // both directions
    EdgeEvent::write(1);                            // takes the prescaler over
    EdgeControl::write(1);
  }

  // Must be called at least every 32767 edges; a node calls it every millisecond.
  [[nodiscard]] std::int32_t counts() {
    const std::uint32_t now = Count::read() & 0xFFFFU;
    const auto moved = static_cast<std::int16_t>(static_cast<std::uint16_t>(now - last_));
    last_ = now;
    counts_ = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts_) + static_cast<std::uint32_t>(static_cast<std::int32_t>(moved)));
    return counts_;
  }
  // The mean over the edges since the last call that saw one; with less than one edge a millisecond this is the time between two edges.
  [[nodiscard]] std::uint32_t edge_time_us() {
    const std::int32_t now = counts();
    const std::uint32_t at_us = EdgeTime::read();
    const auto moved = static_cast<std::int32_t>(static_cast<std::uint32_t>(now) - static_cast<std::uint32_t>(timed_counts_));
    if (moved != 0) {
      const int direction = moved > 0 ? 1 : -1;
      const std::uint32_t edges = moved > 0 ? static_cast<std::uint32_t>(moved) : 0U - static_cast<std::uint32_t>(moved);
      between_us_ = direction == direction_ ? (at_us - timed_us_) / edges : kEdgeTimeUnknown_us;
      direction_ = direction;
      timed_counts_ = now;
      timed_us_ = at_us;
    } else if (EdgeCount::read() - timed_us_ > 0x7FFFFFFFU) {  // the microseconds are about to come round
      direction_ = 0;
      between_us_ = kEdgeTimeUnknown_us;
    }
    return between_us_;
  }
  [[nodiscard]] std::uint32_t illegal_steps() const { return 0; }

 private:
  using CountControl = Register<0x40000400>;
  using Slave = Register<0x40000408>;
  using Inputs = Register<0x40000418>;
  using Count = Register<0x40000424>;
  using Limit = Register<0x4000042C>;
  using EdgeControl = Register<0x40000000>;
  using EdgeControl2 = Register<0x40000004>;
  using EdgeEvent = Register<0x40000014>;
  using EdgeInput = Register<0x40000018>;
  using EdgeEnable = Register<0x40000020>;
  using EdgeCount = Register<0x40000024>;
  using EdgePrescale = Register<0x40000028>;
  using EdgeLimit = Register<0x4000002C>;
  using EdgeTime = Register<0x40000034>;

  std::uint32_t last_ = 0;
  std::int32_t counts_ = 0, timed_counts_ = 0;
  std::uint32_t timed_us_ = 0, between_us_ = kEdgeTimeUnknown_us;
  int direction_ = 0;
};

}  // namespace hoist::firmware::stm32f072
