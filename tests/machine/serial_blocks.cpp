#include "tests/machine/serial_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace hoist::machine {
namespace {

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

}  // namespace

// ---------------------------------------------------------------- I2C

namespace {
constexpr std::uint32_t kAa = 4, kSi = 8, kSto = 0x10, kSta = 0x20, kI2En = 0x40;
}

void I2c::reset() {
  control_ = 0;
  status_ = 0xF8;
  data_ = 0;
  high_ = low_ = 4;
  state_ = State::idle;
  due_ = kNever;
}

std::uint32_t I2c::read(std::uint32_t offset) {
  switch (offset) {
    case 0x00:
      return control_;
    case 0x04:
      return status_;
    case 0x08:
      return data_;
    case 0x10:
      return high_;
    case 0x14:
      return low_;
    case 0x0C:
    case 0x1C:
    case 0x20:
    case 0x24:
    case 0x28:
    case 0x2C:
      return 0;
    default:
      complain_("I2C: read of register " + hex(offset) + ", which is write-only or does not exist");
      return 0;
  }
}

void I2c::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  const Time unit = kSecond / clock_hz;
  switch (offset) {
    case 0x00:
      if ((value & ~0x7CU) != 0) complain_("I2C: reserved bits of CONSET");
      control_ |= value & 0x7CU;
      break;
    case 0x18:
      if ((value & ~0x6CU) != 0) complain_("I2C: reserved bits of CONCLR");
      if ((value & kSi) != 0 && (control_ & kSi) != 0) status_ = 0xF8;
      control_ &= ~(value & 0x6CU);
      if ((control_ & kI2En) == 0) {
        state_ = State::idle;
        due_ = kNever;
        return;
      }
      break;
    case 0x08:
      if ((control_ & kSi) == 0 && state_ != State::idle) complain_("I2C: data register written while the block is shifting");
      data_ = value & 0xFFU;
      return;
    case 0x10:
      if (value < 4) complain_("I2C: SCLH below 4");
      high_ = value & 0xFFFFU;
      return;
    case 0x14:
      if (value < 4) complain_("I2C: SCLL below 4");
      low_ = value & 0xFFFFU;
      return;
    case 0x0C:
      return;  // own address: not a slave here
    default:
      complain_("I2C: write to register " + hex(offset) + ", which is read-only or does not exist");
      return;
  }
  if ((control_ & kI2En) == 0 || (control_ & kSi) != 0 || due_ != kNever) return;
  bit_ = std::max<Time>(1, (high_ + low_) * unit);
  if (kSecond / bit_ > 400'000) {
    complain_("I2C: clock of " + std::to_string(kSecond / bit_) + " Hz, 400 kHz is the most");
    bit_ = kSecond / 400'000;
  }
  act(now);
}

// After SI was cleared or START requested: the block's next bus action.
void I2c::act(Time now) {
  if (!pins_) {
    if ((control_ & kSta) != 0) complain_("I2C: START without the pins switched to the block");
    return;
  }
  if (held_) return;
  if ((control_ & kSto) != 0) {
    if (device_ != nullptr && state_ != State::idle) device_->i2c_stop(now);
    control_ &= ~kSto;
    status_ = 0xF8;
    state_ = State::idle;
    if ((control_ & kSta) == 0) return;
  }
  if ((control_ & kSta) != 0) {
    state_ = state_ == State::idle ? State::starting : State::address;
    due_ = now + bits(state_ == State::starting ? 1 : 2);
    acknowledged_ = state_ == State::address;  // a repeated start
    state_ = State::starting;
    return;
  }
  switch (state_) {
    case State::starting:  // the address is in the data register
      state_ = State::address;
      due_ = now + bits(9);
      return;
    case State::transmit:
      due_ = now + bits(9);
      return;
    case State::receive:
      due_ = now + bits(9);
      return;
    default:
      return;
  }
}

void I2c::interrupt(std::uint32_t status) {
  status_ = status;
  control_ |= kSi;
}

void I2c::advance(Time now) {
  if (due_ > now) return;
  const Time at = due_;
  due_ = kNever;
  switch (state_) {
    case State::starting:
      interrupt(acknowledged_ ? 0x10 : 0x08);
      return;
    case State::address: {
      const bool reading = (data_ & 1U) != 0;
      const bool acknowledged = device_ != nullptr && device_->i2c_address(static_cast<std::uint8_t>(data_ >> 1), reading, at);
      state_ = reading ? State::receive : State::transmit;
      if ((control_ & kSta) != 0) complain_("I2C: STA still set while the address goes out");
      interrupt(reading ? (acknowledged ? 0x40U : 0x48U) : (acknowledged ? 0x18U : 0x20U));
      return;
    }
    case State::transmit: {
      const bool acknowledged = device_ != nullptr && device_->i2c_write(static_cast<std::uint8_t>(data_), at);
      interrupt(acknowledged ? 0x28 : 0x30);
      return;
    }
    case State::receive: {
      const bool acknowledged = (control_ & kAa) != 0;
      data_ = device_ != nullptr ? device_->i2c_read(acknowledged, at) : 0xFFU;
      interrupt(acknowledged ? 0x50 : 0x58);
      return;
    }
    case State::idle:
      return;
  }
}

// ---------------------------------------------------------------- SSP

void Ssp::reset() {
  control0_ = control1_ = prescale_ = mask_ = 0;
  overrun_ = shifting_ = false;
  out_.clear();
  in_.clear();
  due_ = kNever;
}

std::uint32_t Ssp::raw() const { return (overrun_ ? 1U : 0U) | (in_.size() >= kFifo / 2 ? 4U : 0U) | (out_.size() <= kFifo / 2 ? 8U : 0U); }

std::uint32_t Ssp::read(std::uint32_t offset, Time now) {
  (void)now;
  switch (offset) {
    case 0x00:
      return control0_;
    case 0x04:
      return control1_;
    case 0x08: {
      if (in_.empty()) {
        complain_(std::string(name_) + ": empty receive FIFO read");
        return 0;
      }
      const std::uint16_t value = in_.front();
      in_.pop_front();
      return value;
    }
    case 0x0C:
      return (out_.empty() ? 1U : 0U) | (out_.size() < kFifo ? 2U : 0U) | (in_.empty() ? 0U : 4U) | (in_.size() == kFifo ? 8U : 0U) |
             (shifting_ || !out_.empty() ? 0x10U : 0U);
    case 0x10:
      return prescale_;
    case 0x14:
      return mask_;
    case 0x18:
      return raw();
    case 0x1C:
      return raw() & mask_;
    default:
      complain_(std::string(name_) + ": read of register " + hex(offset) + ", which is write-only or does not exist");
      return 0;
  }
}

void Ssp::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  clock_hz_ = clock_hz;
  switch (offset) {
    case 0x00:
      if ((value >> 16) != 0) complain_(std::string(name_) + ": reserved bits of CR0");
      if ((control1_ & 2U) != 0 && shifting_) complain_(std::string(name_) + ": CR0 changed while shifting");
      if ((value & 0xFU) != 7) complain_(std::string(name_) + ": frames of another size than 8 bits: not modelled");
      if ((value & 0x30U) != 0) complain_(std::string(name_) + ": frame format other than SPI: not modelled");
      control0_ = value & 0xFFFFU;
      return;
    case 0x04:
      if ((value & ~0xFU) != 0) complain_(std::string(name_) + ": reserved bits of CR1");
      if ((value & 4U) != 0) complain_(std::string(name_) + ": slave mode: not modelled");
      control1_ = value & 0xFU;
      begin(now);
      return;
    case 0x08:
      if (out_.size() >= kFifo) {
        complain_(std::string(name_) + ": full transmit FIFO written");
        return;
      }
      out_.push_back(static_cast<std::uint16_t>(value & 0xFFU));
      begin(now);
      return;
    case 0x10:
      if ((value & 1U) != 0 || value < 2 || value > 254) complain_(std::string(name_) + ": prescaler must be even, 2 to 254");
      prescale_ = value & 0xFEU;
      return;
    case 0x14:
      mask_ = value & 0xFU;
      return;
    case 0x20:
      if ((value & 1U) != 0) overrun_ = false;
      return;
    default:
      complain_(std::string(name_) + ": write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

void Ssp::begin(Time now) {
  if (shifting_ || out_.empty() || (control1_ & 2U) == 0) return;
  if (divider_ == 0) {
    complain_(std::string(name_) + ": enabled with its clock divider at 0");
    return;
  }
  if (prescale_ == 0) {
    complain_(std::string(name_) + ": enabled with its prescaler at 0");
    return;
  }
  const Time bit = (kSecond / clock_hz_) * divider_ * prescale_ * (((control0_ >> 8) & 0xFFU) + 1);
  shifting_ = true;
  due_ = now + 8 * bit;
}

void Ssp::advance(Time now) {
  while (due_ <= now) {
    const Time at = due_;
    due_ = kNever;
    shifting_ = false;
    const auto byte = static_cast<std::uint8_t>(out_.front());
    out_.pop_front();
    const std::uint64_t rate = clock_hz_ / (static_cast<std::uint64_t>(divider_) * prescale_ * (((control0_ >> 8) & 0xFFU) + 1));
    std::uint8_t answer = 0xFF;
    if ((control1_ & 1U) != 0)
      answer = byte;
    else if (pins_ && device_ != nullptr)
      answer = device_->spi_exchange(byte, (control0_ & 0x40U) != 0, (control0_ & 0x80U) != 0, rate, at);
    if (in_.size() < kFifo)
      in_.push_back(answer);
    else {
      overrun_ = true;
      complain_(std::string(name_) + ": receive FIFO overrun");
    }
    begin(at);
  }
}

// ---------------------------------------------------------------- UART

void SerialLine::line_send(std::uint8_t byte, Time now) {
  const Time from = coming_.empty() ? now : std::max(now, coming_.back().at);
  const bool wrong = disturb_in_ > 0 && --disturb_in_ == 0;
  coming_.push_back({static_cast<std::uint8_t>(wrong ? byte ^ 1U : byte), from + character(), wrong});
}

void Uart::reset() {
  dll_ = 1;
  dlm_ = 0;
  fdr_ = 0x10;
  lcr_ = mcr_ = ier_ = fcr_ = scr_ = 0;
  ter_ = 0x80;
  checked_ = false;
  out_.clear();
  in_.clear();
  shifting_ = false;
  shift_done_ = kNever;
  timeout_ = thre_pending_ = overrun_ = false;
}

double Uart::baud(std::uint32_t clock_hz) const {
  const std::uint32_t latch = (dlm_ << 8) | dll_;
  if (latch == 0 || divider_ == 0) return 0.0;
  const double add = fdr_ & 0xFU, mul = (fdr_ >> 4) & 0xFU;
  const double clock = static_cast<double>(clock_hz) / divider_;
  return clock / (16.0 * latch * (1.0 + add / std::max(mul, 1.0)));
}
std::size_t Uart::trigger() const {
  if ((fcr_ & 1U) == 0) return 1;
  constexpr std::array<std::size_t, 4> kLevels{1, 4, 8, 14};
  return kLevels[(fcr_ >> 6) & 3U];
}

// The cause as IIR shows it: bit 0 set = none.
std::uint32_t Uart::cause() const {
  if ((ier_ & 4U) != 0 && (overrun_ || framing())) return 6;
  if ((ier_ & 1U) != 0 && in_.size() >= trigger()) return 4;
  if ((ier_ & 1U) != 0 && timeout_) return 12;
  if ((ier_ & 2U) != 0 && thre_pending_) return 2;
  return 1;
}

std::uint32_t Uart::read(std::uint32_t offset, Time now) {
  const bool latch = (lcr_ & 0x80U) != 0;
  switch (offset) {
    case 0x00: {
      if (latch) return dll_;
      if (in_.empty()) {
        complain_("UART: empty receiver read");
        return 0;
      }
      const std::uint8_t byte = in_.front().byte;
      in_.pop_front();
      timeout_ = false;
      last_received_ = now;
      return byte;
    }
    case 0x04:
      return latch ? dlm_ : ier_;
    case 0x08: {
      const std::uint32_t value = cause();
      if (value == 2) thre_pending_ = false;
      return value | ((fcr_ & 1U) != 0 ? 0xC0U : 0U);
    }
    case 0x0C:
      return lcr_;
    case 0x10:
      return mcr_;
    case 0x14: {
      const std::uint32_t value = (in_.empty() ? 0U : 1U) | (overrun_ ? 2U : 0U) | (framing() ? 8U : 0U) | (out_.empty() ? 0x20U : 0U) |
                                  (out_.empty() && !shifting_ ? 0x40U : 0U);
      overrun_ = false;
      if (!in_.empty()) in_.front().wrong = false;
      return value;
    }
    case 0x18:
      return cts_ && cts_pin_ ? 0x10 : 0;
    case 0x1C:
      return scr_;
    case 0x28:
      return fdr_;
    case 0x30:
      return ter_;
    default:
      complain_("UART: read of register " + hex(offset) + ", which does not exist or is not modelled");
      return 0;
  }
}

void Uart::write(std::uint32_t offset, std::uint32_t value, Time now, std::uint32_t clock_hz) {
  clock_hz_ = clock_hz;
  const bool latch = (lcr_ & 0x80U) != 0;
  switch (offset) {
    case 0x00:
      if (latch) {
        dll_ = value & 0xFFU;
        checked_ = false;
        return;
      }
      if (!checked_) {
        checked_ = true;
        const double rate = baud(clock_hz);
        if (std::fabs(rate - line_baud_) > kBaudTolerance * line_baud_)
          complain_("UART: " + std::to_string(rate) + " baud, the line has " + std::to_string(line_baud_));
        if ((lcr_ & 0x3FU) != 3) complain_("UART: not eight bits, no parity, one stop bit");
        if (!txd_) complain_("UART: sending without the pin switched to the block");
      }
      if (out_.size() >= ((fcr_ & 1U) != 0 ? kFifo : 1)) {
        complain_("UART: full transmitter written");
        return;
      }
      out_.push_back(static_cast<std::uint8_t>(value));
      thre_pending_ = false;
      begin(now);
      return;
    case 0x04:
      if (latch) {
        dlm_ = value & 0xFFU;
        checked_ = false;
        return;
      }
      if ((value & ~0x30FU) != 0) complain_("UART: reserved bits of IER");
      if ((value & 2U) != 0 && (ier_ & 2U) == 0 && out_.empty()) thre_pending_ = true;
      ier_ = value & 0x30FU;
      return;
    case 0x08:
      if ((value & ~0xC7U) != 0) complain_("UART: reserved bits of FCR");
      fcr_ = value & 0xC1U;
      if ((value & 2U) != 0) in_.clear();
      if ((value & 4U) != 0) out_.clear();
      return;
    case 0x0C:
      lcr_ = value & 0xFFU;
      return;
    case 0x10:
      if ((value & ~0xD3U) != 0) complain_("UART: reserved bits of MCR");
      mcr_ = value & 0xD3U;
      return;
    case 0x1C:
      scr_ = value & 0xFFU;
      return;
    case 0x28:
      if ((value & 0xF0U) == 0 || (value & 0xFU) >= ((value >> 4) & 0xFU))
        complain_("UART: fractional divider needs MULVAL above DIVADDVAL");
      fdr_ = value & 0xFFU;
      checked_ = false;
      return;
    case 0x30:
      ter_ = value & 0x80U;
      begin(now);
      return;
    default:
      complain_("UART: write to register " + hex(offset) + ", which does not exist or is not modelled");
  }
}

void Uart::begin(Time now) {
  const bool held = (mcr_ & 0x80U) != 0 && cts_pin_ && !cts_;
  if (shifting_ || out_.empty() || held || (ter_ & 0x80U) == 0) return;
  shift_ = out_.front();
  out_.pop_front();
  shifting_ = true;
  shift_done_ = now + character();
  if (out_.empty()) thre_pending_ = true;
}

bool Uart::may_send() const {
  if (!rts_pin_) return false;
  if ((mcr_ & 0x40U) != 0) return in_.size() < trigger();  // automatic: full up to the trigger level stops the sender
  return (mcr_ & 2U) != 0;
}

Time Uart::next() const {
  Time at = shift_done_;
  if (!coming_.empty()) at = std::min(at, coming_.front().at);
  if (!in_.empty() && !timeout_ && (fcr_ & 1U) != 0) at = std::min(at, last_received_ + 4 * character());
  return at;
}

void Uart::advance(Time now) {
  while (!coming_.empty() && coming_.front().at <= now) {
    const Coming coming = coming_.front();
    coming_.pop_front();
    if (!rxd_) continue;
    last_received_ = coming.at;
    timeout_ = false;
    const double rate = baud(clock_hz_);
    const bool wrong = std::fabs(rate - line_baud_) > kBaudTolerance * line_baud_ || (lcr_ & 0x3FU) != 3;
    if (in_.size() >= ((fcr_ & 1U) != 0 ? kFifo : 1)) {
      overrun_ = true;
      ++overruns_;
      continue;
    }
    in_.push_back({wrong ? static_cast<std::uint8_t>(~coming.byte) : coming.byte, coming.at, wrong || coming.wrong});
  }
  if (!in_.empty() && (fcr_ & 1U) != 0 && now >= last_received_ + 4 * character()) timeout_ = true;
  while (shift_done_ <= now) {
    const Time at = shift_done_;
    shift_done_ = kNever;
    shifting_ = false;
    if (txd_) received_by_line.push_back(shift_);
    begin(at);
  }
  begin(now);
}

}  // namespace hoist::machine
