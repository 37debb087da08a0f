#include "tests/machine/bx_can.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

namespace hoist::machine {
namespace {

using contract::CanFrame;

// MCR
constexpr std::uint32_t kInrq = 1, kSleep = 2, kPriorityByOrder = 4, kFifoLock = 8, kNoRetransmission = 0x10, kAutoWake = 0x20,
                        kAbom = 0x40, kTimeTriggered = 0x80, kMasterReset = 0x8000, kDebugFreeze = 0x10000;
// MSR
constexpr std::uint32_t kInak = 1, kSlak = 2, kErrorInterrupt = 4, kWakeInterrupt = 8, kSleepInterrupt = 0x10, kReceivePin = 0x800,
                        kLastSample = 0x400;
// TSR, for each mailbox at 8 bits' distance
constexpr std::uint32_t kRequestDone = 1, kSentWell = 2, kErrorSending = 8, kAbort = 0x80;
// RFR
constexpr std::uint32_t kFull = 8, kOverrun = 0x10, kRelease = 0x20;
// IER
constexpr std::uint32_t kTmeIe = 1, kFmpIe = 2, kFullIe = 4, kOverrunIe = 8, kEwgIe = 0x100, kEpvIe = 0x200, kBofIe = 0x400,
                        kErrIe = 0x8000, kInterruptsKnown = 0x38F7F, kInterruptsModelled = 0x877F;
// ESR
constexpr std::uint32_t kEwgf = 1, kEpvf = 2, kBoff = 4;
// BTR
constexpr std::uint32_t kTimingKnown = 0xC37F03FF, kTestModes = 0xC0000000;

constexpr std::uint32_t kBusRate_hz = 250'000;
constexpr std::uint32_t kFilterControlReserved = 0x2A1C0E00;  // FMR after a reset, without FINIT

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

// The identifier as the mailboxes hold it, without the request bit.
std::uint32_t id_word_of(const CanFrame& frame) {
  const bool extended = (frame.flags & CanFrame::kExtended) != 0;
  return (extended ? (frame.id << 3) | 4U : frame.id << 21) | ((frame.flags & CanFrame::kRemote) != 0 ? 2U : 0U);
}
// The order in which identifiers win: the bits of the arbitration field.
std::uint32_t priority_of(std::uint32_t id_word) {
  const std::uint32_t remote = (id_word >> 1) & 1U;
  if ((id_word & 4U) == 0) return ((id_word >> 21) << 21) | (remote << 20);
  return ((id_word >> 21) << 21) | (3U << 19) | (((id_word >> 3) & 0x3FFFFU) << 1) | remote;
}

}  // namespace

void BxCan::reset() {
  mode_ = Mode::sleep;
  control_ = kSleep | kDebugFreeze;
  status_ = done_ = interrupts_ = last_error_ = 0;
  timing_ = 0x01230000;
  boxes_ = {};
  fifos_ = {};
  filter_init_ = true;
  filter_mode_ = filter_scale_ = filter_fifo_ = filter_active_ = 0;
  banks_ = {};
  sending_ = -1;
  rate_good_ = false;
  tec_ = rec_ = 0;
  bus_off_ = false;
  integrated_bits_ = recovery_bits_ = 0;
  ++changes_;
}

bool BxCan::line() const {
  if ((interrupts_ & kTmeIe) != 0 && (done_ & 0x010101U) != 0) return true;
  for (unsigned i = 0; i < kFifos; ++i) {
    const std::uint32_t enabled = interrupts_ >> (3 * i);
    if ((enabled & kFmpIe) != 0 && fifos_[i].count > 0) return true;
    if ((enabled & kFullIe) != 0 && fifos_[i].full) return true;
    if ((enabled & kOverrunIe) != 0 && fifos_[i].overrun) return true;
  }
  return (interrupts_ & kErrIe) != 0 && (status_ & kErrorInterrupt) != 0;
}

// ---------------------------------------------------------------- registers

unsigned BxCan::weakest() const {
  unsigned at = 0;
  std::uint32_t worst = 0;
  for (unsigned box = 0; box < kMailboxes; ++box) {
    const std::uint32_t priority = priority_of(boxes_[box].message.id);
    if (!pending(box) || priority < worst) continue;
    worst = priority;
    at = box;
  }
  return at;
}

std::uint32_t BxCan::transmit_status() const {
  std::uint32_t value = done_;
  unsigned waiting = 0, free = kMailboxes;
  for (unsigned box = kMailboxes; box-- > 0;) {
    if (boxes_[box].abort) value |= kAbort << (8 * box);
    if (pending(box)) {
      ++waiting;
    } else {
      value |= 1U << (26 + box);
      free = box;
    }
  }
  value |= (free < kMailboxes ? free : weakest()) << 24;
  if (waiting > 1) value |= 1U << (29 + weakest());
  return value;
}

std::uint32_t BxCan::read_fifo(unsigned number, unsigned word, std::uint64_t cycles) {
  const Fifo& fifo = fifos_[number];
  if (fifo.count == 0) complain_("bxCAN: empty FIFO " + std::to_string(number) + " read");
  if (cycles < fifo.released_at) complain_("bxCAN: FIFO " + std::to_string(number) + " read while it is being released");
  const Message& message = fifo.messages[0];
  const std::array<std::uint32_t, 4> words{message.id, message.length, message.low, message.high};
  return words[word];
}

std::uint32_t BxCan::read_filter(std::uint32_t offset) const {
  switch (offset) {
    case 0x200:
      return kFilterControlReserved | (filter_init_ ? 1U : 0U);
    case 0x204:
      return filter_mode_;
    case 0x20C:
      return filter_scale_;
    case 0x214:
      return filter_fifo_;
    case 0x21C:
      return filter_active_;
    default:
      break;
  }
  if (offset >= 0x240 && offset < 0x240 + 8 * kBanks) return banks_[(offset - 0x240) / 8][(offset >> 2) & 1U];
  complain_("bxCAN: read of register " + hex(offset) + ", which does not exist");
  return 0;
}

std::uint32_t BxCan::read(std::uint32_t offset, std::uint64_t cycles) {
  switch (offset) {
    case 0x000:
      return control_;
    case 0x004:
      return status_ | (mode_ == Mode::initialisation ? kInak : 0U) | (mode_ == Mode::sleep ? kSlak : 0U) | kReceivePin | kLastSample;
    case 0x008:
      return transmit_status();
    case 0x00C:
    case 0x010: {
      const Fifo& fifo = fifos_[offset == 0x010 ? 1 : 0];
      return fifo.count | (fifo.full ? kFull : 0U) | (fifo.overrun ? kOverrun : 0U) | (cycles < fifo.released_at ? kRelease : 0U);
    }
    case 0x014:
      return interrupts_;
    case 0x018:
      return (std::min(rec_, 255U) << 24) | (std::min(tec_, 255U) << 16) | (last_error_ << 4) | (bus_off_ ? kBoff : 0U) |
             (tec_ > 127 || rec_ > 127 ? kEpvf : 0U) | (tec_ >= 96 || rec_ >= 96 ? kEwgf : 0U);
    case 0x01C:
      return timing_;
    default:
      break;
  }
  if (offset >= 0x180 && offset < 0x1B0) {
    const Message& message = boxes_[(offset - 0x180) / 16].message;
    const std::array<std::uint32_t, 4> words{message.id, message.length, message.low, message.high};
    return words[(offset >> 2) & 3U];
  }
  if (offset >= 0x1B0 && offset < 0x1D0) return read_fifo((offset - 0x1B0) / 16, (offset >> 2) & 3U, cycles);
  return read_filter(offset);
}

// INRQ and SLEEP request, INAK and SLAK acknowledge: initialisation begins when no own frame is being sent, normal mode takes part in the
// bus after eleven recessive bits (idle()).
void BxCan::settle_mode() {
  const Mode before = mode_;
  if ((control_ & kInrq) != 0) {
    if (sending_ < 0) mode_ = Mode::initialisation;
  } else if ((control_ & kSleep) != 0) {
    if (sending_ < 0) mode_ = Mode::sleep;
  } else if (before == Mode::initialisation) {
    if (integrated_bits_ >= kIntegrationBits) mode_ = Mode::normal;
  } else {
    mode_ = Mode::normal;
  }
  if (mode_ != before) ++changes_;
  if (mode_ != Mode::normal && before == Mode::normal) integrated_bits_ = 0;
}

void BxCan::write_control(std::uint32_t value, std::uint32_t clock_hz) {
  if ((value & ~(kInrq | kSleep | kPriorityByOrder | kFifoLock | kNoRetransmission | kAutoWake | kAbom | kTimeTriggered | kMasterReset |
                 kDebugFreeze)) != 0)
    complain_("bxCAN: reserved bits of MCR");
  if ((value & (kFifoLock | kNoRetransmission | kTimeTriggered)) != 0)
    complain_("bxCAN: FIFO lock, single shot or time-triggered mode: not modelled");
  if ((value & kMasterReset) != 0) {
    reset();
    return;
  }
  const bool leaves = (control_ & kInrq) != 0 && (value & kInrq) == 0;
  if (leaves && mode_ != Mode::initialisation) complain_("bxCAN: INRQ taken back before INAK");
  if ((value & kInrq) == 0 && (control_ & kInrq) == 0 && mode_ == Mode::sleep && (value & kSleep) == 0)
    complain_("bxCAN: woken from sleep without having been initialised");
  control_ = value;
  if (leaves) {
    integrated_bits_ = 0;
    const std::uint32_t quanta = 3 + ((timing_ >> 16) & 0xFU) + ((timing_ >> 20) & 7U);
    const std::uint64_t bit_clocks = static_cast<std::uint64_t>((timing_ & 0x3FFU) + 1) * quanta;
    rate_good_ = bit_clocks * kBusRate_hz == clock_hz;
    if (!rate_good_)
      complain_("bxCAN: a bit of " + std::to_string(bit_clocks) + " clocks at " + std::to_string(clock_hz) + " Hz is not 4 us");
    const double sample = static_cast<double>(2 + ((timing_ >> 16) & 0xFU)) / quanta;
    if (sample < 0.75 || sample > 0.9)
      complain_("bxCAN: sample point at " + std::to_string(100.0 * sample) + " %, CiA 301 asks for 87.5 %");
    if (bus_off_) recovery_bits_ = kRecoveryBits;
  }
  settle_mode();
}

void BxCan::finish(unsigned box, bool good, bool error) {
  boxes_[box].message.id &= ~1U;
  boxes_[box].abort = false;
  done_ &= ~(0xFU << (8 * box));
  done_ |= (kRequestDone | (good ? kSentWell : 0U) | (error ? kErrorSending : 0U)) << (8 * box);
  ++changes_;
}

void BxCan::write_transmit(std::uint32_t value) {
  if ((value & 0x00707070U) != 0) complain_("bxCAN: reserved bits of TSR");
  for (unsigned box = 0; box < kMailboxes; ++box) {
    const std::uint32_t bits = value >> (8 * box);
    // Clearing RQCP clears the result too; each flag can also be cleared alone.
    if ((bits & kRequestDone) != 0) done_ &= ~(0xFU << (8 * box));
    done_ &= ~((bits & 0xEU) << (8 * box));
    if ((bits & kAbort) == 0 || !pending(box)) continue;
    if (sending_ == static_cast<int>(box))
      boxes_[box].abort = true;  // once it is on the wire the abort waits for the outcome
    else
      finish(box, false, false);
  }
}

void BxCan::write_receive(unsigned number, std::uint32_t value, std::uint64_t cycles) {
  if ((value & ~(kFull | kOverrun | kRelease)) != 0) complain_("bxCAN: reserved or read-only bits of RFR");
  Fifo& fifo = fifos_[number];
  if ((value & kFull) != 0) fifo.full = false;
  if ((value & kOverrun) != 0) fifo.overrun = false;
  if ((value & kRelease) == 0) return;
  if (cycles < fifo.released_at) complain_("bxCAN: FIFO released again before it has been released");
  if (fifo.count == 0) {
    complain_("bxCAN: empty FIFO released");
    return;
  }
  std::rotate(fifo.messages.begin(), fifo.messages.begin() + 1, fifo.messages.end());
  --fifo.count;
  fifo.full = false;
  fifo.released_at = cycles + kReleaseCycles;
}

void BxCan::write_mailbox(unsigned box, unsigned word, std::uint32_t value) {
  if (pending(box)) {
    complain_("bxCAN: mailbox " + std::to_string(box) + " written while it is pending");
    return;
  }
  Message& message = boxes_[box].message;
  switch (word) {
    case 0:
      if ((value & 1U) != 0) {
        if (mode_ == Mode::sleep) complain_("bxCAN: transmission asked for in sleep mode");
        if ((message.length & 0xFU) > 8) complain_("bxCAN: frame of more than eight bytes");
        if ((value & 4U) == 0 && (value & 0x1FFFF8U) != 0) complain_("bxCAN: a standard identifier with bits of an extended one");
        done_ &= ~(0xFU << (8 * box));
        ++changes_;
      }
      message.id = value;
      return;
    case 1:
      if ((value & ~0xFFFF010FU) != 0) complain_("bxCAN: reserved bits of TDTR");
      if ((value & 0x100U) != 0) complain_("bxCAN: time stamp asked for outside time-triggered mode");
      message.length = value & 0xFU;
      return;
    case 2:
      message.low = value;
      return;
    default:
      message.high = value;
  }
}

void BxCan::write_filter(std::uint32_t offset, std::uint32_t value) {
  constexpr std::uint32_t kAll = (1U << kBanks) - 1;
  if (offset == 0x200) {
    if ((value & ~1U) != kFilterControlReserved) complain_("bxCAN: reserved bits of FMR not written back as read");
    filter_init_ = (value & 1U) != 0;
    return;
  }
  if (offset >= 0x204 && offset <= 0x21C) {
    if ((value & ~kAll) != 0) complain_("bxCAN: filter bank that does not exist, register " + hex(offset));
    if (!filter_init_ && offset != 0x21C) complain_("bxCAN: register " + hex(offset) + " written without FINIT");
  }
  switch (offset) {
    case 0x204:
      filter_mode_ = value & kAll;
      return;
    case 0x20C:
      filter_scale_ = value & kAll;
      return;
    case 0x214:
      filter_fifo_ = value & kAll;
      return;
    case 0x21C:
      filter_active_ = value & kAll;
      return;
    default:
      break;
  }
  if (offset < 0x240 || offset >= 0x240 + 8 * kBanks) {
    complain_("bxCAN: write to register " + hex(offset) + ", which is read-only or does not exist");
    return;
  }
  const unsigned bank = (offset - 0x240) / 8;
  if (!filter_init_ && (filter_active_ & (1U << bank)) != 0) complain_("bxCAN: an active filter bank written without FINIT");
  banks_[bank][(offset >> 2) & 1U] = value;
}

void BxCan::write(std::uint32_t offset, std::uint32_t value, std::uint64_t cycles, std::uint32_t clock_hz) {
  ++changes_;
  switch (offset) {
    case 0x000:
      write_control(value, clock_hz);
      return;
    case 0x004:
      status_ &= ~(value & (kErrorInterrupt | kWakeInterrupt | kSleepInterrupt));
      return;
    case 0x008:
      write_transmit(value);
      return;
    case 0x00C:
    case 0x010:
      write_receive(offset == 0x010 ? 1 : 0, value, cycles);
      return;
    case 0x014:
      if ((value & ~kInterruptsKnown) != 0) complain_("bxCAN: reserved bits of IER");
      if ((value & ~kInterruptsModelled) != 0) complain_("bxCAN: interrupts of sleep mode and of the last error code: not modelled");
      interrupts_ = value;
      return;
    case 0x018:
      if ((value & ~0x70U) != 0) complain_("bxCAN: read-only bits of ESR written");
      last_error_ = (value >> 4) & 7U;
      return;
    case 0x01C:
      if (mode_ != Mode::initialisation) {
        complain_("bxCAN: BTR written outside initialisation mode");
        return;
      }
      if ((value & ~kTimingKnown) != 0) complain_("bxCAN: reserved bits of BTR");
      if ((value & kTestModes) != 0) complain_("bxCAN: loop-back or silent mode: not modelled");
      timing_ = value;
      return;
    default:
      break;
  }
  if (offset >= 0x180 && offset < 0x1B0) {
    write_mailbox((offset - 0x180) / 16, (offset >> 2) & 3U, value);
    return;
  }
  write_filter(offset, value);
}

// ---------------------------------------------------------------- the wire's side

bool BxCan::offer(CanFrame& frame) {
  offered_ = -1;
  unsigned chosen = kMailboxes;
  for (unsigned box = 0; box < kMailboxes; ++box) {
    if (!pending(box)) continue;
    if (chosen == kMailboxes || priority_of(boxes_[box].message.id) < priority_of(boxes_[chosen].message.id)) chosen = box;
  }
  if (chosen == kMailboxes) return false;
  if ((control_ & kPriorityByOrder) != 0) complain_("bxCAN: TXFP, mailboxes by the order of their requests: not modelled");
  const Message& message = boxes_[chosen].message;
  const bool extended = (message.id & 4U) != 0, remote = (message.id & 2U) != 0;
  frame = {};
  frame.id = extended ? message.id >> 3 : message.id >> 21;
  frame.flags = static_cast<std::uint8_t>((extended ? CanFrame::kExtended : 0) | (remote ? CanFrame::kRemote : 0));
  frame.dlc = static_cast<std::uint8_t>(std::min(message.length & 0xFU, 8U));
  if (!remote)
    for (unsigned i = 0; i < frame.dlc; ++i)
      frame.data[i] = static_cast<std::uint8_t>((i < 4 ? message.low : message.high) >> (8 * (i % 4)));
  offered_ = static_cast<int>(chosen);
  return true;
}

void BxCan::sent(CanError error) {
  const int number = sending_;
  sending_ = -1;
  if (number < 0) return;
  const auto box = static_cast<unsigned>(number);
  last_error_ = static_cast<std::uint32_t>(error);
  count_sent(error);
  if (error == CanError::none) {
    finish(box, true, false);
  } else {
    done_ |= kErrorSending << (8 * box);
    if (boxes_[box].abort) finish(box, false, true);
  }
  update_states();
  settle_mode();
}

// RM0091, section "Identifier filtering": 32 bit: STDID, EXID, IDE, RTR as in the mailbox; 16 bit: STDID, RTR, IDE, EXID 17 to 15.
int BxCan::filtered(std::uint32_t id_word) const {
  const std::uint32_t narrow =
      ((id_word >> 21) << 5) | (((id_word >> 1) & 1U) << 4) | (((id_word >> 2) & 1U) << 3) | ((id_word >> 18) & 7U);
  for (unsigned bank = 0; bank < kBanks; ++bank) {
    if ((filter_active_ & (1U << bank)) == 0) continue;
    const bool list = (filter_mode_ & (1U << bank)) != 0;
    const auto& [first, second] = banks_[bank];
    bool good = false;
    if ((filter_scale_ & (1U << bank)) != 0) {
      good = list ? (id_word & ~1U) == (first & ~1U) || (id_word & ~1U) == (second & ~1U) : ((id_word ^ first) & second & ~1U) == 0;
    } else {
      for (const std::uint32_t word : {first, second})
        good |= list ? narrow == (word & 0xFFFFU) || narrow == (word >> 16) : ((narrow ^ (word & 0xFFFFU)) & (word >> 16)) == 0;
    }
    if (good) return (filter_fifo_ & (1U << bank)) != 0 ? 1 : 0;
  }
  return -1;
}

void BxCan::heard(const CanFrame& frame, CanError error) {
  last_error_ = static_cast<std::uint32_t>(error);
  count_heard(error);
  update_states();
  if (error != CanError::none || filter_init_) return;  // FINIT switches reception off
  const int number = filtered(id_word_of(frame));
  if (number < 0) return;
  Fifo& fifo = fifos_[static_cast<unsigned>(number)];
  Message message;
  message.id = id_word_of(frame);
  // Time stamp and filter number stand above the length; bytes that the frame does not have hold something unspecified.
  message.length = frame.dlc | 0xA5A50000U;
  message.low = message.high = 0xA5A5A5A5;
  if ((frame.flags & CanFrame::kRemote) == 0)
    for (unsigned i = 0; i < frame.dlc; ++i) {
      std::uint32_t& word = i < 4 ? message.low : message.high;
      const unsigned shift = 8 * (i % 4);
      word = (word & ~(0xFFU << shift)) | (static_cast<std::uint32_t>(frame.data[i]) << shift);
    }
  if (fifo.count == kFifoDepth) {  // without RFLM the newest of the three is overwritten
    fifo.overrun = true;
    ++lost_;
    fifo.messages[kFifoDepth - 1] = message;
  } else {
    fifo.messages[fifo.count++] = message;
    fifo.full = fifo.count == kFifoDepth;
  }
  ++changes_;
}

void BxCan::update_states() {
  ++changes_;
  if (tec_ > 255 && !bus_off_) {
    bus_off_ = true;
    sending_ = -1;
    // With ABOM the controller recovers by itself, without it the program must use initialisation mode.
    if ((control_ & kAbom) != 0) recovery_bits_ = kRecoveryBits;
  }
  const bool told = ((interrupts_ & kBofIe) != 0 && bus_off_) || ((interrupts_ & kEpvIe) != 0 && (tec_ > 127 || rec_ > 127)) ||
                    ((interrupts_ & kEwgIe) != 0 && (tec_ >= 96 || rec_ >= 96));
  if (told) status_ |= kErrorInterrupt;
}

void BxCan::idle(std::uint64_t bits) {
  if ((control_ & kInrq) != 0 || mode_ == Mode::sleep) return;  // the receive pin is not watched
  integrated_bits_ = std::min(integrated_bits_ + bits, kIntegrationBits);
  settle_mode();
  if (recovery_bits_ == 0 || mode_ != Mode::normal) return;
  recovery_bits_ -= std::min(recovery_bits_, bits);
  if (recovery_bits_ == 0) {
    bus_off_ = false;
    tec_ = rec_ = 0;
    update_states();
  }
}

}  // namespace hoist::machine
