// UART at 1 Mbaud with hardware handshake on both lines (UM10398, chapter 13): 48 MHz / 16 / 3, exactly.
//
// When the receiving ring is full the interrupt stops reading; the FIFO fills to its trigger, RTS goes up, and the computer waits.
// Characters that are lost anyway, or damaged, are counted.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"

namespace hoist::firmware::lpc11c24 {

class Uart {
 public:
  void start() {
    set_pin<kUartRxd>(1, kPinPullUp);
    set_pin<kUartTxd>(1, kPinFloating);
    set_pin<kUartRts>(1, kPinFloating);
    set_pin<kUartCts>(1, kPinPullUp);  // an absent computer does not assert CTS
    syscon::AhbClocks::set(syscon::kUart);
    syscon::UartDivider::write(1);
    static_assert(kClock_hz % (16 * kUart_baud) == 0);
    LineControl::write(0x83);  // divisor
    DivisorLow::write(kClock_hz / (16 * kUart_baud));
    DivisorHigh::write(0);
    Fraction::write(0x10);  // no fraction
    LineControl::write(0x03);
    FifoControl::write(1U | 2U | 4U | (2U << 6));  // on, emptied, interrupt from 8 characters on
    ModemControl::write((1U << 6) | (1U << 7));
    cortex_m0::enable_interrupt(irq::kUart, kPriorityUart);
    InterruptEnable::write(kReceiveData | kTransmitEmpty | kLineStatus);
  }

  // Main loop.
  std::size_t read(std::span<char> in) {
    std::size_t count = 0;
    while (count < in.size() && received_.take(in[count])) ++count;
    if (count > 0 && stopped_) {
      stopped_ = false;
      const cortex_m0::InterruptsOff off;
      InterruptEnable::set(kReceiveData);
    }
    return count;
  }
  std::size_t write(std::span<const char> out) {
    std::size_t count = 0;
    while (count < out.size() && to_send_.put(out[count])) ++count;
    if (count > 0) {
      const cortex_m0::InterruptsOff off;
      if ((take_status() & kHoldingEmpty) != 0) fill();
    }
    return count;
  }
  [[nodiscard]] std::uint32_t lost() const { return lost_; }
  [[nodiscard]] bool has_characters() const { return !received_.empty(); }

  void on_interrupt() {
    // Reading the cause takes the transmit interrupt away; the others go with what made them.
    for (std::uint32_t i = 0; i < kCausesPerInterrupt; ++i) {
      const std::uint32_t cause = InterruptIdentity::read();
      if ((cause & 1U) != 0) return;
      const std::uint32_t status = take_status();
      take(status);
      if ((status & kHoldingEmpty) != 0) fill();
    }
  }

 private:
  // Takes the place of a character that the line damaged: no command holds it, so the decoder drops the whole line.
  static constexpr char kDamaged = '\0';
  using Data = Register<0x40008000>;
  using DivisorLow = Register<0x40008000>;
  using DivisorHigh = Register<0x40008004>;
  using InterruptEnable = Register<0x40008004>;
  using InterruptIdentity = Register<0x40008008>;
  using FifoControl = Register<0x40008008>;
  using LineControl = Register<0x4000800C>;
  using ModemControl = Register<0x40008010>;
  using LineStatus = Register<0x40008014>;
  using Fraction = Register<0x40008028>;
  static constexpr std::uint32_t kReceiveData = 1, kTransmitEmpty = 2, kLineStatus = 4;
  static constexpr std::uint32_t kReady = 1U << 0, kOverrun = 1U << 1, kParity = 1U << 2, kFraming = 1U << 3, kHoldingEmpty = 1U << 5;
  static constexpr std::uint32_t kFifo = 16;
  static constexpr std::uint32_t kCausesPerInterrupt = 8;

  // Reading the status clears its errors, which belong to the next character to be read, so they are noted here and nowhere else.
  std::uint32_t take_status() {
    const std::uint32_t status = LineStatus::read();
    if ((status & (kOverrun | kParity | kFraming)) != 0) {
      lost_ = lost_ + 1;
      damaged_ = true;
    }
    return status;
  }
  void take(std::uint32_t status) {
    for (std::uint32_t i = 0; i < kFifo && (status & kReady) != 0; ++i) {
      if (received_.full()) {
        stopped_ = true;
        InterruptEnable::clear(kReceiveData);
        return;
      }
      const auto c = static_cast<char>(Data::read());
      (void)received_.put(damaged_ ? kDamaged : c);
      damaged_ = false;
      status = take_status();
    }
  }
  void fill() {
    char c = 0;
    for (std::uint32_t i = 0; i < kFifo && to_send_.take(c); ++i) Data::write(static_cast<std::uint8_t>(c));
  }

  cortex_m0::Ring<char, 512> received_{};
  cortex_m0::Ring<char, 256> to_send_{};
  volatile bool stopped_ = false;
  volatile std::uint32_t lost_ = 0;
  bool damaged_ = false;  // only with the interrupt off or in it
};

}  // namespace hoist::firmware::lpc11c24
