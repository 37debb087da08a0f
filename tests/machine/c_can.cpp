#include "tests/machine/c_can.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <string>

namespace hoist::machine {
namespace {

using contract::CanFrame;

// CNTL
constexpr std::uint32_t kInit = 1, kIe = 2, kSie = 4, kEie = 8, kDar = 0x20, kCce = 0x40, kTest = 0x80;
// STAT
constexpr std::uint32_t kLec = 7, kTxOk = 8, kRxOk = 0x10, kEPass = 0x20, kEWarn = 0x40, kBOff = 0x80;
// Command mask
constexpr std::uint32_t kDataB = 1, kDataA = 2, kTransmitOrNew = 4, kClearPending = 8, kControl = 0x10, kArbitration = 0x20, kMask = 0x40,
                        kWrite = 0x80;
// Message control
constexpr std::uint32_t kNewData = 0x8000, kMessageLost = 0x4000, kPending = 0x2000, kUseMask = 0x1000, kTxIe = 0x800, kRxIe = 0x400,
                        kRemoteEnable = 0x200, kRequest = 0x100, kEndOfBuffer = 0x80;
// Arbitration 2
constexpr std::uint32_t kValid = 0x8000, kExtended = 0x4000, kTransmit = 0x2000;

constexpr std::uint32_t kBusRate_hz = 250'000;

std::string hex(std::uint32_t value) {
  std::array<char, 12> text{};
  std::snprintf(text.data(), text.size(), "%X", value);
  return text.data();
}

}  // namespace

void CCan::reset() {
  control_ = kInit;
  status_ = 0;
  timing_ = 0x2301;
  prescaler_ = 0;
  clock_divider_ = 1;  // UM10398: the divider's reset value
  objects_ = {};       // undefined on silicon except the valid bits; the manual demands that the program sets them all
  interfaces_ = {};
  look();
  sending_ = -1;
  tec_ = rec_ = 0;
  bus_off_ = status_pending_ = false;
  rate_good_ = false;
  integrated_bits_ = recovery_bits_ = 0;
}

std::uint32_t CCan::interrupt_id() const {
  if (status_pending_ && (control_ & (kSie | kEie)) != 0) return 0x8000;
  return pending_ == 0 ? 0 : static_cast<std::uint32_t>(std::countr_zero(pending_)) + 1;
}

void CCan::look() {
  wants_ = pending_ = 0;
  for (unsigned i = 0; i < kObjects; ++i) {
    const Object& object = objects_[i];
    if ((object.control & kPending) != 0) pending_ |= 1U << i;
    if ((object.arb2 & kValid) != 0 && (object.control & kRequest) != 0) wants_ |= 1U << i;
  }
  ++changes_;
}

std::uint32_t CCan::gather(std::uint32_t bit, unsigned half) const {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 16; ++i)
    if ((objects_[half * 16 + i].control & bit) != 0) value |= 1U << i;
  return value;
}

std::uint32_t CCan::read(std::uint32_t offset, std::uint64_t cycles) {
  if ((offset >= 0x20 && offset <= 0x48) || (offset >= 0x80 && offset <= 0xA8)) {
    const Interface& at = interfaces_[offset >= 0x80 ? 1 : 0];
    const bool busy = cycles < at.busy_until;
    const std::uint32_t reg = offset >= 0x80 ? offset - 0x80 + 0x20 : offset;
    if (busy && reg != 0x20) complain_("C_CAN: interface register read while busy");
    switch (reg) {
      case 0x20:
        return at.request | (busy ? 0x8000U : 0U);
      case 0x24:
        return at.command_mask;
      case 0x28:
        return at.mask1;
      case 0x2C:
        return at.mask2 | 0x2000U;
      case 0x30:
        return at.arb1;
      case 0x34:
        return at.arb2;
      case 0x38:
        return at.control;
      case 0x3C:
      case 0x40:
      case 0x44:
      case 0x48:
        return at.data[(reg - 0x3C) / 4];
      default:
        break;
    }
  }
  switch (offset) {
    case 0x00:
      return control_;
    case 0x04:
      status_pending_ = false;
      return status_;
    case 0x08:
      return (tec_ > 255 ? 255U : tec_) | (std::min(rec_, 127U) << 8) | (rec_ >= 128 ? 0x8000U : 0U);
    case 0x0C:
      return timing_;
    case 0x10:
      return interrupt_id();
    case 0x14:
      return 0x80;  // the receive pin is recessive
    case 0x18:
      return prescaler_;
    case 0x100:
    case 0x104:
      return gather(kRequest, (offset >> 2) & 1U);
    case 0x120:
    case 0x124:
      return gather(kNewData, (offset >> 2) & 1U);
    case 0x140:
    case 0x144:
      return gather(kPending, (offset >> 2) & 1U);
    case 0x160:
    case 0x164: {
      std::uint32_t value = 0;
      for (unsigned i = 0; i < 16; ++i)
        if ((objects_[((offset >> 2) & 1U) * 16 + i].arb2 & kValid) != 0) value |= 1U << i;
      return value;
    }
    case 0x180:
      return clock_divider_;
    default:
      complain_("C_CAN: read of register " + hex(offset) + ", which does not exist");
      return 0;
  }
}

void CCan::write(std::uint32_t offset, std::uint32_t value, std::uint64_t cycles, std::uint32_t clock_hz) {
  if (value > 0xFFFF) complain_("C_CAN: reserved upper half of register " + hex(offset) + " written");
  value &= 0xFFFF;
  if ((offset >= 0x20 && offset <= 0x48) || (offset >= 0x80 && offset <= 0xA8)) {
    Interface& at = interfaces_[offset >= 0x80 ? 1 : 0];
    const std::uint32_t reg = offset >= 0x80 ? offset - 0x80 + 0x20 : offset;
    if (cycles < at.busy_until) complain_("C_CAN: interface register " + hex(offset) + " written while busy");
    switch (reg) {
      case 0x20:
        at.request = value & 0x3FU;
        transfer(at, value & 0x3FU);
        look();
        at.busy_until = cycles + kBusyCycles * (clock_divider_ + 1);
        return;
      case 0x24:
        if ((value & 0xFF00U) != 0) complain_("C_CAN: reserved bits of the command mask");
        at.command_mask = value & 0xFFU;
        return;
      case 0x28:
        at.mask1 = value;
        return;
      case 0x2C:
        at.mask2 = value;
        return;
      case 0x30:
        at.arb1 = value;
        return;
      case 0x34:
        at.arb2 = value;
        return;
      case 0x38:
        if ((value & 0x70U) != 0) complain_("C_CAN: reserved bits of the message control");
        at.control = value;
        return;
      case 0x3C:
      case 0x40:
      case 0x44:
      case 0x48:
        at.data[(reg - 0x3C) / 4] = static_cast<std::uint16_t>(value);
        return;
      default:
        break;
    }
  }
  switch (offset) {
    case 0x00: {
      if ((value & 0xFF10U) != 0) complain_("C_CAN: reserved bits of CNTL");
      if ((value & kTest) != 0) complain_("C_CAN: test mode: not modelled");
      if ((value & kDar) != 0) complain_("C_CAN: retransmission switched off: not modelled");
      if ((value & kCce) != 0 && (value & kInit) == 0) complain_("C_CAN: CCE without INIT");
      const bool starts = (control_ & kInit) != 0 && (value & kInit) == 0;
      const bool stops = (control_ & kInit) == 0 && (value & kInit) != 0;
      control_ = value & 0xEFU;
      if (stops) sending_ = -1;
      if (starts) {
        const std::uint32_t tq = ((timing_ & 0x3FU) | ((prescaler_ & 0xFU) << 6)) + 1;
        const std::uint32_t bit = 1 + ((timing_ >> 8) & 0xFU) + 1 + ((timing_ >> 12) & 7U) + 1;
        const std::uint32_t per_bit = tq * bit * (clock_divider_ + 1);
        rate_good_ = clock_hz / kBusRate_hz * kBusRate_hz == clock_hz && clock_hz / kBusRate_hz == per_bit;
        if (!rate_good_)
          complain_("C_CAN: one bit is " + std::to_string(per_bit) + " clocks of " + std::to_string(clock_hz) + " Hz, not 4 us");
        integrated_bits_ = 0;
        if (bus_off_) recovery_bits_ = kRecoveryBits;
      }
      return;
    }
    case 0x04:
      // Only LEC, TXOK and RXOK can be written, the latter two only to 0.
      status_ = (status_ & (kEPass | kEWarn | kBOff)) | (value & kLec) | (status_ & value & (kTxOk | kRxOk));
      return;
    case 0x0C:
      if ((control_ & (kInit | kCce)) != (kInit | kCce)) {
        complain_("C_CAN: BT written without INIT and CCE");
        return;
      }
      timing_ = value & 0x7FFFU;
      return;
    case 0x18:
      if ((control_ & (kInit | kCce)) != (kInit | kCce)) {
        complain_("C_CAN: BRPE written without INIT and CCE");
        return;
      }
      prescaler_ = value & 0xFU;
      return;
    case 0x14:
      complain_("C_CAN: TEST written: not modelled");
      return;
    case 0x180:
      if ((control_ & kInit) == 0) complain_("C_CAN: clock divider changed on the bus");
      clock_divider_ = value & 0xFU;
      return;
    default:
      complain_("C_CAN: write to register " + hex(offset) + ", which is read-only or does not exist");
  }
}

void CCan::transfer(Interface& through, unsigned number) {
  if (number == 0 || number > kObjects) {
    complain_("C_CAN: command for message object " + std::to_string(number) + ", which does not exist");
    return;
  }
  Object& object = objects_[number - 1];
  const std::uint32_t what = through.command_mask;
  if ((what & kWrite) != 0) {
    if ((what & kMask) != 0) {
      object.mask1 = through.mask1;
      object.mask2 = through.mask2 & 0xDFFFU;
    }
    if ((what & kArbitration) != 0) {
      // Changing id or direction of an object that the handler may be looking at is allowed only with the valid bit off or unchanged id.
      const bool same = object.arb1 == through.arb1 && (object.arb2 & 0x7FFFU) == (through.arb2 & 0x7FFFU);
      if ((object.arb2 & kValid) != 0 && !same && (control_ & kInit) == 0 && (object.control & kRequest) != 0)
        complain_("C_CAN: id of object " + std::to_string(number) + " changed while its transmission is requested");
      object.arb1 = through.arb1;
      object.arb2 = through.arb2;
    }
    if ((what & kControl) != 0) object.control = through.control & 0xFF8FU;
    if ((what & kTransmitOrNew) != 0) object.control |= kRequest;
    if ((what & kDataA) != 0) {
      object.data[0] = through.data[0];
      object.data[1] = through.data[1];
    }
    if ((what & kDataB) != 0) {
      object.data[2] = through.data[2];
      object.data[3] = through.data[3];
    }
    return;
  }
  if ((what & kMask) != 0) {
    through.mask1 = object.mask1;
    through.mask2 = object.mask2;
  }
  if ((what & kArbitration) != 0) {
    through.arb1 = object.arb1;
    through.arb2 = object.arb2;
  }
  if ((what & kControl) != 0) through.control = object.control;
  if ((what & kDataA) != 0) {
    through.data[0] = object.data[0];
    through.data[1] = object.data[1];
  }
  if ((what & kDataB) != 0) {
    through.data[2] = object.data[2];
    through.data[3] = object.data[3];
  }
  if ((what & kClearPending) != 0) object.control &= ~kPending;
  if ((what & kTransmitOrNew) != 0) object.control &= ~kNewData;
}

bool CCan::offer(CanFrame& frame) {
  if (wants_ == 0) return false;
  const auto number = static_cast<unsigned>(std::countr_zero(wants_));
  const Object& object = objects_[number];
  frame = {};
  const bool extended = (object.arb2 & kExtended) != 0;
  const std::uint32_t id = ((object.arb2 & 0x1FFFU) << 16) | object.arb1;
  frame.id = extended ? id : id >> 18;
  frame.dlc = static_cast<std::uint8_t>(std::min<std::uint32_t>(object.control & 0xFU, 8));
  frame.flags = static_cast<std::uint8_t>((extended ? CanFrame::kExtended : 0) | ((object.arb2 & kTransmit) == 0 ? CanFrame::kRemote : 0));
  if ((object.arb2 & kTransmit) != 0)
    for (unsigned b = 0; b < frame.dlc; ++b) frame.data[b] = static_cast<std::uint8_t>(object.data[b / 2] >> (8 * (b & 1U)));
  sending_ = static_cast<int>(number);
  return true;
}

void CCan::began() {
  if (sending_ >= 0) objects_[static_cast<std::size_t>(sending_)].control &= ~kNewData;
}

void CCan::note_status(bool is_error_state) {
  if ((is_error_state && (control_ & kEie) != 0) || (!is_error_state && (control_ & kSie) != 0)) status_pending_ = true;
}

void CCan::sent(CanError error) {
  const int number = sending_;
  sending_ = -1;
  if (number < 0 || (control_ & kInit) != 0) return;
  Object& object = objects_[static_cast<std::size_t>(number)];
  status_ = (status_ & ~kLec) | static_cast<std::uint32_t>(error);
  count_sent(error);
  if (error != CanError::none) {
    note_status(false);
    update_states();
    return;
  }
  status_ |= kTxOk;
  note_status(false);
  // Data written meanwhile go out as a frame of their own.
  if ((object.control & kNewData) == 0) object.control &= ~kRequest;
  if ((object.control & kTxIe) != 0) object.control |= kPending;
  look();
  update_states();
}

bool CCan::accepts(const Object& object, const CanFrame& frame) const {
  const bool extended = (frame.flags & CanFrame::kExtended) != 0;
  const bool remote = (frame.flags & CanFrame::kRemote) != 0;
  const bool transmits = (object.arb2 & kTransmit) != 0;
  if ((object.arb2 & kValid) == 0 || remote != transmits) return false;
  const std::uint32_t id = extended ? frame.id : frame.id << 18;
  const std::uint32_t wanted = ((object.arb2 & 0x1FFFU) << 16) | object.arb1;
  std::uint32_t mask = 0x1FFFFFFF;
  bool compare_kind = true;
  if ((object.control & kUseMask) != 0) {
    mask = ((object.mask2 & 0x1FFFU) << 16) | object.mask1;
    compare_kind = (object.mask2 & 0x8000U) != 0;
  }
  if (compare_kind && extended != ((object.arb2 & kExtended) != 0)) return false;
  if (!extended) mask &= 0x1FFC0000U;
  return ((id ^ wanted) & mask) == 0;
}

void CCan::heard(const CanFrame& frame, CanError error) {
  status_ = (status_ & ~kLec) | static_cast<std::uint32_t>(error);
  count_heard(error);
  if (error != CanError::none) {
    note_status(false);
    update_states();
    return;
  }
  status_ |= kRxOk;
  note_status(false);
  update_states();
  for (Object& object : objects_) {
    if (!accepts(object, frame)) continue;
    const bool remote = (frame.flags & CanFrame::kRemote) != 0;
    if (remote && (object.control & kRemoteEnable) != 0) {
      object.control |= kRequest;
      look();
      return;
    }
    if (remote && (object.control & kUseMask) == 0) return;  // an object of exactly this id ignores it
    if ((object.control & kNewData) != 0) {
      if ((object.control & kEndOfBuffer) == 0) continue;  // the next object of the chain takes it
      object.control |= kMessageLost;
      ++lost_;
    }
    const bool extended = (frame.flags & CanFrame::kExtended) != 0;
    const std::uint32_t id = extended ? frame.id : frame.id << 18;
    object.arb1 = id & 0xFFFFU;
    object.arb2 = (object.arb2 & (kValid | kTransmit)) | (extended ? kExtended : 0U) | ((id >> 16) & 0x1FFFU);
    object.control = (object.control & ~0xFU) | frame.dlc | kNewData;
    if (!remote) object.control &= ~kRequest;  // the data have arrived: no remote frame is needed
    if (!remote)
      for (unsigned b = 0; b < 8; ++b) {
        std::uint16_t& half = object.data[b / 2];
        const unsigned shift = 8 * (b & 1U);
        // Bytes that the frame does not have are overwritten by something unspecified.
        const std::uint32_t byte = b < frame.dlc ? frame.data[b] : 0xA5U;
        half = static_cast<std::uint16_t>((half & ~(0xFFU << shift)) | (byte << shift));
      }
    if ((object.control & kRxIe) != 0) object.control |= kPending;
    look();
    return;
  }
}

void CCan::update_states() {
  ++changes_;
  const std::uint32_t before = status_;
  status_ &= ~(kEPass | kEWarn | kBOff);
  if (tec_ >= 96 || rec_ >= 96) status_ |= kEWarn;
  if (tec_ >= 128 || rec_ >= 128) status_ |= kEPass;
  if (tec_ > 255) {
    bus_off_ = true;
    control_ |= kInit;  // set by the controller; the program has to clear it
    sending_ = -1;
  }
  if (bus_off_) status_ |= kBOff | kEPass | kEWarn;
  if (((before ^ status_) & (kEWarn | kBOff)) != 0) note_status(true);
}

void CCan::idle(std::uint64_t bits) {
  if ((control_ & kInit) != 0) return;
  integrated_bits_ = std::min(integrated_bits_ + bits, kIntegrationBits);
  if (recovery_bits_ > 0) {
    recovery_bits_ -= std::min(recovery_bits_, bits);
    if (recovery_bits_ == 0) {
      bus_off_ = false;
      tec_ = rec_ = 0;
      update_states();
    }
  }
}

}  // namespace hoist::machine
