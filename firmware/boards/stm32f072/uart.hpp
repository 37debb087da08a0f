// USART1 at 1 Mbaud with both handshake lines done by the hardware (RM0091, chapter 27): 48 MHz / 48, exactly. One character at a time:
// this chip has no FIFO, and an interrupt takes a tenth of a character's 10 us.
//
// When the receiving ring is full the interrupt stops reading, RTS goes up, and the computer waits.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/stm32f072/clock.hpp"
#include "firmware/boards/stm32f072/registers.hpp"

namespace hoist::firmware::stm32f072 {

class Uart {
 public:
  void start() {
    set_pin<kUartTxd>(PinMode::alternate, PinPull::none, 1);
    set_pin<kUartRxd>(PinMode::alternate, PinPull::up, 1);
    set_pin<kUartCts>(PinMode::alternate, PinPull::up, 1);  // an absent computer does not assert CTS
    set_pin<kUartRts>(PinMode::alternate, PinPull::none, 1);
    rcc::Apb2Clocks::set(rcc::kUsart1);
    static_assert(kClock_hz % kUart_baud == 0);
    Divider::write(kClock_hz / kUart_baud);
    Control3::write((1U << 8) | (1U << 9));
    Control1::write(kOn | kReceiveData);
    cortex_m0::enable_interrupt(irq::kUsart1, kPriorityUart);
  }

  std::size_t read(std::span<char> in) {
    std::size_t count = 0;
    while (count < in.size() && received_.take(in[count])) ++count;
    if (count > 0) {
      const cortex_m0::InterruptsOff off;
      Control1::set(kReceiveData);
    }
    return count;
  }
  std::size_t write(std::span<const char> out) {
    std::size_t count = 0;
    while (count < out.size() && to_send_.put(out[count])) ++count;
    if (count > 0) {
      const cortex_m0::InterruptsOff off;
      Control1::set(kTransmitEmpty);
    }
    return count;
  }
  [[nodiscard]] std::uint32_t lost() const { return lost_; }
  [[nodiscard]] bool has_characters() const { return !received_.empty(); }

  void on_interrupt() {
    const std::uint32_t status = Status::read();
    if ((status & kErrors) != 0) {
      lost_ = lost_ + 1;
      damaged_ = true;
      Clear::write(kErrors);
    }
    if ((status & kReady) != 0) {
      if (received_.full()) {
        Control1::clear(kReceiveData);  // until the main loop has made room
      } else {
        const auto c = static_cast<char>(Received::read());
        (void)received_.put(damaged_ ? kDamaged : c);
        damaged_ = false;
      }
    }
    if ((status & kEmpty) != 0) {
      char c = 0;
      if (to_send_.take(c))
        ToSend::write(static_cast<std::uint8_t>(c));
      else
        Control1::clear(kTransmitEmpty);
    }
  }

 private:
  // Takes the place of a character that the line damaged: no command holds it, so the decoder drops the whole line.
  static constexpr char kDamaged = '\0';
  using Control1 = Register<0x40013800>;
  using Control3 = Register<0x40013808>;
  using Divider = Register<0x4001380C>;
  using Status = Register<0x4001381C>;
  using Clear = Register<0x40013820>;
  using Received = Register<0x40013824>;
  using ToSend = Register<0x40013828>;
  static constexpr std::uint32_t kOn = (1U << 0) | (1U << 2) | (1U << 3);
  static constexpr std::uint32_t kReceiveData = 1U << 5, kTransmitEmpty = 1U << 7;
  static constexpr std::uint32_t kErrors = (1U << 0) | (1U << 1) | (1U << 2) | (1U << 3);  // parity, framing, noise, overrun
  static constexpr std::uint32_t kReady = 1U << 5, kEmpty = 1U << 7;

  cortex_m0::Ring<char, 1024> received_{};
  cortex_m0::Ring<char, 512> to_send_{};
  volatile std::uint32_t lost_ = 0;
  bool damaged_ = false;  // the character that waits in RDR
};

}  // namespace hoist::firmware::stm32f072
