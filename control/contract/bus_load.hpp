// How full the bus is and how late a frame can be, computed from the rows of can_dictionary.def. Times are bit times of 4 us (250 kbit/s),
// so that everything is a whole number.
//
// Response times: the exact test of Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis: refuted, revisited
// and revised", Real-Time Systems 35 (2007): busy period, all instances in it, release jitter included. They hold if every sender sends
// by priority, as the LPC11C24 does with a message object for each identifier; mailbox_wait_bits() is what the STM32F072 adds.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "control/contract/can_dictionary.hpp"

namespace hoist::contract {

inline constexpr std::uint32_t kBusBitRate = 250'000;
inline constexpr std::uint64_t kBitsPerMs = kBusBitRate / 1000;

// Bits of a frame with 11-bit id and the three bits between frames; worst: a stuff bit wherever one can be (Davis et al., equation 1).
constexpr std::uint64_t plain_frame_bits(std::size_t bytes) { return 47 + 8 * bytes; }
constexpr std::uint64_t worst_frame_bits(std::size_t bytes) { return plain_frame_bits(bytes) + (34 + 8 * bytes - 1) / 4; }

// Release jitter of the senders, and the other assumptions of the plan.
inline constexpr std::uint64_t kSyncPeriodBits = 10 * kBitsPerMs;             // 100 Hz
inline constexpr std::uint64_t kSyncJitterBits = kBitsPerMs / 2;              // of the computer's loop
inline constexpr std::uint64_t kNodeJitterBits = kBitsPerMs;                  // a node works in ticks of a millisecond
inline constexpr std::uint64_t kCommandJitterBits = 2 * kBitsPerMs;           // the computer computes before it commands
inline constexpr std::uint64_t kServicePeriodBits = worst_frame_bits(8) * 4;  // a quarter of the bus is kept for SDO
inline constexpr std::uint64_t kErrorPeriodBits = 10 * kBitsPerMs;            // "with errors": one in 10 ms ...
inline constexpr std::uint64_t kErrorBits = 31;                               // ... its error frame, and the longest frame once more
inline constexpr int kCyclesUntilStale = 3;                                   // the computer stops after three cycles without a measurement
inline constexpr std::uint64_t kHeartbeatLossesTolerated = 1;

enum class FrameKind : std::uint8_t { sync, emergency, process, service, heartbeat };
struct BusFrame {
  std::uint32_t id = 0;
  FrameKind kind = FrameKind::sync;
  Node sender = Node::core;
  std::string_view what{};
  std::uint8_t bytes = 0;
  std::uint64_t period = 0, jitter = 0;  // minimum interval, and the sender's release jitter
  std::uint64_t deadline = 0;            // after which its absence causes a reaction
};

// Sorted by id, which is by priority. All service data counts as one frame with a quarter of the bus.
struct BusPlan {
  static constexpr std::size_t kFramesMax = 80;
  std::array<BusFrame, kFramesMax> frames{};
  std::size_t size = 0;
  [[nodiscard]] constexpr const BusFrame* begin() const { return frames.data(); }
  [[nodiscard]] constexpr const BusFrame* end() const { return frames.data() + size; }
};

// Which of the PDOs that some nodes have switched off (HOIST_PDO_OFF) are counted: of no node, of those that send them, of all.
enum class SwitchedPdos : std::uint8_t { none, as_planned, all };

constexpr BusPlan bus_plan(SwitchedPdos switched = SwitchedPdos::as_planned) {
  BusPlan plan;
  const auto add = [&](const BusFrame& frame) { plan.frames[plan.size++] = frame; };
  add({canopen::kSync, FrameKind::sync, Node::core, "SYNC", 0, kSyncPeriodBits, kSyncJitterBits, kSyncPeriodBits});
  const std::uint64_t inhibit = static_cast<std::uint64_t>(find_object(NodeKind::drive, 0x1015, 0)->default_value) * kBitsPerMs / 10;
  const std::uint64_t beat = static_cast<std::uint64_t>(find_object(NodeKind::drive, 0x1017, 0)->default_value) * kBitsPerMs;
  const std::uint64_t watch = (static_cast<std::uint64_t>(find_object(NodeKind::drive, 0x1016, 1)->default_value) & 0xFFFFU) * kBitsPerMs;
  for (std::size_t n = 0; n < kNodes.size(); ++n) {
    const Node node = static_cast<Node>(n);
    const std::uint32_t id = kNodes[n].id;
    const std::uint64_t own_beat = kNodes[n].kind == NodeKind::host ? canopen::kCoreHeartbeat_ms * kBitsPerMs : beat;
    add({canopen::kHeartbeatBase + id, FrameKind::heartbeat, node, "heartbeat", 1, own_beat, kNodeJitterBits,
         watch - kHeartbeatLossesTolerated * own_beat - own_beat});
    if (kNodes[n].kind == NodeKind::host) continue;
    add({canopen::kEmcyBase + id, FrameKind::emergency, node, "EMCY", 8, inhibit, 0, inhibit});
    for (const PdoInfo& p : kPdos) {
      if (p.kind != kNodes[n].kind) continue;
      bool is_switched = false;
      for (const PdoOff& off : kPdosOff) is_switched = is_switched || off.pdo == p.pdo;
      if (is_switched && (switched == SwitchedPdos::none || (switched == SwitchedPdos::as_planned && !pdo_on_by_default(p.pdo, node))))
        continue;
      const bool tx = p.direction == PdoDirection::tx;
      const std::uint32_t change_100us = pdo_on_change_100us(p.pdo);
      const std::uint64_t period = change_100us != 0     ? change_100us * kBitsPerMs / 10
                                   : tx && p.type <= 240 ? p.type * kSyncPeriodBits
                                                         : p.period_ms * kBitsPerMs;
      // A measurement has its timer even where changes come faster; a command has the deadline that its node keeps.
      const std::uint64_t deadline =
          tx ? kCyclesUntilStale * (change_100us != 0 ? p.period_ms * kBitsPerMs : period)
             : static_cast<std::uint64_t>(find_object(p.kind, pdo_communication_index(p), 5)->default_value) * kBitsPerMs;
      add({pdo_cob_id(p.pdo, node), FrameKind::process, tx ? node : Node::core, p.title, static_cast<std::uint8_t>(pdo_bytes(p.pdo)),
           period,
           change_100us != 0 ? 0
           : tx              ? kNodeJitterBits
                             : kCommandJitterBits,
           deadline});
    }
  }
  add({canopen::kSdoReplyBase, FrameKind::service, Node::core, "SDO, all together", 8, kServicePeriodBits, 0, 100 * kBitsPerMs});
  std::sort(plan.frames.begin(), plan.frames.begin() + static_cast<std::ptrdiff_t>(plan.size),
            [](const BusFrame& a, const BusFrame& b) { return a.id < b.id; });
  return plan;
}

// Share of the bus, 0 to 1 and above.
struct BusLoad {
  double worst = 0, plain = 0, frames_per_s = 0;
};
constexpr BusLoad bus_load(const BusPlan& plan, bool with_service) {
  BusLoad load;
  for (const BusFrame& f : plan) {
    if (f.kind == FrameKind::service && !with_service) continue;
    const double each_s = static_cast<double>(kBusBitRate) / static_cast<double>(f.period);
    load.worst += static_cast<double>(worst_frame_bits(f.bytes)) * each_s / kBusBitRate;
    load.plain += static_cast<double>(plain_frame_bits(f.bytes)) * each_s / kBusBitRate;
    load.frames_per_s += each_s;
  }
  return load;
}

struct BusConditions {
  bool storm = false;   // all nodes send their EMCY together, as often as they may
  bool errors = false;  // a bus error every 10 ms
  bool service = true;  // SDO uses all of its reserve
};

// Worst response time of frame `which`, in bit times: from its release until it has arrived. Nothing when it is
// unbounded.
constexpr std::optional<std::uint64_t> response_bits(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  constexpr std::uint64_t kGiveUpBits = 1000 * kBitsPerMs;
  const auto counts = [&](const BusFrame& f) {
    return !(f.kind == FrameKind::emergency && !conditions.storm) && !(f.kind == FrameKind::service && !conditions.service);
  };
  const auto times = [](std::uint64_t span, std::uint64_t period) { return (span + period - 1) / period; };
  const auto errors = [&](std::uint64_t span) {
    return conditions.errors ? times(span, kErrorPeriodBits) * (kErrorBits + worst_frame_bits(8)) : 0;
  };
  const BusFrame& frame = plan.frames[which];
  const std::uint64_t own = worst_frame_bits(frame.bytes);
  std::uint64_t blocking = 0;
  for (std::size_t k = which + 1; k < plan.size; ++k)
    if (counts(plan.frames[k])) blocking = std::max(blocking, worst_frame_bits(plan.frames[k].bytes));
  // What the frames before `until` put onto the bus within a span.
  const auto interference = [&](std::uint64_t span, std::size_t until) {
    std::uint64_t bits = 0;
    for (std::size_t k = 0; k < until; ++k)
      if (counts(plan.frames[k]))
        bits += times(span + plan.frames[k].jitter, plan.frames[k].period) * worst_frame_bits(plan.frames[k].bytes);
    return bits;
  };
  std::uint64_t busy = own;
  for (std::uint64_t next = 0;; busy = next) {
    next = errors(busy) + blocking + interference(busy, which) + times(busy + frame.jitter, frame.period) * own;
    if (next == busy) break;
    if (next > kGiveUpBits) return std::nullopt;
  }
  std::uint64_t worst = 0;
  const std::uint64_t instances = times(busy + frame.jitter, frame.period);
  for (std::uint64_t q = 0; q < instances; ++q) {
    std::uint64_t wait = blocking + q * own;
    for (std::uint64_t next = 0;; wait = next) {
      next = errors(wait + own) + blocking + q * own + interference(wait + 1, which);
      if (next == wait) break;
      if (next > kGiveUpBits) return std::nullopt;
    }
    worst = std::max(worst, frame.jitter + wait + own - q * frame.period);
  }
  return worst;
}

// What a sender with the three mailboxes of the STM32F072 adds to a response time (firmware/boards/stm32f072/transmit_order.hpp):
//   SYNC and EMCY    nothing, a mailbox is theirs
//   process data     two mailboxes hold a lower process datum of the sender and SDO or its heartbeat: until the datum is out
//   SDO, heartbeat   they share a mailbox: until a heartbeat, which is the lower, is out
// and, when its own turn comes, one frame of the sender that was in its mailbox first. Nothing when there is no bound.
constexpr std::optional<std::uint64_t> mailbox_wait_bits(const BusPlan& plan, std::size_t which, const BusConditions& conditions) {
  const BusFrame& frame = plan.frames[which];
  if (frame.kind == FrameKind::sync || frame.kind == FrameKind::emergency) return 0;
  std::uint64_t wait = 0;
  for (std::size_t k = which + 1; k < plan.size; ++k) {
    const BusFrame& lower = plan.frames[k];
    const bool same_sender = lower.sender == frame.sender || frame.kind == FrameKind::service;
    const FrameKind holds = frame.kind == FrameKind::process ? FrameKind::process : FrameKind::heartbeat;
    if (!same_sender || lower.kind != holds) continue;
    const auto response = response_bits(plan, k, conditions);
    if (!response) return std::nullopt;
    wait = std::max(wait, *response);
  }
  return wait + worst_frame_bits(8);
}

constexpr double bits_ms(std::uint64_t bits) { return static_cast<double>(bits) / static_cast<double>(kBitsPerMs); }

}  // namespace hoist::contract
