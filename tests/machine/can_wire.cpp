#include "tests/machine/can_wire.hpp"

#include <algorithm>
#include <array>

namespace hoist::machine {
namespace {

using contract::CanFrame;

constexpr std::uint64_t kRecessiveTail = 11;
constexpr std::uint64_t kIdleLump = 8;         // idle bits are reported in groups of at least this many
constexpr unsigned kTailBits = 1 + 1 + 1 + 7;  // CRC delimiter, acknowledge and its delimiter, end of frame: never stuffed

// The bits in their order, as arbitration sees them.
std::uint32_t key_of(const CanFrame& frame) {
  const bool extended = (frame.flags & CanFrame::kExtended) != 0;
  const std::uint32_t remote = (frame.flags & CanFrame::kRemote) != 0 ? 1 : 0;
  if (!extended) return (frame.id << 21) | (remote << 20);
  return ((frame.id >> 18) << 21) | (3U << 19) | ((frame.id & 0x3FFFFU) << 1) | remote;
}

class BitCounter {
 public:
  void put(bool bit) {
    const bool next = bit != ((crc_ & 0x4000U) != 0);
    crc_ = (crc_ << 1) & 0x7FFFU;
    if (next) crc_ ^= 0x4599U;
    raw(bit);
  }
  void put(std::uint32_t value, unsigned count) {
    for (unsigned i = count; i-- > 0;) put(((value >> i) & 1U) != 0);
  }
  void put_crc() {
    const std::uint32_t crc = crc_;
    for (unsigned i = 15; i-- > 0;) raw(((crc >> i) & 1U) != 0);
  }
  [[nodiscard]] unsigned count() const { return count_; }

 private:
  void raw(bool bit) {
    ++count_;
    run_ = bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    if (run_ == 5) {  // the inserted opposite bit starts a new run
      ++count_;
      last_ = !bit;
      run_ = 1;
    }
  }
  std::uint32_t crc_{};
  unsigned count_{};
  unsigned run_{};
  bool last_{true};
};

}  // namespace

unsigned wire_bits(const CanFrame& frame) {
  BitCounter bits;
  const bool extended = (frame.flags & CanFrame::kExtended) != 0;
  const bool remote = (frame.flags & CanFrame::kRemote) != 0;
  bits.put(false);  // start of frame
  if (extended) {
    bits.put(frame.id >> 18, 11);
    bits.put(3, 2);  // SRR, IDE
    bits.put(frame.id & 0x3FFFFU, 18);
    bits.put(remote);
    bits.put(0, 2);  // r1, r0
  } else {
    bits.put(frame.id, 11);
    bits.put(remote);
    bits.put(0, 2);  // IDE, r0
  }
  bits.put(frame.dlc, 4);
  if (!remote)
    for (unsigned i = 0; i < frame.dlc; ++i) bits.put(frame.data[i], 8);
  bits.put_crc();
  return bits.count() + kTailBits;
}

void CanWire::advance(Time now) {
  for (;;) {
    if (busy_) {
      if (until_ > now) return;
      finish();
      continue;
    }
    const Time from = free_since_;
    if (now > from) {
      const std::uint64_t bits = (now - from) / kBit;
      if (bits >= kIdleLump) {
        for (std::size_t i = 0; i < stations_.size(); ++i) stations_[i]->idle(bits);
        free_since_ += bits * kBit;
      }
    }
    begin(now);
    if (!busy_) return;
  }
}

void CanWire::begin(Time now) {
  std::uint32_t best = UINT32_MAX;
  std::size_t winner = stations_.size();
  CanFrame frame;
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    if (!plugged_[i] || !stations_[i]->on_bus() || !stations_[i]->offer(frame)) continue;
    const std::uint32_t key = key_of(frame);
    if (winner == stations_.size() || key < best) {
      winner = i;
      best = key;
      frame_ = frame;
    }
  }
  if (winner == stations_.size()) return;
  sender_ = winner;
  stations_[winner]->began();
  bool heard = false;
  for (std::size_t i = 0; i < stations_.size(); ++i) heard |= i != winner && plugged_[i] && stations_[i]->on_bus();
  const Mischief mischief = hook_ ? hook_(winner, frame_, now) : Mischief::none;
  error_ = CanError::none;
  heard_by_others_ = mischief != Mischief::unheard;
  if (mischief == Mischief::corrupt) error_ = CanError::bit0;
  if (mischief == Mischief::unacknowledged || !heard) error_ = CanError::acknowledge;
  const unsigned bits = wire_bits(frame_) + (error_ != CanError::none ? kErrorBits : 0U) + kIntermissionBits;
  busy_ = true;
  until_ = now + bits * kBit;
  busy_time_ += bits * kBit;
}

void CanWire::finish() {
  busy_ = false;
  free_since_ = until_;
  const bool good = error_ == CanError::none;
  if (good) {
    ++frames_;
    if (see_) see_(frame_, until_);
  } else {
    ++errors_;
  }
  // Receivers first: their acknowledge precedes the sender's result.
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    if (i == sender_ || !plugged_[i] || !stations_[i]->on_bus()) continue;
    if (good && heard_by_others_) stations_[i]->heard(frame_, CanError::none);
    if (error_ == CanError::bit0) stations_[i]->heard(frame_, CanError::stuff);
  }
  stations_[sender_]->sent(error_);
  // Delimiter, end of frame and intermission: eleven recessive bits for those who count them.
  for (CanStation* station : stations_) station->idle(kRecessiveTail);
}

void HostStation::send(const CanFrame& frame) {
  const auto at =
      std::upper_bound(out_.begin(), out_.end(), frame, [](const CanFrame& a, const CanFrame& b) { return key_of(a) < key_of(b); });
  out_.insert(at, frame);
}
bool HostStation::offer(CanFrame& frame) {
  if (out_.empty()) return false;
  frame = out_.front();
  return true;
}
void HostStation::sent(CanError error) {
  // The frame being sent stays first: send() is only called between the wire's steps, and an equal id goes behind.
  if (error == CanError::none && !out_.empty()) out_.pop_front();
}

}  // namespace hoist::machine
