// A general or advanced timer of the STM32F072 (RM0091, chapters 17 and 18): counting up, PWM with preload, capture of channel 1, the
// exclusive-or of three inputs, encoder mode. Other directions, modes and channels are violations. Input filters add no delay.
#pragma once

#include <array>
#include <cstdint>

#include "tests/machine/time.hpp"

namespace hoist::machine {

class Stm32Timer {
 public:
  /// `advanced`: TIM1 with its main output enable; `wide`: TIM2 with 32 bit.
  Stm32Timer(const char* name, bool advanced, bool wide, Complain complain)
      : name_(name), advanced_(advanced), wide_(wide), complain_(std::move(complain)) {
    reset();
  }
  void reset();
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, Time now);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now) { settle(now); }
  /// The next update event that something waits for.
  [[nodiscard]] Time next() const;
  [[nodiscard]] bool line() const { return (status_ & interrupts_ & 0xFFU) != 0; }
  /// The levels at the channels' inputs, bit 0 is channel 1.
  void set_inputs(std::uint32_t levels, Time now);

  /// The channel drives its pin.
  [[nodiscard]] bool drives(unsigned channel) const;
  /// Share of the time the channel's output is high.
  [[nodiscard]] double high_share(unsigned channel) const;
  /// Level of the channel's output at this very instant.
  [[nodiscard]] bool output(unsigned channel, Time now);
  /// Next rising edge of the channel's output after `now`; never without one.
  [[nodiscard]] Time next_rise(unsigned channel, Time now);
  /// Grows with every change that may move an edge of an output.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

 private:
  [[nodiscard]] std::uint64_t range() const { return wide_ ? 0x1'0000'0000ULL : 0x1'0000ULL; }
  [[nodiscard]] bool encoder() const { return (slave_ & 7U) != 0; }
  [[nodiscard]] bool ticking() const { return (control1_ & 1U) != 0 && !encoder(); }
  [[nodiscard]] std::uint32_t output_mode(unsigned channel) const { return (modes_[channel / 2] >> (8 * (channel & 1U) + 4)) & 7U; }
  [[nodiscard]] bool buffered(unsigned channel) const { return ((modes_[channel / 2] >> (8 * (channel & 1U) + 3)) & 1U) != 0; }
  void settle(Time now);
  void update();
  void check_modes(std::uint32_t value, unsigned pair);
  void write_mode(std::uint32_t offset, std::uint32_t value);
  void count_edge(bool up);
  void count_encoder(std::uint32_t before, std::uint32_t after);
  void capture(bool before, bool after);

  const char* name_;
  bool advanced_, wide_;
  Complain complain_;
  std::uint32_t control1_{}, control2_{}, slave_{}, interrupts_{}, status_{}, enable_{}, outputs_{};
  std::array<std::uint32_t, 2> modes_{};
  std::uint32_t prescale_wanted_{}, prescale_{}, top_wanted_{}, top_{};
  std::array<std::uint32_t, 4> compare_wanted_{}, compare_{};
  std::uint64_t counter_{};  // at settled_
  Time settled_{};
  Time clock_{6};  // of the timer
  std::uint32_t inputs_{};
  std::uint64_t changes_{};
};

}  // namespace hoist::machine
