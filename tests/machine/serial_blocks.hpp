// I2C, SSP and UART of the LPC11C24 (UM10398 chapters 15, 14, 12), each with time: a byte takes as long as its bits.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>

#include "tests/machine/time.hpp"

namespace hoist::machine {

/// A chip on an I2C bus. True = acknowledged.
class I2cDevice {
 public:
  virtual ~I2cDevice() = default;
  [[nodiscard]] virtual bool i2c_address(std::uint8_t address, bool read, Time now) = 0;
  [[nodiscard]] virtual bool i2c_write(std::uint8_t byte, Time now) = 0;
  [[nodiscard]] virtual std::uint8_t i2c_read(bool acknowledged, Time now) = 0;
  virtual void i2c_stop(Time now) = 0;
};

/// A chip on an SPI bus with its own select line.
class SpiDevice {
 public:
  virtual ~SpiDevice() = default;
  virtual void spi_select(bool selected, Time now) = 0;
  [[nodiscard]] virtual std::uint8_t spi_exchange(std::uint8_t byte, bool cpol, bool cpha, std::uint64_t clock_hz, Time now) = 0;
};

class I2c {
 public:
  explicit I2c(Complain complain) : complain_(std::move(complain)) {}
  void reset();
  void connect(I2cDevice* device) { device_ = device; }
  /// Whether the pins are switched to the block.
  void set_pins(bool connected) { pins_ = connected; }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const { return due_; }
  [[nodiscard]] bool line() const { return (control_ & 8U) != 0; }
  /// SDA held low by a stuck chip: the bus is blocked.
  void hold_low(bool held) { held_ = held; }

 private:
  enum class State : std::uint8_t { idle, starting, address, transmit, receive };
  void act(Time now);
  void interrupt(std::uint32_t status);
  [[nodiscard]] Time bits(unsigned count) const { return count * bit_; }

  Complain complain_;
  I2cDevice* device_{};
  bool pins_{};
  bool held_{};
  std::uint32_t control_{}, status_{0xF8}, data_{}, high_{4}, low_{4};
  State state_{State::idle};
  bool acknowledged_{};
  Time bit_{1};
  Time due_{kNever};
};

class Ssp {
 public:
  Ssp(const char* name, Complain complain) : name_(name), complain_(std::move(complain)) {}
  void reset();
  void connect(SpiDevice* device) { device_ = device; }
  void set_pins(bool connected) { pins_ = connected; }
  void set_divider(std::uint32_t divider) { divider_ = divider; }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, Time now);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const { return due_; }
  [[nodiscard]] bool line() const { return (raw() & mask_) != 0; }

 private:
  static constexpr std::size_t kFifo = 8;
  void begin(Time now);
  [[nodiscard]] std::uint32_t raw() const;
  const char* name_;
  Complain complain_;
  SpiDevice* device_{};
  bool pins_{};
  std::uint32_t divider_{};
  std::uint32_t control0_{}, control1_{}, prescale_{}, mask_{};
  std::uint32_t clock_hz_{12'000'000};
  bool overrun_{};
  std::deque<std::uint16_t> out_, in_;
  bool shifting_{};
  Time due_{kNever};
};

/// The wires of a serial line with a computer at their other end: `baud`, eight bits, no parity, one stop bit.
class SerialLine {
 public:
  virtual ~SerialLine() = default;
  void set_line_baud(std::uint32_t baud) { line_baud_ = baud; }
  /// Sends a byte to the chip; it arrives one character later. The caller must check may_send().
  void line_send(std::uint8_t byte, Time now);
  /// The nth character from now comes with its lowest bit and its stop bit wrong, as by a disturbance.
  void disturb(std::size_t nth) { disturb_in_ = nth; }
  [[nodiscard]] std::size_t line_waiting() const { return coming_.size(); }
  /// The chip's RTS is low: it has room.
  [[nodiscard]] virtual bool may_send() const = 0;
  void set_cts(bool go) { cts_ = go; }
  std::deque<std::uint8_t> received_by_line;
  [[nodiscard]] std::uint64_t overruns() const { return overruns_; }

 protected:
  static constexpr double kBaudTolerance = 0.02;  ///< each end may be off by about this much before the last bit is read wrongly
  struct Coming {
    std::uint8_t byte;
    Time at;
    bool wrong = false;
  };
  [[nodiscard]] Time character() const { return static_cast<Time>(static_cast<double>(kSecond) * 10.0 / line_baud_); }
  [[nodiscard]] Time next_coming() const { return coming_.empty() ? kNever : coming_.front().at; }

  std::uint32_t line_baud_{1'000'000};
  std::deque<Coming> coming_;
  std::size_t disturb_in_{};
  bool cts_{true};
  std::uint64_t overruns_{};
};

class Uart : public SerialLine {
 public:
  explicit Uart(Complain complain) : complain_(std::move(complain)) { reset(); }
  void reset();
  void set_pins(bool rxd, bool txd, bool rts, bool cts) {
    rxd_ = rxd;
    txd_ = txd;
    rts_pin_ = rts;
    cts_pin_ = cts;
  }
  void set_divider(std::uint32_t divider) { divider_ = divider; }
  [[nodiscard]] std::uint32_t read(std::uint32_t offset, Time now);
  void write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz);
  void advance(Time now);
  [[nodiscard]] Time next() const;
  [[nodiscard]] bool line() const { return cause() != 1; }

  [[nodiscard]] bool may_send() const override;

 private:
  static constexpr std::size_t kFifo = 16;
  [[nodiscard]] std::uint32_t cause() const;
  /// Errors of a character show while it is the next to be read.
  [[nodiscard]] bool framing() const { return !in_.empty() && in_.front().wrong; }
  [[nodiscard]] double baud(std::uint32_t clock_hz) const;
  [[nodiscard]] std::size_t trigger() const;
  void begin(Time now);

  Complain complain_;
  bool rxd_{}, txd_{}, rts_pin_{}, cts_pin_{};
  std::uint32_t divider_{}, clock_hz_{12'000'000};
  std::uint32_t dll_{}, dlm_{}, fdr_{}, lcr_{}, mcr_{}, ier_{}, fcr_{}, scr_{}, ter_{};
  bool checked_{};
  std::deque<std::uint8_t> out_;
  std::deque<Coming> in_;
  bool shifting_{};
  std::uint8_t shift_{};
  Time shift_done_{kNever};
  Time last_received_{};
  bool timeout_{};
  bool thre_pending_{};
  bool overrun_{};
};

}  // namespace hoist::machine
