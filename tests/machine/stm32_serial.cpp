#include "tests/machine/stm32_serial.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace hoist::machine {
namespace {

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

// I2C CR2
constexpr std::uint32_t kReadDirection = 1U << 10, kTenBit = 3U << 11, kStart = 1U << 13, kStop = 1U << 14, kReload = 1U << 24,
                        kAutoEnd = 1U << 25, kControl2Known = 0x07FFFFFF;
// I2C ISR
constexpr std::uint32_t kTxe = 1, kTxis = 2, kRxne = 4, kNackf = 0x10, kStopf = 0x20, kTc = 0x40, kBusy = 0x8000, kClearable = 0x3F38;
constexpr double kSynchronisation_s = 750e-9;  // RM0091, tables of I2C_TIMINGR examples: both edges of SCL together, fast mode
constexpr double kFastMode_hz = 400'000;

}  // namespace

// ---------------------------------------------------------------- I2C

void Stm32I2c::reset() {
  control1_ = timing_ = received_ = to_send_ = 0;
  switch_off();
}

void Stm32I2c::switch_off() {
  if (device_ != nullptr && state_ != State::idle) device_->i2c_stop(0);
  state_ = State::idle;
  due_ = kNever;
  status_ = kTxe;
  control2_ &= ~(kStart | kStop);
}

std::uint32_t Stm32I2c::read(std::uint32_t offset, Time now) {
  switch (offset) {
    case 0x00:
      return control1_;
    case 0x04:
      return control2_;
    case 0x10:
      return timing_;
    case 0x18:
      return status_ | (state_ == State::idle ? 0U : kBusy);
    case 0x24:
      if ((status_ & kRxne) == 0) complain_("I2C: empty receiver read");
      status_ &= ~kRxne;
      if (state_ == State::waiting_read) {
        state_ = State::receive;
        due_ = now + bits(1);
      }
      return std::exchange(received_, 0U);
    default:
      complain_("I2C: read of register " + hex(offset) + ", which is write-only, does not exist or is not modelled");
      return 0;
  }
}

void Stm32I2c::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t kernel_hz) {
  switch (offset) {
    case 0x00:
      if ((value & 0xFF002000U) != 0) complain_("I2C: reserved bits of CR1");
      if ((value & ~0xFFU) != 0) complain_("I2C: filters, DMA, slave or SMBus functions: not modelled");
      control1_ = value;
      if ((value & 1U) == 0) switch_off();
      return;
    case 0x04:
      write_control2(value, now);
      return;
    case 0x10: {
      if ((control1_ & 1U) != 0) complain_("I2C: TIMINGR written while PE is set");
      if ((value & 0x0F000000U) != 0) complain_("I2C: reserved bits of TIMINGR");
      timing_ = value;
      const double clocks = static_cast<double>(((value >> 28) + 1) * ((value & 0xFFU) + 1 + ((value >> 8) & 0xFFU) + 1));
      const double period_s = clocks / kernel_hz + kSynchronisation_s;
      if (period_s * kFastMode_hz < 0.999) complain_("I2C: SCL at " + std::to_string(1.0 / period_s) + " Hz, fast mode ends at 400 kHz");
      bit_ = std::max<Time>(1, static_cast<Time>(period_s * static_cast<double>(kSecond)));
      return;
    }
    case 0x1C:
      if ((value & ~kClearable) != 0) complain_("I2C: reserved bits of ICR");
      status_ &= ~(value & kClearable);
      return;
    case 0x28:
      if ((status_ & kTxis) == 0) complain_("I2C: TXDR written without TXIS");
      status_ &= ~(kTxis | kTxe);
      to_send_ = value & 0xFFU;
      if (state_ != State::waiting_data) return;
      state_ = State::transmit;
      due_ = now + bits(9);
      return;
    default:
      complain_("I2C: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
  }
}

void Stm32I2c::write_control2(std::uint32_t value, Time now) {
  if ((value & ~kControl2Known) != 0) complain_("I2C: reserved bits of CR2");
  if ((value & (kReload | kTenBit)) != 0) complain_("I2C: RELOAD or ten-bit addresses: not modelled");
  if ((control1_ & 1U) == 0) {
    complain_("I2C: CR2 written while PE is off");
    return;
  }
  if ((control2_ & kStart) != 0 && ((value ^ control2_) & 0x3FFU) != 0) complain_("I2C: address changed while START is set");
  // START and STOP are set by software and taken back by hardware only.
  control2_ = value | (control2_ & (kStart | kStop));
  if ((value & kStart) != 0) {
    if ((control2_ & kStop) != 0) complain_("I2C: START while a STOP is still asked for");
    if (!pins_) complain_("I2C: START without the pins switched to the block");
    if (state_ == State::idle || state_ == State::complete) begin(now);
    return;
  }
  if ((value & kStop) != 0 && state_ == State::complete) stop_at(now);
}

void Stm32I2c::begin(Time now) {
  status_ &= ~(kTc | kTxis);
  state_ = State::address;
  due_ = now + bits(10);
}

void Stm32I2c::stop_at(Time at) {
  status_ &= ~kTc;
  state_ = State::stopping;
  due_ = at + bits(1);
}

void Stm32I2c::bytes_over(Time at) {
  if ((control2_ & (kAutoEnd | kStop)) != 0) {
    stop_at(at);
    return;
  }
  status_ |= kTc;  // SCL is held low until START or STOP
  state_ = State::complete;
  due_ = kNever;
}

void Stm32I2c::addressed(Time at) {
  control2_ &= ~kStart;
  const bool reads = (control2_ & kReadDirection) != 0;
  left_ = (control2_ >> 16) & 0xFFU;
  if (!pins_ || device_ == nullptr || !device_->i2c_address(static_cast<std::uint8_t>((control2_ >> 1) & 0x7FU), reads, at)) {
    status_ |= kNackf;  // STOP follows automatically
    stop_at(at);
    return;
  }
  if (left_ == 0) {
    bytes_over(at);
    return;
  }
  if (reads) {
    state_ = State::receive;
    due_ = at + bits(9);
  } else {
    state_ = State::waiting_data;
    status_ |= kTxis | kTxe;
    due_ = kNever;
  }
}

void Stm32I2c::byte_done(Time at) {
  if (state_ == State::transmit) {
    status_ |= kTxe;
    if (!device_->i2c_write(static_cast<std::uint8_t>(to_send_), at)) {
      status_ |= kNackf;
      stop_at(at);
      return;
    }
    if (--left_ == 0) {
      bytes_over(at);
      return;
    }
    state_ = State::waiting_data;
    status_ |= kTxis;
    due_ = kNever;
    return;
  }
  if ((status_ & kRxne) != 0) {  // SCL is stretched until the byte before is fetched
    state_ = State::waiting_read;
    due_ = kNever;
    return;
  }
  received_ = device_->i2c_read(left_ > 1, at);
  status_ |= kRxne;
  if (--left_ == 0)
    bytes_over(at);
  else
    due_ = at + bits(9);
}

void Stm32I2c::act(Time at) {
  due_ = kNever;
  switch (state_) {
    case State::address:
      addressed(at);
      return;
    case State::transmit:
    case State::receive:
      byte_done(at);
      return;
    case State::stopping:
      if (device_ != nullptr) device_->i2c_stop(at);
      control2_ &= ~kStop;
      status_ |= kStopf;
      state_ = State::idle;
      return;
    default:
      return;
  }
}

void Stm32I2c::advance(Time now) {
  while (due_ <= now) act(due_);
}

// ---------------------------------------------------------------- SPI

void Stm32Spi::reset() {
  control1_ = 0;
  control2_ = 0x700;
  overrun_ = shifting_ = false;
  out_.clear();
  in_.clear();
  due_ = kNever;
}

std::uint32_t Stm32Spi::status() const {
  const std::size_t threshold = (control2_ & 0x1000U) != 0 ? 1 : 2;
  const auto level = [](std::size_t bytes) { return static_cast<std::uint32_t>(std::min<std::size_t>(bytes, 3)); };
  return (in_.size() >= threshold ? 1U : 0U) | (out_.size() <= kFifo / 2 ? 2U : 0U) | (overrun_ ? 0x40U : 0U) |
         (shifting_ || !out_.empty() ? 0x80U : 0U) | (level(in_.size()) << 9) | (level(out_.size()) << 11);
}

std::uint32_t Stm32Spi::read(std::uint32_t offset, unsigned size) {
  switch (offset) {
    case 0x00:
      return control1_;
    case 0x04:
      return control2_;
    case 0x08:
      return status();
    case 0x0C: {
      std::uint32_t value = 0;
      for (unsigned i = 0; i < std::min(size, 2U); ++i) {
        if (in_.empty()) {
          complain_("SPI: empty receive FIFO read");
          break;
        }
        value |= static_cast<std::uint32_t>(in_.front()) << (8 * i);
        in_.pop_front();
      }
      return value;
    }
    default:
      complain_("SPI: read of register " + hex(offset) + ", which does not exist or is not modelled");
      return 0;
  }
}

void Stm32Spi::push(std::uint8_t byte) {
  if (out_.size() == kFifo) {
    complain_("SPI: full transmit FIFO written");
    return;
  }
  out_.push_back(byte);
}

void Stm32Spi::write(std::uint32_t offset, unsigned size, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  clock_hz_ = clock_hz;
  switch (offset) {
    case 0x00:
      if ((value & ~0xFFFFU) != 0) complain_("SPI: reserved bits of CR1");
      if ((control1_ & value & 0x40U) != 0 && ((control1_ ^ value) & 0x33FU) != 0) complain_("SPI: CR1 changed while the block is on");
      if ((value & 0xFC80U) != 0) complain_("SPI: LSB first, CRC, one line or receive only: not modelled");
      control1_ = value;
      if ((value & 0x40U) != 0) {
        if ((value & 0x304U) != 0x304U) complain_("SPI: on, but not a master with its select by software: not modelled");
        if (((control2_ >> 8) & 0xFU) != 7) complain_("SPI: frames that are not of 8 bits: not modelled");
      }
      begin(now);
      return;
    case 0x04:
      if ((value & ~0x7FFFU) != 0) complain_("SPI: reserved bits of CR2");
      if ((value & 0x601BU) != 0) complain_("SPI: DMA, NSS pulses or TI mode: not modelled");
      if ((control1_ & 0x40U) != 0 && ((control2_ ^ value) & 0xF00U) != 0) complain_("SPI: data size changed while the block is on");
      control2_ = value;
      return;
    case 0x0C:
      if ((control1_ & 0x40U) == 0) complain_("SPI: data written while the block is off");
      if (!pins_) complain_("SPI: data written without the pins switched to the block");
      push(static_cast<std::uint8_t>(value));
      if (size > 1) push(static_cast<std::uint8_t>(value >> 8));  // data packing: two frames
      begin(now);
      return;
    default:
      complain_("SPI: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
  }
}

void Stm32Spi::begin(Time now) {
  if (shifting_ || out_.empty() || (control1_ & 0x40U) == 0) return;
  if (pins_ && rate_hz() > edge_hz_) complain_("SPI: clock faster than its pins (OSPEEDR)");
  shifting_ = true;
  due_ = now + 8 * kSecond / rate_hz();
}

void Stm32Spi::advance(Time now) {
  while (due_ <= now) {
    const Time at = due_;
    due_ = kNever;
    shifting_ = false;
    const std::uint8_t byte = out_.front();
    out_.pop_front();
    std::uint8_t answer = 0xFF;
    if (pins_ && device_ != nullptr) answer = device_->spi_exchange(byte, (control1_ & 2U) != 0, (control1_ & 1U) != 0, rate_hz(), at);
    if (in_.size() < kFifo) {
      in_.push_back(answer);
    } else {
      overrun_ = true;
      complain_("SPI: receive FIFO overrun");
    }
    begin(at);
  }
}

// ---------------------------------------------------------------- USART

namespace {
constexpr std::uint32_t kUe = 1, kRe = 4, kTe = 8, kRxneIe = 0x20, kTcIe = 0x40, kTxeIe = 0x80, kRtse = 0x100, kCtse = 0x200, kEie = 1;
}

void Stm32Usart::reset() {
  control1_ = control2_ = control3_ = divider_ = 0;
  full_ = waiting_ = shifting_ = framing_ = overrun_ = false;
  complete_ = true;
  shift_done_ = kNever;
}

bool Stm32Usart::baud_good() const {
  if (divider_ < 16) return false;
  return std::fabs(static_cast<double>(clock_hz_) / divider_ - line_baud_) <= kBaudTolerance * line_baud_;
}

std::uint32_t Stm32Usart::status() const {
  return (framing_ ? 2U : 0U) | (overrun_ ? 8U : 0U) | (full_ ? 0x20U : 0U) | (complete_ ? 0x40U : 0U) | (waiting_ ? 0U : 0x80U) |
         (cts_ && cts_pin_ ? 0x400U : 0U) | ((control1_ & (kUe | kTe)) == (kUe | kTe) ? 0x200000U : 0U) |
         ((control1_ & (kUe | kRe)) == (kUe | kRe) ? 0x400000U : 0U);
}

bool Stm32Usart::line() const {
  const bool errors = (control3_ & kEie) != 0 && (framing_ || overrun_);
  return ((control1_ & kRxneIe) != 0 && (full_ || overrun_)) || ((control1_ & kTcIe) != 0 && complete_) ||
         ((control1_ & kTxeIe) != 0 && !waiting_) || errors;
}

bool Stm32Usart::may_send() const {
  if (rts_output_) return !rts_high_;
  return rts_pin_ && (control1_ & kUe) != 0 && (control3_ & kRtse) != 0 && !full_;
}

std::uint32_t Stm32Usart::read(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return control1_;
    case 0x04:
      return control2_;
    case 0x08:
      return control3_;
    case 0x0C:
      return divider_;
    case 0x1C:
      return status();
    case 0x24:
      if (!full_) complain_("USART: empty receiver read");
      full_ = false;
      return received_;
    case 0x28:
      return to_send_;
    default:
      complain_("USART: read of register " + hex(offset) + ", which is write-only, does not exist or is not modelled");
      return 0;
  }
}

void Stm32Usart::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  clock_hz_ = clock_hz;
  const bool on = (control1_ & kUe) != 0;
  switch (offset) {
    case 0x00:
      if ((value & 0xE0000000U) != 0) complain_("USART: reserved bits of CR1");
      if ((value & ~0xEDU) != 0) complain_("USART: CR1 asks for what is not modelled");
      if ((value & kUe) != 0 && !on && !baud_good())
        complain_("USART: " + std::to_string(divider_ == 0 ? 0 : clock_hz / divider_) + " baud, the line has " +
                  std::to_string(line_baud_));
      control1_ = value;
      begin(now);
      return;
    case 0x04:
      if (value != 0) complain_("USART: CR2 asks for what is not modelled");
      return;
    case 0x08:
      if (on && ((value ^ control3_) & (kRtse | kCtse)) != 0) complain_("USART: handshake changed while UE is set");
      if ((value & ~(kRtse | kCtse | kEie)) != 0) complain_("USART: CR3 asks for what is not modelled");
      control3_ = value;
      return;
    case 0x0C:
      if (on) complain_("USART: BRR written while UE is set");
      if ((value & ~0xFFFFU) != 0 || value < 16) complain_("USART: BRR out of range");
      divider_ = value & 0xFFFFU;
      return;
    case 0x20:
      if ((value & ~0x121B5FU) != 0) complain_("USART: reserved bits of ICR");
      if ((value & 2U) != 0) framing_ = false;
      if ((value & 8U) != 0) overrun_ = false;
      if ((value & 0x40U) != 0) complete_ = false;
      return;
    case 0x28:
      if ((control1_ & (kUe | kTe)) != (kUe | kTe)) complain_("USART: TDR written while the transmitter is off");
      if (!txd_) complain_("USART: sending without the pin switched to the block");
      if (waiting_) complain_("USART: full transmitter written");
      to_send_ = static_cast<std::uint8_t>(value);
      waiting_ = true;
      complete_ = false;
      begin(now);
      return;
    default:
      complain_("USART: write to register " + hex(offset) + ", which is read-only, does not exist or is not modelled");
  }
}

void Stm32Usart::begin(Time now) {
  if (shifting_ || !waiting_ || (control1_ & (kUe | kTe)) != (kUe | kTe)) return;
  if ((control3_ & kCtse) != 0 && !(cts_ && cts_pin_)) return;
  shift_ = to_send_;
  waiting_ = false;
  shifting_ = true;
  shift_done_ = now + character();
}

void Stm32Usart::advance(Time now) {
  while (!coming_.empty() && coming_.front().at <= now) {
    const Coming coming = coming_.front();
    coming_.pop_front();
    if (!rxd_ || (control1_ & (kUe | kRe)) != (kUe | kRe)) continue;
    if (full_) {  // the character in the shift register is lost, the one in RDR stays
      overrun_ = true;
      ++overruns_;
      continue;
    }
    framing_ = framing_ || !baud_good() || coming.wrong;
    received_ = baud_good() ? coming.byte : static_cast<std::uint8_t>(~coming.byte);
    full_ = true;
  }
  while (shift_done_ <= now) {
    const Time at = shift_done_;
    shift_done_ = kNever;
    shifting_ = false;
    if (txd_) received_by_line.push_back(shift_);
    begin(at);
    complete_ = !shifting_ && !waiting_;
  }
  begin(now);
}

}  // namespace hoist::machine
