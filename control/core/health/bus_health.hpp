// The health of the bus: looks at every frame that passed, received or sent, and never at what it means. Frames lost on the way, load,
// emergencies, an id that two nodes share, an id that floods the bus, a second control computer.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/can_frame.hpp"
#include "control/contract/classify.hpp"
#include "control/core/health/bus_load.hpp"
#include "control/core/health/node_health.hpp"

namespace hoist::core {

class BusHealth {
 public:
  /// Where a CAN id is told: none.
  static constexpr std::uint16_t kNoId = 0xFFFF;

  /// At the start of every step, before its frames. Budgets follow the clock and not the number of steps: after a
  /// delayed step all frames of the pause come at once, and none of them is one too many.
  void next_tick(std::uint64_t time_ns, bool bus_up) noexcept {
    static_assert(kStreamUnit == 256);
    clock_ = static_cast<std::uint32_t>(time_ns * 2 / 78'125);  // 10 ms are kStreamUnit
    tick_ = static_cast<std::uint32_t>(time_ns / 10'000'000);
    if (second_tick_ == 0) second_tick_ = tick_;
    if (suspects_) fade_suspicions();
    if (babble_hold_ticks_ > 0 && --babble_hold_ticks_ == 0) babbling_id_ = kNoId;
    if (!bus_up) {
      for (NodeWatch& watch : watches_) watch.forget_streams();
    }
    if (++window_ticks_ >= kWindowTicks) {
      window_ticks_ = 0;
      settle();
    }
    if (tick_ - second_tick_ >= kTicksPerSecond) close_second();
  }

  /// A received frame; `what` = classify(frame). True when it is an emergency message of one of our nodes that is to be
  /// reported (not one of a flood).
  [[nodiscard]] bool take(const contract::CanFrame& frame, const contract::FrameClass& what) noexcept {
    using contract::CobKind;
    if ((frame.flags & contract::CanFrame::kError) != 0) return false;  // reported by the adapter, never on the wire
    load_.take(frame);
    const auto kind = static_cast<std::size_t>(what.kind);
    if (!what.is_remote() || kind >= contract::kNodeCobKinds || what.bytes == contract::kNotPlanned) {
      take_stranger(frame, what);
      return false;
    }
    const std::size_t at = what.node;
    const FramePlan& plan = kFramePlans[at][kind];
    NodeWatch& watch = watches_[at];
    if (what.fits && kind < kTpdoMax) {
      const StreamWatch::Came came = watch.tpdo[kind].take(plan.by_sync ? sync_clock_ : clock_, plan.period);
      if (what.kind == CobKind::tpdo1) {
        // One answer per SYNC. Frames sent on change may come in between, so a stream with its own timer proves
        // nothing.
        if (came == StreamWatch::Came::too_many && plan.by_sync) suspect(at, kSecondAnswer);
        // It has just reported a boot-up and was not started: this data comes from another node.
        if (watch.booted && tick_ - watch.boot_tick >= kBootGraceTicks) suspect(at, kDataAfterBoot);
      }
      if (came == StreamWatch::Came::in_time) return false;
      if (came == StreamWatch::Came::early) wavered_tick_ = tick_;
    } else if (what.fits && what.kind == CobKind::heartbeat) {
      if (take_heartbeat(at, frame, plan)) return false;
    }
    const bool in_budget = watch.rate[kind].take(tick_, plan.budget);
    if (!in_budget) accuse_babbling(frame.id);
    if (what.kind != CobKind::emergency || !what.fits) return false;
    take_emergency(nodes_[at], frame);
    return in_budget;
  }

  /// A frame that the core sent.
  void sent(const contract::CanFrame& frame) noexcept {
    namespace canopen = contract::canopen;
    load_.take(frame);
    if (frame.id == canopen::kSync) sync_clock_ += kStreamUnit;
    if (frame.id != canopen::kNmt || frame.data[0] != static_cast<std::uint8_t>(canopen::NmtCommand::start)) return;
    const auto node = contract::find_node(frame.data[1]);
    if (node && *node != contract::Node::core) watches_[static_cast<std::size_t>(*node)].booted = false;
  }

  [[nodiscard]] const NodeHealth& node(contract::Node node) const noexcept { return nodes_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const BusLoad& load() const noexcept { return load_; }
  /// SYNC messages that no node answered: lost between the core and the bus.
  [[nodiscard]] std::uint32_t syncs_lost() const noexcept { return syncs_lost_; }
  /// Node id that two nodes share, the core's own when a second control computer speaks; 0 = none.
  [[nodiscard]] std::uint8_t duplicate_id() const noexcept {
    if (!suspects_) return 0;
    if (twice_[kCore].verdict()) return contract::kNodes[kCore].id;
    for (std::size_t n = 0; n < kCore; ++n)
      if (twice_[n].verdict()) return contract::kNodes[n].id;
    return 0;
  }
  /// CAN id that comes far more often than planned; kNoId = none.
  [[nodiscard]] std::uint16_t babbling_id() const noexcept { return babbling_id_; }

 private:
  static constexpr std::size_t kTpdoMax = contract::kTpdoMax;
  // A frame delayed by less than this is late, not lost: a fully loaded serial line delayed frames by 50 ms (measured).
  static constexpr std::uint8_t kWindowTicks = 25;
  static constexpr std::uint32_t kTicksPerSecond = 100;
  static constexpr std::uint8_t kBabbleHoldTicks = 100;
  static constexpr std::uint32_t kWaverTicks = 500;
  // Suspicion points: 40 decide, one fades each step. That is five second answers in a row, three second heartbeats in
  // a row, three frames of process data after a boot-up, or five commands of another computer.
  static constexpr std::uint8_t kSecondAnswer = 10, kSecondHeartbeat = 20, kDataAfterBoot = 15, kForeignOrder = 10;
  // Frames already under way when the node fell silent may still arrive.
  static constexpr std::uint32_t kBootGraceTicks = 2;
  // Ids of no known node: allowed now and then (a logger, another machine), not as a flood.
  static constexpr RateWatch::Budget kStrangerBudget = RateWatch::budget(20);
  // A service tool's requests, whose answers the nodes may send (load plan: an SDO each 4.3 ms).
  static constexpr RateWatch::Budget kServiceBudget = RateWatch::budget(2 * kTicksPerSecond);
  static constexpr std::size_t kCore = contract::kRemoteNodeCount;
  // Only when all nodes that answer SYNC miss the same one was it the SYNC that was lost.
  static constexpr std::size_t kWitnesses = 3;

  void suspect(std::size_t node, std::uint8_t points) noexcept {
    twice_[node].add(points);
    suspects_ = true;
  }
  void fade_suspicions() noexcept {
    suspects_ = false;
    for (Suspicion& suspicion : twice_) {
      suspicion.next_tick();
      suspects_ = suspects_ || !suspicion.none();
    }
  }

  void accuse_babbling(std::uint32_t id) noexcept {
    if (babble_hold_ticks_ == 0) babbling_id_ = static_cast<std::uint16_t>(id < kNoId ? id : kNoId - 1U);
    babble_hold_ticks_ = kBabbleHoldTicks;
  }

  void take_stranger(const contract::CanFrame& frame, const contract::FrameClass& what) noexcept {
    using contract::CobKind;
    // Only one computer may control the hoist: SYNC, the drives' commands and the core's heartbeat are ours to send.
    const bool order = what.kind == CobKind::sync || (what.kind == CobKind::rpdo1 && what.is_remote());
    const bool own_heartbeat = what.kind == CobKind::heartbeat && what.is_of(contract::Node::core);
    if (order) suspect(kCore, kForeignOrder);
    if (own_heartbeat) suspect(kCore, kSecondHeartbeat);
    if (order || own_heartbeat) return;  // reported as a second computer; a flood of them is not babbling besides
    const bool service = what.kind == CobKind::sdo_request && what.is_remote();
    if (!(service ? service_.take(tick_, kServiceBudget) : strangers_.take(tick_, kStrangerBudget))) accuse_babbling(frame.id);
  }

  static void take_emergency(NodeHealth& node, const contract::CanFrame& frame) noexcept {
    const auto code = static_cast<std::uint16_t>(contract::read_le(&frame.data[0], 2));
    node.error_register = frame.data[2];
    if (code == 0) return;  // an error has ended
    node.emcy_code = code;
    if (node.emcy_count < 0xFFFF) ++node.emcy_count;
  }

  /// True when it came on time.
  [[nodiscard]] bool take_heartbeat(std::size_t at, const contract::CanFrame& frame, const FramePlan& plan) noexcept {
    NodeWatch& watch = watches_[at];
    if (frame.data[0] == static_cast<std::uint8_t>(contract::canopen::NmtState::boot_up)) {
      watch.forget_streams();
      watch.booted = true;
      watch.boot_tick = tick_;
      nodes_[at].error_register = 0;
      return false;
    }
    const StreamWatch::Came came = watch.heartbeat.take(clock_, plan.period);
    if (came == StreamWatch::Came::too_many) suspect(at, kSecondHeartbeat);
    return came == StreamWatch::Came::in_time;
  }

  /// Counts missing frames. A SYNC that never reached the bus is missing in every node's data, and no node is to blame.
  void settle() noexcept {
    std::array<std::array<std::uint32_t, kTpdoMax + 1>, contract::kRemoteNodeCount> lost{};
    std::uint32_t common = 0xFFFFFFFF;
    std::size_t witnesses = 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      NodeWatch& watch = watches_[n];
      for (std::size_t i = 0; i < kTpdoMax; ++i) {
        lost[n][i] = watch.tpdo[i].settle();
        const FramePlan& plan = kFramePlans[n][i];
        // Counted in steps, a node's timer of one step misses one when its clock drifts across ours, or when all frames
        // were delayed for a moment.
        if (!plan.by_sync && plan.period < 2 * kStreamUnit && (watch.tpdo[i].wavers(clock_) || tick_ - wavered_tick_ < kWaverTicks))
          lost[n][i] = 0;
      }
      lost[n][kTpdoMax] = watch.heartbeat.settle();
      if (!watch.tpdo[0].known() || !kFramePlans[n][0].by_sync) continue;
      ++witnesses;
      common = lost[n][0] < common ? lost[n][0] : common;
    }
    if (witnesses < kWitnesses) common = 0;
    syncs_lost_ += common;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      std::uint32_t sum = lost[n][kTpdoMax];
      for (std::size_t i = 0; i < kTpdoMax; ++i) {
        const FramePlan& plan = kFramePlans[n][i];
        // Process data of every n-th SYNC come later by a missing one, and are not missing.
        const std::uint32_t excused = plan.by_sync && plan.period == kStreamUnit ? common : 0;
        sum += lost[n][i] > excused ? lost[n][i] - excused : 0;
      }
      if (sum == 0) continue;
      std::uint8_t& second = watches_[n].lost_by_second[second_];
      second = static_cast<std::uint8_t>(second + sum < 255 ? second + sum : 255);
      nodes_[n].lost_frames += sum;
      nodes_[n].lost_10s = watches_[n].lost_lately();
    }
  }

  void close_second() noexcept {
    load_.close(static_cast<double>(tick_ - second_tick_) / kTicksPerSecond);
    second_tick_ = tick_;
    second_ = second_ + 1 < kSeconds ? second_ + 1 : 0;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      watches_[n].lost_by_second[second_] = 0;
      nodes_[n].lost_10s = watches_[n].lost_lately();
    }
  }

  static constexpr std::size_t kSeconds = std::tuple_size_v<decltype(NodeWatch::lost_by_second)>;

  std::array<NodeHealth, contract::kRemoteNodeCount> nodes_{};
  std::array<NodeWatch, contract::kRemoteNodeCount> watches_{};
  std::array<Suspicion, contract::kNodes.size()> twice_{};  // of two nodes with one id; the last one is a second computer
  BusLoad load_;
  RateWatch strangers_, service_;
  std::uint32_t tick_ = 0, clock_ = 0, second_tick_ = 0, sync_clock_ = 0, syncs_lost_ = 0, wavered_tick_ = 0;
  std::size_t second_ = 0;
  std::uint16_t babbling_id_ = kNoId;
  std::uint8_t window_ticks_ = 0, babble_hold_ticks_ = 0;
  bool suspects_ = false;  // any suspicion above 0
};

}  // namespace hoist::core
