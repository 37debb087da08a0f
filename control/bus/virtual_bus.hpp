// A CAN bus inside one process, in virtual time: bit times, arbitration, bounded queues, faults on request. No clock, no threads; the
// same calls give the same frames at the same nanosecond, every time.
//
// What it models: one frame on the wire at a time; when the wire is free, the pending frame with the lowest id wins (each port offers its
// own lowest first, as a controller with priority mailboxes does); a frame is received when its last bit before the intermission is over.
// What it does not model: error counters and bus-off, wire lengths, clock tolerance. Frame lengths come from the DLC, with or without the
// worst case of bit stuffing, not from the bits of each frame.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>

#include "control/contract/can_frame.hpp"

namespace hoist::bus {

inline constexpr std::size_t kVirtualPortMax = 16;      // ports on one bus
inline constexpr std::size_t kVirtualTxQueueMax = 32;   // frames waiting in one port; send() refuses more
inline constexpr std::size_t kVirtualRxQueueMax = 256;  // frames received and not yet fetched; later ones are lost and counted
inline constexpr std::uint32_t kVirtualRetryMax = 32;   // corrupted attempts of one frame before the port gives it up and counts it
inline constexpr std::uint32_t kErrorFrameBits = 31;    // canbus plan, section 6: error flags, delimiter, intermission

struct VirtualBusOptions {
  std::uint32_t bit_rate = 250000;
  bool worst_stuffing = false;  // true: every frame as long as stuffing can make it
};

// What a fault hook says about the frame that has just won arbitration.
struct BusFault {
  enum class Kind : std::uint8_t {
    none,
    drop,     // occupies the bus, is not received, and its sender is told that it was sent
    corrupt,  // destroyed by an error frame; the sender tries again
    delay,    // returns to its sender, which may offer it again after delay_ns
  };
  Kind kind = Kind::none;
  std::uint64_t delay_ns = 0;
  std::uint32_t deaf_ports = 0;  // bit n: port n does not receive this frame
};

struct VirtualBusCounters {
  std::uint64_t frames = 0;      // complete frames on the bus, dropped ones too
  std::uint64_t busy_ns = 0;     // time the wire was taken
  std::uint64_t tx_refused = 0;  // send() on a full or disconnected port, or a frame that cannot exist
  std::uint64_t rx_lost = 0;     // receive queue full
  std::uint64_t dropped = 0;     // by the hook
  std::uint64_t corrupted = 0;   // by the hook
  std::uint64_t delayed = 0;     // by the hook
  std::uint64_t given_up = 0;    // after kVirtualRetryMax corrupted attempts
};

/// Bits of one frame on the wire with its three bits of intermission. 11-bit id with 8 bytes: 111, at worst 135.
constexpr std::uint32_t frame_bits(const contract::CanFrame& frame, bool worst_stuffing) {
  const bool extended = (frame.flags & contract::CanFrame::kExtended) != 0;
  const bool remote = (frame.flags & contract::CanFrame::kRemote) != 0;
  const std::uint32_t data_bits = remote ? 0U : 8U * frame.dlc;
  const std::uint32_t stuffable = (extended ? 54U : 34U) + data_bits;
  return (extended ? 67U : 47U) + data_bits + (worst_stuffing ? (stuffable - 1) / 4 : 0U);
}

/// Lower wins: the bits in the order they go over the wire. A data frame beats a remote request, a short id the long one it begins.
constexpr std::uint32_t arbitration_key(const contract::CanFrame& frame) {
  const bool extended = (frame.flags & contract::CanFrame::kExtended) != 0;
  const std::uint32_t remote = (frame.flags & contract::CanFrame::kRemote) != 0 ? 1 : 0;
  if (!extended) return (frame.id << 21) | (remote << 20);
  return ((frame.id >> 18) << 21) | (1U << 20) | (1U << 19) | ((frame.id & 0x3FFFFU) << 1) | remote;
}

class VirtualBus {
 public:
  using Frame = contract::CanFrame;
  using FaultHook = std::function<BusFault(std::size_t from_port, const Frame& frame, std::uint64_t now_ns)>;

  explicit VirtualBus(VirtualBusOptions options = {}) : options_(options), bit_ns_(1'000'000'000ULL / std::max(options.bit_rate, 1U)) {}

  /// A new port; kVirtualPortMax when all are used.
  [[nodiscard]] std::size_t add_port() {
    if (port_count_ == kVirtualPortMax) return kVirtualPortMax;
    ports_[port_count_].connected = true;
    return port_count_++;
  }

  /// Queues one frame; false (and counted) when the port is full, disconnected or unknown, or the frame cannot exist.
  [[nodiscard]] bool send(std::size_t port, const Frame& frame) {
    const bool extended = (frame.flags & Frame::kExtended) != 0;
    if (port >= port_count_ || !ports_[port].connected || ports_[port].tx_count == kVirtualTxQueueMax || frame.dlc > 8 ||
        (frame.flags & Frame::kError) != 0 || frame.id > (extended ? 0x1FFFFFFFU : 0x7FFU)) {
      ++counters_.tx_refused;
      return false;
    }
    insert(ports_[port], Pending{frame, arbitration_key(frame), now_ns_, 0});
    waiting_ports_ |= 1U << port;
    return true;
  }

  /// The oldest frame received by this port; false without one. Only filled by advance() without a receiver.
  [[nodiscard]] bool receive(std::size_t port, Frame& frame) {
    if (port >= port_count_ || ports_[port].rx_count == 0) return false;
    Port& p = ports_[port];
    frame = p.rx[p.rx_first];
    p.rx_first = (p.rx_first + 1) % kVirtualRxQueueMax;
    --p.rx_count;
    return true;
  }

  /// Advances time and calls on_frame(port, frame) for every receiving port, at the time of reception (now_ns()) and in the order of the
  /// ports. on_frame may send: the answer takes part in the next arbitration.
  template <class OnFrame>
  void advance(std::uint64_t dt_ns, OnFrame&& on_frame) {
    const std::uint64_t end_ns = now_ns_ + dt_ns;
    for (;;) {
      if (in_flight_) {
        if (heard_ns_ > end_ns) break;
        now_ns_ = heard_ns_;
        finish(on_frame);
        continue;
      }
      const std::uint64_t start_ns = std::max(free_ns_, now_ns_);
      const std::uint64_t ready_ns = earliest_ready_ns(start_ns);
      if (ready_ns > end_ns) break;
      now_ns_ = ready_ns;
      start();
    }
    now_ns_ = end_ns;
  }
  /// The same into the receive queues.
  void advance(std::uint64_t dt_ns) {
    advance(dt_ns, [this](std::size_t port, const Frame& frame) { store(ports_[port], frame); });
  }

  /// Unplugs a port or plugs it in. Its waiting frames and a frame on the wire are lost.
  void set_connected(std::size_t port, bool connected) {
    if (port >= port_count_) return;
    Port& p = ports_[port];
    if (p.connected == connected) return;
    p.connected = connected;
    p.tx_count = 0;
    p.rx_count = 0;
    waiting_ports_ &= ~(1U << port);
    if (!connected && in_flight_ && flight_port_ == port) flight_fault_.kind = BusFault::Kind::drop;
  }
  [[nodiscard]] bool connected(std::size_t port) const { return port < port_count_ && ports_[port].connected; }

  void set_fault_hook(FaultHook hook) { fault_hook_ = std::move(hook); }
  [[nodiscard]] std::uint64_t now_ns() const { return now_ns_; }
  [[nodiscard]] std::size_t waiting(std::size_t port) const { return port < port_count_ ? ports_[port].tx_count : 0; }
  [[nodiscard]] const VirtualBusCounters& counters() const { return counters_; }

 private:
  static constexpr std::uint64_t kNever = ~0ULL;

  struct Pending {
    Frame frame{};
    std::uint32_t key = 0;
    std::uint64_t ready_ns = 0;
    std::uint32_t attempts = 0;
  };
  struct Port {
    bool connected = false;
    std::size_t tx_count = 0;  // sorted by key; equal keys keep the order in which they came
    std::array<Pending, kVirtualTxQueueMax> tx{};
    std::size_t rx_first = 0, rx_count = 0;
    std::array<Frame, kVirtualRxQueueMax> rx{};
  };

  static void insert(Port& port, const Pending& pending) {
    std::size_t at = port.tx_count++;
    for (; at > 0 && port.tx[at - 1].key > pending.key; --at) port.tx[at] = port.tx[at - 1];
    port.tx[at] = pending;
  }
  static Pending take(Port& port, std::size_t at) {
    const Pending taken = port.tx[at];
    for (--port.tx_count; at < port.tx_count; ++at) port.tx[at] = port.tx[at + 1];
    return taken;
  }
  void store(Port& port, const Frame& frame) {
    if (port.rx_count == kVirtualRxQueueMax) {
      ++counters_.rx_lost;
      return;
    }
    port.rx[(port.rx_first + port.rx_count++) % kVirtualRxQueueMax] = frame;
  }

  // A frame without acknowledge is repeated for ever: with fewer than two connected ports nothing is sent.
  [[nodiscard]] bool alone() const {
    std::size_t connected_ports = 0;
    for (std::size_t i = 0; i < port_count_; ++i) connected_ports += ports_[i].connected ? 1U : 0U;
    return connected_ports < 2;
  }
  [[nodiscard]] std::uint64_t earliest_ready_ns(std::uint64_t not_before_ns) const {
    // Fast path: usually no port wants to send, and this is called most often.
    if (waiting_ports_ == 0) return kNever;
    std::uint64_t earliest = kNever;
    for (std::uint32_t left = waiting_ports_; left != 0; left &= left - 1) {
      const Port& port = ports_[static_cast<std::size_t>(std::countr_zero(left))];
      for (std::size_t j = 0; j < port.tx_count; ++j) earliest = std::min(earliest, std::max(port.tx[j].ready_ns, not_before_ns));
    }
    return earliest == kNever || alone() ? kNever : earliest;
  }

  // Arbitration at now_ns_.
  void start() {
    std::size_t winner = kVirtualPortMax, winner_at = 0;
    for (std::uint32_t left = waiting_ports_; left != 0; left &= left - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(left));
      for (std::size_t j = 0; j < ports_[i].tx_count; ++j) {
        if (ports_[i].tx[j].ready_ns > now_ns_) continue;
        if (winner == kVirtualPortMax || ports_[i].tx[j].key < ports_[winner].tx[winner_at].key) winner = i, winner_at = j;
        break;  // sorted: no later one of this port can win
      }
    }
    flight_ = take(ports_[winner], winner_at);
    if (ports_[winner].tx_count == 0) waiting_ports_ &= ~(1U << winner);
    flight_port_ = winner;
    flight_fault_ = fault_hook_ ? fault_hook_(winner, flight_.frame, now_ns_) : BusFault{};
    if (flight_fault_.kind == BusFault::Kind::delay) {
      ++counters_.delayed;
      flight_.ready_ns = now_ns_ + std::max<std::uint64_t>(flight_fault_.delay_ns, 1);
      insert(ports_[winner], flight_);
      waiting_ports_ |= 1U << winner;
      return;
    }
    std::uint32_t bits = frame_bits(flight_.frame, options_.worst_stuffing);
    if (flight_fault_.kind == BusFault::Kind::corrupt) bits += kErrorFrameBits - kIntermissionBits;
    in_flight_ = true;
    free_ns_ = now_ns_ + bits * bit_ns_;
    heard_ns_ = free_ns_ - kIntermissionBits * bit_ns_;
    counters_.busy_ns += bits * bit_ns_;
  }

  template <class OnFrame>
  void finish(OnFrame& on_frame) {
    in_flight_ = false;
    if (flight_fault_.kind == BusFault::Kind::corrupt) {
      ++counters_.corrupted;
      Port& sender = ports_[flight_port_];
      if (++flight_.attempts >= kVirtualRetryMax || sender.tx_count == kVirtualTxQueueMax || !sender.connected) {
        ++counters_.given_up;
      } else {
        // Before frames with an equal id, so that it keeps its place.
        std::size_t at = sender.tx_count++;
        for (; at > 0 && sender.tx[at - 1].key >= flight_.key; --at) sender.tx[at] = sender.tx[at - 1];
        sender.tx[at] = flight_;
        waiting_ports_ |= 1U << flight_port_;
      }
      return;
    }
    ++counters_.frames;
    if (flight_fault_.kind == BusFault::Kind::drop) {
      ++counters_.dropped;
      return;
    }
    const Frame frame = flight_.frame;  // a copy: on_frame may send
    const std::size_t from = flight_port_;
    const std::uint32_t deaf = flight_fault_.deaf_ports;
    for (std::size_t i = 0; i < port_count_; ++i)
      if (i != from && ports_[i].connected && ((deaf >> i) & 1U) == 0) on_frame(i, frame);
  }

  static constexpr std::uint32_t kIntermissionBits = 3;

  VirtualBusOptions options_;
  std::uint64_t bit_ns_;
  std::uint64_t now_ns_ = 0, free_ns_ = 0, heard_ns_ = 0;
  std::size_t port_count_ = 0;
  std::uint32_t waiting_ports_ = 0;  // bit per port with something to send
  bool in_flight_ = false;
  Pending flight_{};
  std::size_t flight_port_ = 0;
  BusFault flight_fault_{};
  FaultHook fault_hook_{};
  VirtualBusCounters counters_{};
  std::array<Port, kVirtualPortMax> ports_{};
};

}  // namespace hoist::bus
