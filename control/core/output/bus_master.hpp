// The CANopen master: finds each node, asks what it is, sets its settings, starts it, and keeps the heartbeat and the SYNC. The settings are the
// parameters that live in it, which are written, and the objects on whose defaults the core relies (kKeptObjects), which are written when they
// differ. Each counts once the node has told its value back: a serial line has no checksum, and a damaged write is confirmed like any other.
//
// One SDO request is under way at a time and at most one leaves per step, which keeps the pace of at least 5 ms that
// the bus load plan assumes. Every wait ends: a request is tried kSdoTries times, then its node rests kNodeRest ticks
// and is configured from the start.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "control/contract/params.hpp"
#include "control/contract/sdo_transfer.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

class BusMaster {
 public:
  enum class Phase : std::uint8_t { absent, identify, configure, start, running };

  void next_tick() noexcept {
    for (Link& link : links_) {
      if (link.heartbeat_age_ticks < kOldestTicks) ++link.heartbeat_age_ticks;
      if (link.rest_ticks > 0) --link.rest_ticks;
    }
  }

  /// A heartbeat or boot-up frame. True when the node has just restarted.
  [[nodiscard]] bool take_heartbeat(contract::Node node, std::uint8_t state) noexcept {
    Link& link = links_[static_cast<std::size_t>(node)];
    link.heartbeat_age_ticks = 0;
    link.state = state;
    const bool boot = state == static_cast<std::uint8_t>(contract::canopen::NmtState::boot_up);
    if (boot) {
      if (busy_ && sdo_node_ == node) busy_ = false;
      identify(link);
    } else if (link.phase == Phase::absent && link.rest_ticks == 0 && !hands_off_) {
      identify(link);
    }
    return boot;
  }

  /// False when this was not requested. During `hands_off` a firmware update sends the requests.
  [[nodiscard]] bool take_sdo_reply(contract::Node node, const contract::CanFrame& frame) noexcept {
    if (hands_off_) return true;
    if (!busy_ || node != sdo_node_) return false;
    sdo_.on_frame(frame);
    Link& link = links_[static_cast<std::size_t>(node)];
    if (sdo_.outcome() == Sdo::Outcome::aborted) {
      // The node refused the value: repeating the request at once would not help.
      busy_ = false;
      if (sdo_what_ == kSerial) {
        link.serial = 0;  // it has none
        link.serial_known = true;
      } else {
        give_up(link);
      }
      return true;
    }
    // No answer to this, or one that no server may give, or a word of another size: step() asks again.
    if (sdo_.outcome() != Sdo::Outcome::done || (reads_ && sdo_.uploaded().size() != asked_.bytes)) return false;
    busy_ = false;
    if (sdo_what_ == kIdentity) {
      // A serial line has no checksum. An answer that would keep a node from work counts only when it comes twice.
      const std::uint32_t told = sdo_.value();
      std::uint32_t& known = link.product_known ? link.revision : link.product;
      const bool twice = told == known;
      known = told;
      if (link.product_known) {
        if (other_rules(told) && !twice) return true;
        link.serial_known = false;
        link.unwritten = params_of(node);
        link.untold = kept_of(node);
        link.phase = Phase::configure;
      } else if ((told & contract::kLoaderProduct) == 0) {
        link.product_known = true;
      } else if (twice) {
        // A node in its loader has no parameters and does not run. One with a whole program returns to work by itself,
        // unless it is asked.
        link.phase = Phase::absent;
        link.rest_ticks = kLoaderRest;
      }
      return true;
    }
    if (sdo_what_ == kSerial) {
      // As above: only one that was told twice is another part.
      const bool twice = sdo_.value() == link.serial;
      link.serial = sdo_.value();
      link.serial_known = twice;
      return true;
    }
    const std::uint32_t bit = 1U << sdo_what_;
    const bool differs = reads_ && sdo_.value() != asked_.word;
    link.unwritten = differs ? link.unwritten | bit : link.unwritten & ~bit;
    link.untold = reads_ ? link.untold & ~bit : link.untold | bit;
    return true;
  }

  /// After the parameters changed: sends each node the ones that live in it.
  void params_changed(const contract::Params& before, const contract::Params& now) noexcept {
    for (std::size_t i = 0; i < contract::kParamObjects.size(); ++i) {
      const std::size_t row = contract::param_index(contract::kParamObjects[i].param);
      if (contract::get_param(before, row) == contract::get_param(now, row)) continue;
      for (std::size_t n = 0; n < links_.size(); ++n)
        if (contract::kNodes[n].kind == contract::kParamObjects[i].kind) links_[n].unwritten |= 1U << i;
      // Also for a start that is asked for in this step.
      all_running_ = false;
      // A value under way is outdated: its answer must not count for the new one.
      if (busy_ && sdo_what_ == i) busy_ = false;
    }
  }

  /// NMT and SDO frames of this step, then the heartbeat when it is due. SYNC is the caller's, last of all.
  /// `hands_off`: a firmware update owns the SDO channel; a request of our own would abort it. Afterwards each node is
  /// configured from the start.
  template <std::size_t N>
  void step(std::uint64_t tick, const Estimate& sensed, const contract::Params& params, bool hands_off,
            FixedVector<contract::CanFrame, N>& out) noexcept {
    namespace canopen = contract::canopen;
    if (tick % kHeartbeatTicks == 0) send(out, canopen::heartbeat(contract::node_id(contract::Node::core), canopen::NmtState::operational));
    hands_off_ = hands_off;
    time_ns_ += kStep_ns;
    if (hands_off) {
      meet_all_again();
      return;
    }
    all_running_ = true;
    for (std::size_t n = 0; n < links_.size(); ++n) {
      advance(static_cast<contract::Node>(n), sensed, out);
      all_running_ = all_running_ && links_[n].phase == Phase::running && links_[n].settled() && !asks_serial(links_[n]);
    }
    if (busy_) {
      wait_for_reply(params, out);
    } else {
      ask_next(params, out);
    }
  }

  /// Configures every node from the start at its next heartbeat: identity, settings, NMT start.
  void meet_all_again() noexcept {
    for (Link& link : links_) {
      link.phase = Phase::absent;
      link.rest_ticks = 0;
    }
    busy_ = all_running_ = false;
  }

  [[nodiscard]] Phase phase(contract::Node node) const noexcept { return links_[static_cast<std::size_t>(node)].phase; }
  /// State in the node's latest heartbeat; 255 before the first one.
  [[nodiscard]] std::uint8_t nmt_state(contract::Node node) const noexcept { return links_[static_cast<std::size_t>(node)].state; }
  /// Heartbeats in a row that should have come by now. One may be 30 ms late on a full bus (load plan: 28 ms).
  [[nodiscard]] std::uint8_t heartbeats_missed(contract::Node node) const noexcept {
    const std::uint8_t age_ticks = links_[static_cast<std::size_t>(node)].heartbeat_age_ticks;
    return age_ticks < kNodeHeartbeatTicks + kHeartbeatLateTicks
               ? std::uint8_t{0}
               : static_cast<std::uint8_t>((age_ticks - kHeartbeatLateTicks) / kNodeHeartbeatTicks);
  }
  /// Every node is known, has its settings and runs.
  [[nodiscard]] bool all_running() const noexcept { return all_running_; }
  /// A node's program has another protocol revision: CiA 301 raises the major half of the revision when behaviour
  /// changes.
  [[nodiscard]] bool any_other_version() const noexcept {
    return std::any_of(links_.begin(), links_.end(),
                       [](const Link& link) { return link.phase > Phase::identify && other_rules(link.revision); });
  }
  /// Stands for the serial numbers of all nodes, each in its place (FNV-1a, 32 bits); never 0. Nodes without a number are alike.
  [[nodiscard]] std::uint32_t nodes_id() const noexcept {
    std::uint32_t id = 0x811C9DC5U;
    for (const Link& link : links_)
      for (unsigned shift = 0; shift < 32; shift += 8) id = (id ^ (link.serial >> shift & 0xFFU)) * 0x01000193U;
    return id == 0 ? 1U : id;
  }
  /// Any node says that it is a build for a simulator.
  [[nodiscard]] bool simulated() const noexcept {
    std::uint32_t products = 0;
    for (const Link& link : links_) products |= link.product;
    return (products & contract::canopen::kSimulatedProduct) != 0;
  }

 private:
  /// Identity and settings are words of at most four bytes.
  using Sdo = contract::SdoTransfer<4>;

  struct Link {
    std::uint32_t product = 0, revision = 0;
    bool product_known = false;  // and its revision is asked for next
    std::uint32_t serial = 0;
    bool serial_known = false;                // since its start
    std::uint32_t unwritten = 0, untold = 0;  // bit per setting
    Phase phase = Phase::absent;
    std::uint8_t state = 255;
    std::uint8_t heartbeat_age_ticks = kOldestTicks;
    std::uint16_t rest_ticks = 0;
    std::uint8_t start_ticks = 0;

    [[nodiscard]] bool settled() const noexcept { return (unwritten | untold) == 0; }
  };
  struct Setting {
    std::uint16_t index;
    std::uint8_t sub;
    std::size_t bytes;
    std::uint32_t word;
  };
  // Rows of kParamObjects, then those of kKeptObjects.
  static constexpr std::size_t kSettings = contract::kParamObjects.size() + contract::kKeptObjects.size();
  // One for all kinds of node.
  static constexpr auto kRevision = static_cast<std::uint32_t>(contract::find_object(contract::NodeKind::tilt, 0x1018, 3)->default_value);

  static constexpr std::uint64_t kHeartbeatTicks = contract::canopen::kCoreHeartbeat_ms / 10;
  static constexpr std::uint8_t kNodeHeartbeatTicks = 10, kHeartbeatLateTicks = 3;
  static constexpr std::uint8_t kSilenceTicks = 25;                                // 250 ms, the consumer time of the plan
  static constexpr std::uint64_t kStep_ns = 10'000'000, kAnswer_ns = 100'000'000;  // later answers do not come (load plan: 27 ms at worst)
  static constexpr std::uint8_t kSdoTries = 3;
  static constexpr std::uint8_t kNodeRest = 100;      // one second
  static constexpr std::uint16_t kLoaderRest = 9000;  // a minute and a half: a loader waits one minute for a request
  static constexpr std::uint8_t kStartTicks = 20;     // from NMT start to the first process data, with two heartbeats in between
  // The requests that are no settings: 1018h:2, then :3; and :4 of a node at work.
  static constexpr std::size_t kIdentity = 31, kSerial = 32;
  static_assert(kSettings <= kIdentity, "a mask holds a bit per setting");

  template <std::size_t N>
  static void send(FixedVector<contract::CanFrame, N>& out, const contract::CanFrame& frame) noexcept {
    // Two drive commands, heartbeat, an SDO, an NMT per node and SYNC: 11 at most, far below the room.
    static_assert(N >= 16);
    static_cast<void>(out.push_back(frame));
  }

  static std::uint32_t params_of(contract::Node node) noexcept {
    std::uint32_t mask = 0;
    for (std::size_t i = 0; i < contract::kParamObjects.size(); ++i)
      if (contract::kParamObjects[i].kind == contract::kNodes[static_cast<std::size_t>(node)].kind) mask |= 1U << i;
    return mask;
  }
  static std::uint32_t kept_of(contract::Node node) noexcept {
    std::uint32_t mask = 0;
    for (std::size_t i = contract::kParamObjects.size(); i < kSettings; ++i)
      if (contract::object_applies(*contract::kKeptObjects[i - contract::kParamObjects.size()],
                                   contract::kNodes[static_cast<std::size_t>(node)].kind))
        mask |= 1U << i;
    return mask;
  }
  static Setting setting(std::size_t i, const contract::Params& params) noexcept {
    if (i < contract::kParamObjects.size()) {
      const contract::ParamObject& object = contract::kParamObjects[i];
      return {object.index, object.sub, 4, contract::param_word(object, contract::get_param(params, contract::param_index(object.param)))};
    }
    const contract::ObjectInfo& kept = *contract::kKeptObjects[i - contract::kParamObjects.size()];
    return {kept.index, kept.sub, contract::object_bytes(kept.type), contract::raw_word(kept.type, kept.default_value)};
  }

  static constexpr bool other_rules(std::uint32_t revision) noexcept { return revision >> 16U != kRevision >> 16U; }

  // A simulated node has no serial number: parts_checked() needs none of it.
  static constexpr bool asks_serial(const Link& link) noexcept {
    return !link.serial_known && (link.product & contract::canopen::kSimulatedProduct) == 0;
  }

  static void identify(Link& link) noexcept {
    link.phase = Phase::identify;
    link.rest_ticks = 0;
    link.product_known = false;
  }
  // After kNodeRest ticks the node is configured from the start. Exception: a running node that refused one value gets
  // only that value again, because some of the others may not be written while the hoist moves.
  static void give_up(Link& link) noexcept {
    if (link.phase != Phase::running) link.phase = Phase::absent;
    link.rest_ticks = kNodeRest;
  }

  template <std::size_t N>
  void advance(contract::Node node, const Estimate& sensed, FixedVector<contract::CanFrame, N>& out) noexcept {
    namespace canopen = contract::canopen;
    Link& link = links_[static_cast<std::size_t>(node)];
    const bool silent = link.heartbeat_age_ticks >= kSilenceTicks;
    switch (link.phase) {
      case Phase::absent:
        return;
      case Phase::identify:
        if (silent) link.phase = Phase::absent;
        return;
      case Phase::configure:
        if (silent) {
          link.phase = Phase::absent;
        } else if (link.settled()) {
          link.phase = Phase::start;
          link.start_ticks = 0;
          send(out, canopen::nmt(canopen::NmtCommand::start, contract::node_id(node)));
        }
        return;
      case Phase::start:
        // Process data that were already under way when the node was started count: a node that outlived the core never stopped.
        if (link.start_ticks > 0 && !sensed.heard(node).lost()) {
          link.phase = Phase::running;
        } else if (++link.start_ticks >= kStartTicks) {
          give_up(link);
        }
        return;
      case Phase::running:
        // PDO timeout: treat the node as rebooted at its next heartbeat.
        if (sensed.heard(node).lost()) link.phase = Phase::absent;
        return;
    }
  }

  template <std::size_t N>
  void wait_for_reply(const contract::Params& params, FixedVector<contract::CanFrame, N>& out) noexcept {
    // Only its time runs: a request in one frame has nothing more to send.
    static_cast<void>(sdo_.step(time_ns_));
    if (sdo_.outcome() == Sdo::Outcome::busy) return;
    if (++sdo_tries_ < kSdoTries) {
      ask(params, out);
      return;
    }
    busy_ = false;
    give_up(links_[static_cast<std::size_t>(sdo_node_)]);
  }

  template <std::size_t N>
  void ask_next(const contract::Params& params, FixedVector<contract::CanFrame, N>& out) noexcept {
    namespace canopen = contract::canopen;
    for (std::size_t i = 0; i < links_.size(); ++i) {
      turn_ = turn_ + 1 < links_.size() ? turn_ + 1 : 0;
      const Link& link = links_[turn_];
      const bool identify = link.phase == Phase::identify;
      const bool set = (link.phase == Phase::configure || link.phase == Phase::running) && !link.settled() && link.rest_ticks == 0;
      const bool number = link.phase == Phase::running && link.rest_ticks == 0 && asks_serial(link);
      if (!identify && !set && !number) continue;
      sdo_node_ = static_cast<contract::Node>(turn_);
      reads_ = !set || link.unwritten == 0;
      sdo_what_ = identify ? kIdentity : set ? static_cast<std::size_t>(std::countr_zero(reads_ ? link.untold : link.unwritten)) : kSerial;
      sdo_tries_ = 0;
      // A node in NMT state STOPPED ignores SDO; send NMT start first.
      if (link.state == static_cast<std::uint8_t>(canopen::NmtState::stopped))
        send(out, canopen::nmt(canopen::NmtCommand::pre_operational, contract::node_id(sdo_node_)));
      ask(params, out);
      return;
    }
  }

  template <std::size_t N>
  void ask(const contract::Params& params, FixedVector<contract::CanFrame, N>& out) noexcept {
    const std::uint8_t id = contract::node_id(sdo_node_);
    const Link& link = links_[static_cast<std::size_t>(sdo_node_)];
    // Found again at each try: a ramping gain changes in every step.
    asked_ = sdo_what_ == kSerial     ? Setting{0x1018, 4, 4, 0}
             : sdo_what_ == kIdentity ? Setting{0x1018, static_cast<std::uint8_t>(link.product_known ? 3 : 2), 4, 0}
                                      : setting(sdo_what_, params);
    if (reads_) {
      busy_ = sdo_.upload(id, asked_.index, asked_.sub);
    } else {
      std::array<std::uint8_t, 4> bytes{};
      contract::write_le(bytes.data(), bytes.size(), asked_.word);
      busy_ = sdo_.download(id, asked_.index, asked_.sub, std::span(bytes).first(asked_.bytes));
    }
    if (const auto frame = sdo_.step(time_ns_)) send(out, *frame);
  }

  std::array<Link, contract::kRemoteNodeCount> links_{};
  std::size_t turn_ = 0, sdo_what_ = 0;
  contract::Node sdo_node_ = contract::Node::core;
  Setting asked_{};
  Sdo sdo_{{.answer_ns = kAnswer_ns, .tries = 1, .pace_ns = 0}};  // one request leaves per step; tries are counted here
  std::uint64_t time_ns_ = 0;                                     // of the steps
  std::uint8_t sdo_tries_ = 0;
  bool busy_ = false, reads_ = false, all_running_ = false, hands_off_ = false;
};

}  // namespace hoist::core
