// I2C, SPI and USART of the STM32F072 (RM0091 chapters 26, 28, 27), each with time: a byte takes as long as its bits.
// Masters only, without DMA; any other use is a violation.
#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "tests/machine/serial_blocks.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

class Stm32I2c {
 public:
  explicit Stm32I2c(Complain complain) : complain_(std::move(complain)) { reset(); }
  void reset();
  void connect(I2cDevice* device) { device_ = device; }
  void set_pins(bool connected) { pins_ = connected; }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, Time now);
  /// `kernel_hz`: the block's own clock, that RCC_CFGR3 chooses.
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t kernel_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const { return due_; }
  [[nodiscard]] bool line() const { return (control1_ & 0xFEU) != 0 && (status_ & control1_ & 0x7EU) != 0; }

 private:
  enum class State : std::uint8_t { idle, address, transmit, receive, waiting_data, waiting_read, complete, stopping };
  void write_control2(std::uint32_t value, Time now);
  void begin(Time now);
  void act(Time at);
  void addressed(Time at);
  void byte_done(Time at);
  void bytes_over(Time at);
  void stop_at(Time at);
  void switch_off();
  [[nodiscard]] Time bits(unsigned count) const { return count * bit_; }

  Complain complain_;
  I2cDevice* device_{};
  bool pins_{};
  std::uint32_t control1_{}, control2_{}, timing_{}, status_{1}, received_{}, to_send_{};
  State state_{State::idle};
  unsigned left_{};
  Time bit_{120};
  Time due_{kNever};
};

class Stm32Spi {
 public:
  explicit Stm32Spi(Complain complain) : complain_(std::move(complain)) { reset(); }
  void reset();
  void connect(SpiDevice* device) { device_ = device; }
  /// `edge_hz`: the fastest clock that the outputs can follow.
  void set_pins(bool connected, std::uint32_t edge_hz) {
    pins_ = connected;
    edge_hz_ = edge_hz;
  }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, unsigned size);
  void write(std::uint32_t offset, unsigned size, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const { return due_; }
  [[nodiscard]] bool line() const {
    const std::uint32_t now = status();
    return ((control2_ & 0x40U) != 0 && (now & 1U) != 0) || ((control2_ & 0x80U) != 0 && (now & 2U) != 0);
  }

 private:
  static constexpr std::size_t kFifo = 4;  // bytes each way
  [[nodiscard]] std::uint32_t status() const;
  void push(std::uint8_t byte);
  void begin(Time now);
  [[nodiscard]] std::uint64_t rate_hz() const { return clock_hz_ >> (((control1_ >> 3) & 7U) + 1); }

  Complain complain_;
  SpiDevice* device_{};
  bool pins_{};
  std::uint32_t control1_{}, control2_{0x700}, clock_hz_{8'000'000}, edge_hz_{};
  bool overrun_{};
  std::deque<std::uint8_t> out_, in_;
  bool shifting_{};
  Time due_{kNever};
};

class Stm32Usart : public SerialLine {
 public:
  explicit Stm32Usart(Complain complain) : complain_(std::move(complain)) { reset(); }
  void reset();
  void set_pins(bool rxd, bool txd, bool rts, bool cts) {
    rxd_ = rxd;
    txd_ = txd;
    rts_pin_ = rts;
    cts_pin_ = cts;
  }
  /// RTS driven by the program as an ordinary output: its level.
  void set_rts_output(bool driven, bool high) {
    rts_output_ = driven;
    rts_high_ = high;
  }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const { return std::min(shift_done_, next_coming()); }
  [[nodiscard]] bool line() const;
  [[nodiscard]] bool may_send() const override;

 private:
  [[nodiscard]] std::uint32_t status() const;
  [[nodiscard]] bool baud_good() const;
  void begin(Time now);

  Complain complain_;
  bool rxd_{}, txd_{}, rts_pin_{}, cts_pin_{};
  bool rts_output_{}, rts_high_{};
  std::uint32_t control1_{}, control2_{}, control3_{}, divider_{}, clock_hz_{8'000'000};
  std::uint8_t received_{}, to_send_{}, shift_{};
  bool full_{}, waiting_{}, shifting_{};
  bool framing_{}, overrun_{}, complete_{true};
  Time shift_done_{kNever};
};

}  // namespace hoist::machine
