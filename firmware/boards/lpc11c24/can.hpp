// The C_CAN controller of the LPC11C24 at 250 kbit/s (UM10398, chapter 16).
//
// Message objects 1 to 10 send, one for each class of identifiers (transmit_order.hpp). Objects 17 to 31 receive, as one chain that takes
// every frame; object 32 sends remote frames.
// Interface registers IF1 belong to the main loop, IF2 to the interrupt: neither needs a lock.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/can_frame.hpp"
#include "firmware/boards/cortex_m0/can_filter.hpp"
#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"
#include "firmware/boards/lpc11c24/transmit_order.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware::lpc11c24 {

namespace c_can {
inline constexpr std::uint32_t kBase = 0x40050000;
using Control = Register<kBase + 0x00>;
using Status = Register<kBase + 0x04>;
using Errors = Register<kBase + 0x08>;
using BitTiming = Register<kBase + 0x0C>;
using Interrupt = Register<kBase + 0x10>;
using PrescalerExtension = Register<kBase + 0x18>;
// Objects 1 to 16 and 17 to 32.
using TransmitRequest1 = Register<kBase + 0x100>;
using TransmitRequest2 = Register<kBase + 0x104>;
using NewData1 = Register<kBase + 0x120>;
using NewData2 = Register<kBase + 0x124>;
using ClockDivider = Register<kBase + 0x180>;

inline constexpr std::uint32_t kInit = 1U << 0, kInterrupts = 1U << 1, kChangeTiming = 1U << 6;
inline constexpr std::uint32_t kPassive = 1U << 5, kWarning = 1U << 6, kBusOff = 1U << 7;

// One of the two windows into the message memory.
template <std::uint32_t kOffset>
struct Window {
  using Request = Register<kBase + kOffset + 0x00>;
  using Command = Register<kBase + kOffset + 0x04>;
  using Mask1 = Register<kBase + kOffset + 0x08>;
  using Mask2 = Register<kBase + kOffset + 0x0C>;
  using Id1 = Register<kBase + kOffset + 0x10>;
  using Id2 = Register<kBase + kOffset + 0x14>;
  using Message = Register<kBase + kOffset + 0x18>;
  static constexpr std::uint32_t kData = kBase + kOffset + 0x1C;  // four registers of two bytes

  // Moves between window and object, a few clocks of the controller. False when it does not end: the controller has no clock.
  static bool move(std::uint32_t object) {
    constexpr std::uint32_t kLoopsMax = 100;
    Request::write(object);
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((Request::read() & 0x8000U) == 0) return true;
    return false;
  }
};
using Loop = Window<0x20>;
using Isr = Window<0x80>;

// Bits of Command.
inline constexpr std::uint32_t kWrite = 1U << 7, kMask = 1U << 6, kArbitration = 1U << 5, kControl = 1U << 4, kClearPending = 1U << 3,
                               kNewDataOrRequest = 1U << 2, kDataA = 1U << 1, kDataB = 1U << 0;
// Bits of Id2.
inline constexpr std::uint32_t kValid = 1U << 15, kExtended = 1U << 14, kTransmit = 1U << 13;
// Bits of Message.
inline constexpr std::uint32_t kLost = 1U << 14, kUseMask = 1U << 12, kTransmitInterrupt = 1U << 11, kReceiveInterrupt = 1U << 10,
                               kRequest = 1U << 8, kEndOfChain = 1U << 7;
inline constexpr std::uint32_t kMaskReserved = 1U << 13;  // of Mask2: reads and is written as one
}  // namespace c_can

// 48 MHz / 12 = 4 MHz, 16 quanta: 1 + 13 before the sample point (87.5 %), 2 after it, jump width 1.
inline constexpr std::uint32_t kBitTiming_250k = 0x1C0B;
inline constexpr std::uint32_t kCanObjects = 32;
inline constexpr std::size_t kCanTransmitMax = 16;  // frames waiting for their object; more are refused
inline constexpr std::size_t kCanReceiveMax = 16;   // frames waiting for the main loop: 3 ms of a full bus
inline constexpr std::uint32_t kReceivesPerInterrupt = 32;

using cortex_m0::CanFilter;

class Can {
 public:
  using CanFrame = contract::CanFrame;

  // Returns false when the controller does not work. Call once.
  [[nodiscard]] bool start(CanFilter filter) {
    filter_ = filter;
    syscon::AhbClocks::set(syscon::kCan);
    syscon::PeripheralReset::set(syscon::kCanRuns);
    if (!configure()) return false;
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

  // Main loop, often: hands over what waits to the objects that are free. False when the controller has lost its configuration.
  bool service() {
    const std::uint32_t control = c_can::Control::read();
    if ((control & c_can::kInterrupts) == 0) return false;
    if (waiting_count_ == 0 || (control & c_can::kInit) != 0) return true;
    std::uint32_t busy = transmitting();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < waiting_count_; ++i) {
      const std::uint32_t object = transmit_object(waiting_[i]);
      const std::uint32_t bit = 1U << (object - 1);
      if ((busy & bit) != 0) {
        waiting_[kept++] = waiting_[i];
        continue;
      }
      busy |= bit;
      hand_over(object, waiting_[i]);
    }
    waiting_count_ = kept;
    return true;
  }

  bool receive(CanFrame& frame) { return received_.take(frame); }
  [[nodiscard]] bool has_frame() const { return !received_.empty(); }
  // True when nothing waits or is being sent: a node that restarts itself waits for this, so that its answer still leaves.
  [[nodiscard]] bool all_sent() const { return waiting_count_ == 0 && transmitting() == 0; }

  // Takes back what has not left: it is too old by now.
  void drop_unsent() {
    waiting_count_ = 0;
    for (std::uint32_t object = 1; object <= kCanObjects; ++object) {
      if (object >= kReceiveFirst && object <= kReceiveLast) continue;
      c_can::Loop::Command::write(c_can::kWrite | c_can::kArbitration | c_can::kControl);
      c_can::Loop::Id1::write(0);
      c_can::Loop::Id2::write(0);
      c_can::Loop::Message::write(0);
      (void)c_can::Loop::move(object);
    }
  }

  [[nodiscard]] CanHealth health() const {
    const std::uint32_t status = c_can::Status::read();
    const std::uint32_t errors = c_can::Errors::read();
    CanHealth health;
    health.tx_errors = static_cast<std::uint8_t>(errors);
    health.rx_errors = static_cast<std::uint8_t>((errors >> 8) & 0x7FU);
    health.lost = lost_;
    if ((status & c_can::kBusOff) != 0)
      health.state = CanHealth::State::bus_off;
    else if ((status & c_can::kPassive) != 0)
      health.state = CanHealth::State::passive;
    else if ((status & c_can::kWarning) != 0)
      health.state = CanHealth::State::warning;
    return health;
  }

  // Starts recovery from bus-off. Older frames would be stale and are dropped.
  void restart() {
    if ((c_can::Status::read() & c_can::kBusOff) == 0) return;
    if ((c_can::Control::read() & c_can::kInit) == 0) return;  // already on its way
    waiting_count_ = 0;
    cortex_m0::NvicDisable::write(1U << irq::kCan);
    (void)configure();  // the controller answered before
    cortex_m0::NvicEnable::write(1U << irq::kCan);
  }

  // The interrupt. The chain is emptied from its first object to its last, and only then from the first again: objects that were freed
  // first are filled first, so frames keep their order.
  void on_interrupt() {
    for (std::uint32_t i = 0; i < kReceivesPerInterrupt; ++i) {
      const std::uint32_t cause = c_can::Interrupt::read();
      if (cause == 0) return;
      if (cause < kReceiveFirst || cause == kRemoteObject) {
        c_can::Isr::Command::write(c_can::kClearPending);
        (void)c_can::Isr::move(cause);
        continue;  // sending continues in service(): this interrupt only wakes the main loop
      }
      if (cause > kCanObjects) {
        (void)c_can::Status::read();
        continue;
      }
      // The register is read again for each frame: a new frame lies behind those still unread.
      for (std::uint32_t object = kReceiveFirst; object <= kReceiveLast; ++object) {
        std::uint32_t news = (c_can::NewData2::read() & kChainNews) >> (object - kReceiveFirst);
        if (news == 0) break;
        for (; (news & 1U) == 0; news >>= 1) ++object;
        take(object);
      }
    }
  }

 private:
  // The chain's bits of NewData2.
  static constexpr std::uint32_t kChainNews = (1U << (kReceiveLast - kReceiveFirst + 1)) - 1U;
  static_assert(kReceiveFirst == 17);

  // Objects that wait for the bus, bit 0 for object 1.
  static std::uint32_t transmitting() { return c_can::TransmitRequest1::read() | (c_can::TransmitRequest2::read() << 16); }

  [[nodiscard]] static bool configure() {
    c_can::Control::write(c_can::kInit | c_can::kChangeTiming);
    c_can::ClockDivider::write(0);
    c_can::BitTiming::write(kBitTiming_250k);
    c_can::PrescalerExtension::write(0);
    // The message memory holds anything after power-on.
    for (std::uint32_t object = 1; object <= kCanObjects; ++object) {
      const bool receives = object >= kReceiveFirst && object <= kReceiveLast;
      c_can::Loop::Command::write(c_can::kWrite | c_can::kMask | c_can::kArbitration | c_can::kControl | c_can::kDataA | c_can::kDataB);
      c_can::Loop::Mask1::write(0);
      // Neither the identifier nor its length decides: receive objects take every data frame.
      c_can::Loop::Mask2::write(c_can::kMaskReserved);
      c_can::Loop::Id1::write(0);
      c_can::Loop::Id2::write(receives ? c_can::kValid : 0U);
      c_can::Loop::Message::write(receives ? c_can::kUseMask | c_can::kReceiveInterrupt | (object == kReceiveLast ? c_can::kEndOfChain : 0U)
                                           : 0U);
      for (std::uint32_t i = 0; i < 4; ++i) cortex_m0::write_word(c_can::Loop::kData + 4 * i, 0);
      if (!c_can::Loop::move(object)) return false;
    }
    (void)c_can::Status::read();
    c_can::Control::write(c_can::kInterrupts);
    return true;
  }

  static void hand_over(std::uint32_t object, const CanFrame& frame) {
    using c_can::Loop;
    const bool extended = (frame.flags & CanFrame::kExtended) != 0;
    const bool remote = (frame.flags & CanFrame::kRemote) != 0;
    const std::uint32_t id = extended ? frame.id : frame.id << 18;
    Loop::Command::write(c_can::kWrite | c_can::kMask | c_can::kArbitration | c_can::kControl | c_can::kDataA | c_can::kDataB);
    Loop::Mask1::write(0xFFFF);
    Loop::Mask2::write(0xFFFF);
    Loop::Id1::write(id & 0xFFFFU);
    // A receive object that is told to transmit sends a remote frame.
    Loop::Id2::write((id >> 16) | c_can::kValid | (extended ? c_can::kExtended : 0U) | (remote ? 0U : c_can::kTransmit));
    for (std::uint32_t i = 0; i < 4; ++i)
      cortex_m0::write_word(Loop::kData + 4 * i,
                            static_cast<std::uint32_t>(frame.data[2 * i]) | (static_cast<std::uint32_t>(frame.data[2 * i + 1]) << 8));
    Loop::Message::write((frame.dlc & 0xFU) | c_can::kEndOfChain | c_can::kRequest | c_can::kTransmitInterrupt);
    (void)Loop::move(object);
  }

  void take(std::uint32_t object) {
    using c_can::Isr;
    Isr::Command::write(c_can::kArbitration | c_can::kControl | c_can::kClearPending | c_can::kNewDataOrRequest | c_can::kDataA |
                        c_can::kDataB);
    if (!Isr::move(object)) return;
    const std::uint32_t message = Isr::Message::read();
    const std::uint32_t id2 = Isr::Id2::read();
    if ((message & c_can::kLost) != 0) {
      lost_ = lost_ + 1;
      Isr::Command::write(c_can::kWrite | c_can::kControl);
      Isr::Message::write(c_can::kUseMask | c_can::kReceiveInterrupt | (object == kReceiveLast ? c_can::kEndOfChain : 0U));
      (void)Isr::move(object);
    }
    CanFrame frame;
    const bool extended = (id2 & c_can::kExtended) != 0;
    const std::uint32_t id = ((id2 & 0x1FFFU) << 16) | Isr::Id1::read();
    frame.id = extended ? id : id >> 18;
    if (!filter_.wants(frame.id, extended)) return;
    frame.flags = extended ? CanFrame::kExtended : std::uint8_t{0};
    const std::uint32_t dlc = message & 0xFU;
    frame.dlc = static_cast<std::uint8_t>(dlc > 8 ? 8 : dlc);
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t pair = cortex_m0::read_word(Isr::kData + 4 * i);
      if (2 * i < frame.dlc) frame.data[2 * i] = static_cast<std::uint8_t>(pair);
      if (2 * i + 1 < frame.dlc) frame.data[2 * i + 1] = static_cast<std::uint8_t>(pair >> 8);
    }
    if (!received_.put(frame)) lost_ = lost_ + 1;
  }

  CanFilter filter_{};
  std::size_t waiting_count_ = 0;
  std::array<CanFrame, kCanTransmitMax> waiting_{};
  cortex_m0::Ring<CanFrame, kCanReceiveMax> received_{};
  volatile std::uint32_t lost_ = 0;
};

}  // namespace hoist::firmware::lpc11c24
