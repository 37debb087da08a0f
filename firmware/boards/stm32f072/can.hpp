// The bxCAN controller of the STM32F072 at 250 kbit/s (RM0091, chapter 29).
//
// Three mailboxes send by identifier (TXFP = 0), shared out as transmit_order.hpp says; two frames of the same identifier never use them
// together, because then the mailbox number decides. Filter bank 0 passes everything to FIFO 0; unused frames are dropped in the interrupt.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/cortex_m0/can_filter.hpp"
#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/stm32f072/registers.hpp"
#include "firmware/boards/stm32f072/transmit_order.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware::stm32f072 {

using cortex_m0::CanFilter;

namespace bxcan {
inline constexpr std::uint32_t kBase = 0x40006400;
using Control = Register<kBase + 0x00>;
using Status = Register<kBase + 0x04>;
using Transmit = Register<kBase + 0x08>;
using Receive = Register<kBase + 0x0C>;
using Interrupts = Register<kBase + 0x14>;
using Errors = Register<kBase + 0x18>;
using BitTiming = Register<kBase + 0x1C>;
using ReceivedId = Register<kBase + 0x1B0>;
using ReceivedLength = Register<kBase + 0x1B4>;
using ReceivedLow = Register<kBase + 0x1B8>;
using ReceivedHigh = Register<kBase + 0x1BC>;
using FilterControl = Register<kBase + 0x200>;
using FilterMode = Register<kBase + 0x204>;
using FilterScale = Register<kBase + 0x20C>;
using FilterFifo = Register<kBase + 0x214>;
using FilterActive = Register<kBase + 0x21C>;
using Filter0Id = Register<kBase + 0x240>;
using Filter0Mask = Register<kBase + 0x244>;
inline constexpr std::uint32_t kTransmitBase = kBase + 0x180;  // mailboxes, 16 bytes each: id, length, low, high
inline constexpr std::uint32_t kMailboxes = 3;
inline constexpr std::uint32_t kAllDone = (1U << 0) | (1U << 8) | (1U << 16);    // RQCP, cleared by writing ones
inline constexpr std::uint32_t kAbortAll = (1U << 7) | (1U << 15) | (1U << 23);  // ABRQ
}  // namespace bxcan

// 48 MHz / 12 = 4 MHz, 16 quanta: 1 + 13 before the sample point (87.5 %), 2 after it, jump width 1.
inline constexpr std::uint32_t kBitTiming_250k = 11U | (12U << 16) | (1U << 20);
inline constexpr std::size_t kCanTransmitMax = 16;
inline constexpr std::size_t kCanReceiveMax = 32;
inline constexpr std::uint32_t kModeChange_loops = 100'000;  // leaving initialisation waits for 11 recessive bits

class Can {
 public:
  using CanFrame = contract::CanFrame;

  // False when the controller does not follow. Call once.
  [[nodiscard]] bool start(CanFilter filter) {
    filter_ = filter;
    set_pin<kCanRx>(PinMode::alternate, PinPull::up, 4);
    set_pin<kCanTx>(PinMode::alternate, PinPull::none, 4);
    rcc::Apb1Clocks::set(rcc::kCan);
    if (!enter_initialisation()) return false;
    bxcan::BitTiming::write(kBitTiming_250k);
    bxcan::FilterControl::set(1);
    bxcan::FilterMode::clear(1);
    bxcan::FilterScale::set(1);
    bxcan::Filter0Id::write(0);
    bxcan::Filter0Mask::write(0);
    bxcan::FilterFifo::clear(1);
    bxcan::FilterActive::set(1);
    bxcan::FilterControl::clear(1);
    bxcan::Interrupts::write((1U << 0) | (1U << 1));  // a mailbox is empty; FIFO 0 holds a frame
    // Without waiting: on a missing or stuck bus the controller never reaches the running state, and the node must still work.
    bxcan::Control::write(0);
    cortex_m0::enable_interrupt(irq::kCan, kPriorityCan);
    return true;
  }

  // Main loop. Sorted by identifier, equal ones in order; false when the queue is full.
  bool send(const CanFrame& frame) {
    if (waiting_count_ == kCanTransmitMax) return false;
    std::size_t at = waiting_count_++;
    for (; at > 0 && cortex_m0::arbitration_order(waiting_[at - 1]) > cortex_m0::arbitration_order(frame); --at)
      waiting_[at] = waiting_[at - 1];
    waiting_[at] = frame;
    (void)service();
    return true;
  }

  // Main loop, often: hands over what waits to mailboxes that are free. False when the controller has lost its configuration.
  bool service() {
    if (bxcan::BitTiming::read() != kBitTiming_250k) return false;
    if (restarting_ && (bxcan::Errors::read() & kBusOff) == 0) restarting_ = false;
    if (waiting_count_ == 0 || (bxcan::Status::read() & 1U) != 0) return true;
    // Read once: a mailbox that empties meanwhile must not go to the second of two equal frames.
    std::uint32_t empty = bxcan::Transmit::read() >> 26;  // TME
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_count_; ++i) {
      const std::uint32_t order = cortex_m0::arbitration_order(waiting_[i]);
      std::uint32_t free = bxcan::kMailboxes, taken = 0;
      std::array<std::uint32_t, bxcan::kMailboxes> orders{};
      bool same = false;
      for (std::uint32_t box = 0; box < bxcan::kMailboxes; ++box) {
        if (((empty >> box) & 1U) != 0)
          free = box;
        else
          same |= (orders[taken++] = order_[box]) == order;
      }
      // Frames behind one that waits for its class have a higher or equal identifier: order is kept.
      if (same || free == bxcan::kMailboxes || !may_take_mailbox(order, std::span(orders).first(taken))) {
        waiting_[kept++] = waiting_[i];
        continue;
      }
      order_[free] = order;
      empty &= ~(1U << free);
      hand_over(free, waiting_[i]);
    }
    waiting_count_ = kept;
    return true;
  }

  bool receive(CanFrame& frame) { return received_.take(frame); }
  [[nodiscard]] bool has_frame() const { return !received_.empty(); }
  [[nodiscard]] bool all_sent() const { return waiting_count_ == 0 && ((bxcan::Transmit::read() >> 26) & 7U) == 7U; }

  // Takes back what has not left: it is too old by now.
  void drop_unsent() {
    waiting_count_ = 0;
    bxcan::Transmit::write(bxcan::kAbortAll);
  }

  [[nodiscard]] CanHealth health() const {
    const std::uint32_t errors = bxcan::Errors::read();
    CanHealth health;
    health.tx_errors = static_cast<std::uint8_t>(errors >> 16);
    health.rx_errors = static_cast<std::uint8_t>(errors >> 24);
    health.lost = lost_;
    if ((errors & kBusOff) != 0)
      health.state = CanHealth::State::bus_off;
    else if ((errors & (1U << 1)) != 0)
      health.state = CanHealth::State::passive;
    else if ((errors & (1U << 0)) != 0)
      health.state = CanHealth::State::warning;
    return health;
  }

  // Starts recovery from bus-off: into initialisation and out again. Older frames would be stale and are dropped.
  void restart() {
    if (restarting_ || (bxcan::Errors::read() & kBusOff) == 0) return;
    waiting_count_ = 0;
    bxcan::Transmit::write(bxcan::kAbortAll);
    if (!enter_initialisation()) return;
    bxcan::Control::write(0);
    restarting_ = true;
  }

  void on_interrupt() {
    bxcan::Transmit::write(bxcan::kAllDone);  // sending continues in service(): this only wakes the main loop
    for (std::uint32_t i = 0; i < kCanReceiveMax && (bxcan::Receive::read() & 3U) != 0; ++i) take();
  }

 private:
  static constexpr std::uint32_t kBusOff = 1U << 2;

  static bool enter_initialisation() {
    bxcan::Control::write(1);  // and out of sleep
    for (std::uint32_t i = 0; i < kModeChange_loops; ++i)
      if ((bxcan::Status::read() & 3U) == 1U) return true;
    return false;
  }

  static void hand_over(std::uint32_t box, const CanFrame& frame) {
    const std::uint32_t base = bxcan::kTransmitBase + 16 * box;
    const auto word = [&frame](std::size_t at) {
      return static_cast<std::uint32_t>(frame.data[at]) | (static_cast<std::uint32_t>(frame.data[at + 1]) << 8) |
             (static_cast<std::uint32_t>(frame.data[at + 2]) << 16) | (static_cast<std::uint32_t>(frame.data[at + 3]) << 24);
    };
    const bool extended = (frame.flags & CanFrame::kExtended) != 0;
    const bool remote = (frame.flags & CanFrame::kRemote) != 0;
    cortex_m0::write_word(base + 4, frame.dlc & 0xFU);
    cortex_m0::write_word(base + 8, word(0));
    cortex_m0::write_word(base + 12, word(4));
    cortex_m0::write_word(base, (extended ? (frame.id << 3) | 4U : frame.id << 21) | (remote ? 2U : 0U) | 1U);
  }

  void take() {
    if ((bxcan::Receive::read() & (1U << 4)) != 0) {  // the FIFO of three has run over
      lost_ = lost_ + 1;
      bxcan::Receive::write(1U << 4);
    }
    const std::uint32_t id = bxcan::ReceivedId::read();
    const std::uint32_t length = bxcan::ReceivedLength::read() & 0xFU;
    const std::uint32_t words[2] = {bxcan::ReceivedLow::read(), bxcan::ReceivedHigh::read()};
    bxcan::Receive::write(1U << 5);
    CanFrame frame;
    const bool extended = (id & 4U) != 0, remote = (id & 2U) != 0;
    frame.id = extended ? id >> 3 : id >> 21;
    if ((remote && !filter_.all) || !filter_.wants(frame.id, extended)) return;
    frame.flags = static_cast<std::uint8_t>((extended ? CanFrame::kExtended : 0U) | (remote ? CanFrame::kRemote : 0U));
    frame.dlc = static_cast<std::uint8_t>(length > 8 ? 8 : length);
    if (!remote)
      for (std::size_t i = 0; i < frame.dlc; ++i) frame.data[i] = static_cast<std::uint8_t>(words[i / 4] >> (8 * (i % 4)));
    if (!received_.put(frame)) lost_ = lost_ + 1;
  }

  CanFilter filter_{};
  std::size_t waiting_count_ = 0;
  std::array<CanFrame, kCanTransmitMax> waiting_{};
  std::array<std::uint32_t, bxcan::kMailboxes> order_{};  // of what was handed to each mailbox last
  cortex_m0::Ring<CanFrame, kCanReceiveMax> received_{};
  volatile std::uint32_t lost_ = 0;
  bool restarting_ = false;  // recovering from bus-off
};

}  // namespace hoist::firmware::stm32f072
