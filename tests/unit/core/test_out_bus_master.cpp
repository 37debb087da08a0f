// Finding, asking, configuring and starting the nodes: the rules of control/core/output/bus_master.hpp, written a second time from their
// description. Nodes that die, refuse, answer late, wrongly or never: the master sends just these frames and thinks just this of each.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "control/core/output/bus_master.hpp"

namespace hoist::core::test::out_bus_master {
namespace {

using contract::CanFrame;
using contract::Node;
using contract::NodeKind;
using contract::Params;
using contract::Pdo;
namespace canopen = contract::canopen;
using Phase = BusMaster::Phase;

constexpr std::size_t kNodes = 6;
constexpr std::array<std::uint32_t, kNodes> kIds{0x01, 0x02, 0x08, 0x11, 0x12, 0x13};
constexpr std::array kKinds{NodeKind::drive, NodeKind::drive, NodeKind::io, NodeKind::tilt, NodeKind::tilt, NodeKind::tilt};

// The values that a node is set, in their order: parameters that live in it, which are written; then what must be as its guards take it, which is
// read, and written when it differs. What was written is read back.
struct Value {
  NodeKind kind;
  std::uint32_t index, sub;
  double Params::*field;
  std::uint32_t command = 0x23, word = 0;
};
constexpr std::array kValues{Value{NodeKind::drive, 0x2200, 1, &Params::drive_velocity_gain_v_s_rad},
                             Value{NodeKind::drive, 0x2200, 2, &Params::drive_velocity_integral_v_rad},
                             Value{NodeKind::drive, 0x2200, 5, &Params::drive_current_limit_a},
                             Value{NodeKind::drive, 0x6083, 0, &Params::drive_acceleration_rad_s2},
                             Value{NodeKind::tilt, 0x2102, 1, &Params::tilt_kalman_angle_norm},
                             Value{NodeKind::tilt, 0x2102, 2, &Params::tilt_kalman_bias_per_s},
                             // 0.25 s of the computer's heartbeat; 4 ms; 32 V; brake, then switch off; 1 m/s2 at the wheel; all outputs off
                             Value{NodeKind::drive, 0x1016, 1, nullptr, 0x23, 0x007F00FA},
                             Value{NodeKind::drive, 0x2200, 4, nullptr, 0x23, std::bit_cast<std::uint32_t>(0.004F)},
                             Value{NodeKind::drive, 0x2231, 1, nullptr, 0x23, std::bit_cast<std::uint32_t>(32.0F)},
                             Value{NodeKind::drive, 0x605A, 0, nullptr, 0x2B, 2}, Value{NodeKind::drive, 0x6085, 0, nullptr, 0x23, 300},
                             Value{NodeKind::io, 0x1016, 1, nullptr, 0x23, 0x007F00FA}, Value{NodeKind::io, 0x6206, 1, nullptr, 0x2F, 255},
                             Value{NodeKind::io, 0x6207, 1, nullptr, 0x2F, 0}};
static_assert(kValues.size() == contract::kParamObjects.size() + contract::kKeptObjects.size());

CanFrame sdo(std::uint32_t id, std::uint32_t command, std::uint32_t index, std::uint32_t sub, std::uint32_t value) {
  CanFrame frame{id, 8, 0, {}};
  const std::array<std::uint32_t, 8> bytes{command, index, index >> 8, sub, value, value >> 8, value >> 16, value >> 24};
  for (std::size_t i = 0; i < 8; ++i) frame.data[i] = static_cast<std::uint8_t>(bytes[i]);
  return frame;
}
CanFrame nmt(std::uint32_t command, std::uint32_t id) {
  return {0, 2, 0, {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(id)}};
}
std::uint32_t word_of(const CanFrame& frame) { return contract::read_le(&frame.data[4], 4); }

enum class What : std::uint8_t { product, revision, serial, write, read };

struct NodeRule {
  Phase phase = Phase::absent;
  int state = 255, age_steps = 255, rest_steps = 0, start_steps = 0;
  std::uint32_t product = 0, revision = 0, serial = 0;
  bool product_known = false, serial_known = false;
  std::set<std::size_t> unwritten, untold;

  [[nodiscard]] bool other_version() const { return revision / 0x10000 != 3; }
  [[nodiscard]] bool silent() const { return age_steps >= 25; }
  [[nodiscard]] bool settled() const { return unwritten.empty() && untold.empty(); }
  // A simulated node has no number.
  [[nodiscard]] bool number_wanted() const { return !serial_known && product < 0x80000000U; }
  void identify() {
    phase = Phase::identify;
    product_known = false;
    rest_steps = 0;
  }
  // A second of rest, then from the start; one that runs gets the refused value again.
  void rest() {
    if (phase != Phase::running) phase = Phase::absent;
    rest_steps = 100;
  }
};

struct Request {
  std::size_t node = 0, value = 0;
  What what = What::product;
  int tries = 0;
  std::uint64_t sent_step = 0;
  bool wrong = false;      // answered as no node does: asked again in the next step
  std::uint32_t word = 0;  // of a value

  [[nodiscard]] bool of_value() const { return what == What::write || what == What::read; }
  [[nodiscard]] std::uint32_t index() const { return of_value() ? kValues[value].index : 0x1018; }
  [[nodiscard]] std::uint32_t sub() const {
    return of_value() ? kValues[value].sub : what == What::product ? 2U : what == What::revision ? 3U : 4U;
  }
  // Of an upload's answer: words of four, two or one byte have 43h, 4Bh and 4Fh, as 23h, 2Bh and 2Fh write them.
  [[nodiscard]] std::uint32_t told_by() const { return of_value() ? kValues[value].command + 0x20 : 0x43; }
};

struct MasterRule {
  std::array<NodeRule, kNodes> nodes;
  std::optional<Request> asked;
  std::size_t turn = 0;
  std::uint64_t step_number = 0;
  bool hands_off = false, all_running = false;
  std::vector<CanFrame> sent;

  void next_tick() {
    for (NodeRule& node : nodes) {
      node.age_steps = std::min(255, node.age_steps + 1);
      node.rest_steps = std::max(0, node.rest_steps - 1);
    }
  }

  bool heartbeat(std::size_t n, std::uint8_t state) {
    NodeRule& node = nodes[n];
    node.age_steps = 0;
    node.state = state;
    if (state == 0 && asked && asked->node == n) asked.reset();
    if (state == 0 || (node.phase == Phase::absent && node.rest_steps == 0 && !hands_off)) node.identify();
    return state == 0;
  }

  bool reply(std::size_t n, const CanFrame& frame) {
    if (hands_off) return true;
    if (!asked || asked->node != n) return false;
    if (asked->wrong) return false;
    const unsigned command = frame.data[0], kind = command / 0x20;
    const bool names_it = frame.data[1] + 256U * frame.data[2] == asked->index() && frame.data[3] == asked->sub();
    const bool names_none = frame.data[1] == 0 && frame.data[2] == 0 && frame.data[3] == 0;
    if (frame.dlc != 8) return wrongly();
    if (command == 0x80) return (names_it || names_none) && refused();
    if (kind == 2 || kind == 3) {
      if (!names_it) return false;
      if (asked->what == What::write) return command == 0x60 ? written() : wrongly();
      if (command != asked->told_by()) return wrongly();
      const std::uint32_t bits = command == 0x4F ? 0xFF : command == 0x4B ? 0xFFFF : 0xFFFFFFFF;
      return told(word_of(frame) & bits);
    }
    return wrongly();
  }
  bool wrongly() {
    asked->wrong = true;
    return false;
  }
  bool refused() {
    NodeRule& node = nodes[asked->node];
    if (asked->what == What::serial) {
      node.serial = 0;  // it has none
      node.serial_known = true;
    } else {
      node.rest();
    }
    asked.reset();
    return true;
  }
  bool written() {
    nodes[asked->node].unwritten.erase(asked->value);
    nodes[asked->node].untold.insert(asked->value);
    asked.reset();
    return true;
  }
  // A serial line has no checksum: what keeps a node from work, and what makes it another part, counts when it was told twice.
  bool told(std::uint32_t word) {
    const std::size_t n = asked->node;
    NodeRule& node = nodes[n];
    const What what = asked->what;
    const std::size_t value = asked->value;
    const bool as_set = word == asked->word;
    asked.reset();
    if (what == What::read) {
      node.untold.erase(value);
      if (!as_set) node.unwritten.insert(value);
    } else if (what == What::product) {
      const bool twice = node.product == word;
      node.product = word;
      const bool loader = (word & 0x40000000U) != 0;
      if (!loader) node.product_known = true;
      if (loader && twice) {
        node.phase = Phase::absent;
        node.rest_steps = 9000;
      }
    } else if (what == What::revision) {
      const bool twice = node.revision == word;
      node.revision = word;
      if (node.other_version() && !twice) return true;
      node.serial_known = false;
      node.unwritten.clear();
      node.untold.clear();
      for (std::size_t i = 0; i < kValues.size(); ++i)
        if (kValues[i].kind == kKinds[n]) (kValues[i].field != nullptr ? node.unwritten : node.untold).insert(i);
      node.phase = Phase::configure;
    } else {
      node.serial_known = node.serial == word;
      node.serial = word;
    }
    return true;
  }

  void params_changed(const Params& before, const Params& now) {
    for (std::size_t i = 0; i < kValues.size(); ++i) {
      if (kValues[i].field == nullptr || before.*kValues[i].field == now.*kValues[i].field) continue;
      for (std::size_t n = 0; n < kNodes; ++n) {
        if (kKinds[n] != kValues[i].kind) continue;
        nodes[n].unwritten.insert(i);
        nodes[n].untold.erase(i);
      }
      all_running = false;
      if (asked && asked->of_value() && asked->value == i) asked.reset();
    }
  }

  void meet_all_again() {
    for (NodeRule& node : nodes) {
      node.phase = Phase::absent;
      node.rest_steps = 0;
    }
    asked.reset();
    all_running = false;
  }

  void step(std::uint64_t tick, const std::array<bool, kNodes>& lives, const Params& params, bool update) {
    sent.clear();
    if (tick % 5 == 0) sent.push_back({0x77F, 1, 0, {5}});
    hands_off = update;
    ++step_number;
    if (update) return meet_all_again();
    all_running = true;
    for (std::size_t n = 0; n < kNodes; ++n) {
      NodeRule& node = nodes[n];
      lead(node, kIds[n], lives[n]);
      all_running = all_running && node.phase == Phase::running && node.settled() && !node.number_wanted();
    }
    if (asked) return wait(params);
    for (std::size_t k = 1; k <= kNodes; ++k) {
      const std::size_t n = (turn + k) % kNodes;
      const NodeRule& node = nodes[n];
      Request next{.node = n};
      if (node.phase == Phase::identify) {
        next.what = node.product_known ? What::revision : What::product;
      } else if ((node.phase == Phase::configure || node.phase == Phase::running) && !node.settled() && node.rest_steps == 0) {
        next.what = node.unwritten.empty() ? What::read : What::write;
        next.value = node.unwritten.empty() ? *node.untold.begin() : *node.unwritten.begin();
      } else if (node.phase == Phase::running && node.rest_steps == 0 && node.number_wanted()) {
        next.what = What::serial;
      } else {
        continue;
      }
      turn = n;
      if (node.state == 4) sent.push_back(nmt(0x80, kIds[n]));  // a stopped node does not answer
      asked = next;
      return ask(params);
    }
  }

  void lead(NodeRule& node, std::uint32_t id, bool lives) {
    switch (node.phase) {
      case Phase::absent:
        break;
      case Phase::identify:
      case Phase::configure:
        if (node.silent()) {
          node.phase = Phase::absent;
        } else if (node.phase == Phase::configure && node.settled()) {
          node.phase = Phase::start;
          node.start_steps = 0;
          sent.push_back(nmt(1, id));
        }
        break;
      case Phase::start:
        // Data of the same step may be older than the start. 0.2 s, then a rest.
        if (node.start_steps > 0 && lives) {
          node.phase = Phase::running;
        } else if (++node.start_steps == 20) {
          node.rest();
        }
        break;
      case Phase::running:
        if (!lives) node.phase = Phase::absent;
        break;
    }
  }

  // Three tries of 0.1 s each.
  void wait(const Params& params) {
    Request& now = *asked;
    if (!now.wrong && step_number - now.sent_step < 10) return;
    if (++now.tries < 3) return ask(params);
    nodes[now.node].rest();
    asked.reset();
  }

  void ask(const Params& params) {
    Request& now = *asked;
    now.wrong = false;
    now.sent_step = step_number;
    // The identity goes on with what is known by now.
    if (now.what == What::product || now.what == What::revision) now.what = nodes[now.node].product_known ? What::revision : What::product;
    const std::uint32_t to = 0x600 + kIds[now.node];
    if (now.of_value()) now.word = value_word(now.value, params);
    if (now.what != What::write) {
      sent.push_back(sdo(to, 0x40, now.index(), now.sub(), 0));
      return;
    }
    sent.push_back(sdo(to, kValues[now.value].command, now.index(), now.sub(), now.word));
  }

  // As it is now: a gain may ramp.
  static std::uint32_t value_word(std::size_t value, const Params& params) {
    if (kValues[value].field == nullptr) return kValues[value].word;
    const double now = params.*kValues[value].field;
    return kValues[value].index == 0x6083 ? static_cast<std::uint32_t>(std::lround(now))
                                          : std::bit_cast<std::uint32_t>(static_cast<float>(now));
  }
};

// A node as it may be: what it says, and what is wrong with it.
struct FakeNode {
  bool on = false, beats_always = false, stops_data = false, deaf = false, refuses_number = false, starts_not = false;
  std::uint8_t state = 127;
  std::uint32_t product = 0, revision = 0x00030000, serial = 0;
  int refuses = -1;  // this value
  std::array<std::uint32_t, kValues.size()> words{};
  int odd_percent = 0;  // of its answers
  int beat_late = 0;    // steps
};

struct Reply {
  std::uint64_t step;
  std::size_t node;
  CanFrame frame;
};

struct Bench {
  explicit Bench(unsigned seed) : random(seed) {}

  std::mt19937 random;
  BusMaster master;
  MasterRule rule;
  std::array<FakeNode, kNodes> nodes;
  Estimate sensed;
  std::array<int, kNodes> heard_steps{};  // since its data came
  Params params;
  std::vector<Reply> replies;
  std::uint64_t step_number = 0;
  int update_left = 0;

  std::uint64_t below(std::uint64_t n) { return random() % n; }

  void renew(std::size_t n) {
    CanFrame frame{0, 8, 0, {}};
    const NodeRow& row = kNodeRows[n];
    if (row.drive != nullptr) static_cast<void>((sensed.*row.drive).take_state(frame, 1e9));
    if (row.io != nullptr) (sensed.*row.io).take_inputs(frame);
    if (row.tilt != nullptr) (sensed.*row.tilt).take_angles(frame);
    heard_steps[n] = 0;
  }

  void boot(std::size_t n) {
    nodes[n].on = true;
    nodes[n].state = 127;
    ASSERT_TRUE(master.take_heartbeat(static_cast<Node>(n), 0));
    ASSERT_TRUE(rule.heartbeat(n, 0));
  }
  void beat(std::size_t n) {
    ASSERT_FALSE(master.take_heartbeat(static_cast<Node>(n), nodes[n].state));
    ASSERT_FALSE(rule.heartbeat(n, nodes[n].state));
  }
  void deliver(std::size_t n, const CanFrame& frame) {
    const bool counts = rule.reply(n, frame);
    ASSERT_EQ(master.take_sdo_reply(static_cast<Node>(n), frame), counts) << step_number << ": node " << n << ", " << int{frame.data[0]};
  }

  void begin_step() {
    ++step_number;
    master.next_tick();
    rule.next_tick();
    sensed.next_tick();
    for (std::size_t n = 0; n < kNodes; ++n) {
      FakeNode& node = nodes[n];
      ++heard_steps[n];
      if (!node.on) continue;
      if (node.beats_always || (step_number + n) % 10 == static_cast<std::uint64_t>(node.beat_late)) beat(n);
      if (node.state == 5 && !node.stops_data) renew(n);
    }
    const std::vector<Reply> due = replies;
    replies.clear();
    for (const Reply& reply : due) {
      if (reply.step > step_number) {
        replies.push_back(reply);
      } else {
        deliver(reply.node, reply.frame);
      }
    }
  }

  void end_step() {
    std::array<bool, kNodes> lives{};
    for (std::size_t n = 0; n < kNodes; ++n) lives[n] = heard_steps[n] < 5;
    FixedVector<CanFrame, 16> out;
    const bool update = update_left > 0;
    if (update) --update_left;
    master.step(step_number, sensed, params, update, out);
    rule.step(step_number, lives, params, update);
    ASSERT_EQ(out.size(), rule.sent.size()) << step_number;
    for (std::size_t i = 0; i < out.size(); ++i) ASSERT_TRUE(out[i] == rule.sent[i]) << step_number << ": frame " << i;
    for (const CanFrame& frame : rule.sent) take(frame);
    compare();
  }

  void compare() {
    std::uint32_t id = 2166136261U;
    bool other_version = false, simulated = false;
    for (std::size_t n = 0; n < kNodes; ++n) {
      const auto node = static_cast<Node>(n);
      const NodeRule& one = rule.nodes[n];
      ASSERT_EQ(master.phase(node), one.phase) << step_number << ": node " << n;
      ASSERT_EQ(int{master.nmt_state(node)}, one.state);
      // One each 100 ms, 30 ms late at most.
      ASSERT_EQ(int{master.heartbeats_missed(node)}, one.age_steps < 3 ? 0 : (one.age_steps - 3) / 10) << step_number << ": node " << n;
      for (std::uint32_t byte = 0, serial = one.serial; byte < 4; ++byte, serial /= 256) id = (id ^ serial % 256) * 16777619U;
      other_version = other_version ||
                      ((one.phase == Phase::configure || one.phase == Phase::start || one.phase == Phase::running) && one.other_version());
      simulated = simulated || one.product >= 0x80000000U;
    }
    ASSERT_EQ(master.nodes_id(), id == 0 ? 1 : id) << step_number;
    ASSERT_EQ(master.all_running(), rule.all_running) << step_number;
    ASSERT_EQ(master.any_other_version(), other_version) << step_number;
    ASSERT_EQ(master.simulated(), simulated) << step_number;
  }

  // A node gets a frame.
  void take(const CanFrame& frame) {
    for (std::size_t n = 0; n < kNodes; ++n) {
      FakeNode& node = nodes[n];
      if (!node.on) continue;
      if (frame.id == 0 && frame.data[1] == kIds[n]) {
        if (frame.data[0] == 0x80) node.state = 127;
        if (frame.data[0] == 1 && !node.starts_not && (node.product & 0x40000000U) == 0) node.state = 5;
      }
      if (frame.id == 0x600 + kIds[n] && !node.deaf && node.state != 4) answer(n, frame);
    }
  }

  void answer(std::size_t n, const CanFrame& request) {
    FakeNode& node = nodes[n];
    const unsigned command = request.data[0];
    const std::uint32_t index = request.data[1] + 256U * request.data[2], sub = request.data[3], from = 0x580 + kIds[n];
    CanFrame reply = sdo(from, 0x60, index, sub, 0);
    bool refuses = false;
    if (const auto value = std::find_if(kValues.begin(), kValues.end(),
                                        [&](const Value& v) { return v.kind == kKinds[n] && v.index == index && v.sub == sub; });
        value != kValues.end()) {
      std::uint32_t& word = node.words[static_cast<std::size_t>(value - kValues.begin())];
      if (command == 0x40) {
        reply = sdo(from, value->command + 0x20, index, sub, word);
      } else {
        // A line that damages the value: confirmed like any other.
        word = word_of(request) ^ (odd(node) ? 1U << below(8) : 0U);
      }
      refuses = node.refuses >= 0 && value == kValues.begin() + node.refuses;
    } else if (command == 0x40) {
      const std::uint32_t word = sub == 2 ? node.product : sub == 3 ? node.revision : node.serial;
      refuses = sub == 4 && node.refuses_number;
      reply = sdo(from, 0x43, index, sub, word);
      if (odd(node)) reply = sdo(from, 0x41, index, sub, 4);
    }
    if (refuses) reply = sdo(from, 0x80, index, sub, 0x06090030);
    if (odd(node)) {
      switch (below(12)) {
        case 0:
          reply = sdo(from, 0x80, 0, 0, 0x08000000);
          break;
        case 1:
          reply = sdo(from, 0x80, index ^ 1, sub, 0x08000000);
          break;
        case 2:
          reply = sdo(from, 0x80, index, sub + 1, 0x08000000);
          break;
        case 3:
          reply.data[3] ^= 1;
          break;
        case 4:
          reply.data[2] ^= 1;
          break;
        case 5:
          reply.dlc = 7;
          break;
        case 6:
          reply.data[0] = 0x4B;
          break;
        case 7:
          reply.data[0] = command == 0x40 ? 0x60 : 0x43;
          break;
        case 8:
          reply = sdo(from, 0x41, index, sub, 5);
          break;
        case 9:
          reply.data[0] = 0x03;
          break;
        case 10:
          contract::write_le(&reply.data[4], 4, static_cast<std::uint32_t>(random()));
          break;
        default:
          return;
      }
    }
    replies.push_back({step_number + 1 + (odd(node) ? below(13) : 0), n, reply});
  }
  bool odd(const FakeNode& node) { return below(100) < static_cast<std::uint64_t>(node.odd_percent); }

  // Something happens to a node, to the settings or to the master.
  void disturb() {
    const std::size_t n = below(kNodes);
    FakeNode& node = nodes[n];
    switch (below(22)) {
      case 0:
        node.on = false;
        break;
      case 1:
      case 2:
        boot(n);
        break;
      case 3:
        node.state = 4;
        break;
      case 4:
        node.deaf = below(2) == 0;
        break;
      case 5:
        node.refuses = below(2) == 0 ? -1 : static_cast<int>(below(kValues.size()));
        break;
      case 6:
        node.revision = below(3) == 0 ? 0x00020001 : 0x00030000 + static_cast<std::uint32_t>(below(3));
        break;
      case 7:
        node.product ^= below(2) == 0 ? 0x40000000U : 0x80000000U;
        break;
      case 8:
        node.serial = static_cast<std::uint32_t>(random());
        break;
      case 9:
        node.refuses_number = !node.refuses_number;
        break;
      case 10:
        node.starts_not = below(3) == 0;
        break;
      case 11:
        node.stops_data = below(2) == 0;
        break;
      case 12:
        node.beat_late = below(2) == 0 ? static_cast<int>(below(10)) : 99;
        break;
      case 13:
        update_left = static_cast<int>(1 + below(60));
        break;
      case 14:
        master.meet_all_again();
        rule.meet_all_again();
        break;
      case 15:
        for (FakeNode& each : nodes) each.odd_percent = static_cast<int>(below(4) == 0 ? below(40) : below(4));
        break;
      case 16:
        deliver(n, sdo(0x580 + kIds[n], below(2) == 0 ? 0x43 : 0x60, 0x1018, 2, 3));
        break;
      case 17:
        ramp();
        break;
      case 18:
        change();
        break;
      default:
        // Most troubles end.
        node = {.on = true, .state = 127, .product = node.product & 0x80000000U, .serial = node.serial};
        boot(n);
        break;
    }
  }
  // A request that is under way becomes outdated, or is never answered.
  void interrupt() {
    const std::uint64_t what = below(6);
    if (what == 0) {
      nodes[rule.asked->node].on = false;
    } else if (what < 3) {
      boot(rule.asked->node);
    } else {
      change();
    }
  }
  // A gain on its way.
  void ramp() {
    for (const Value& value : kValues)
      if (value.field != nullptr) params.*value.field *= 1.01;
  }
  void change() {
    const Params before = params;
    for (const Value& value : kValues)
      if (value.field != nullptr && below(3) == 0) params.*value.field *= below(2) == 0 ? 1.5 : 0.7;
    // What lives in the core is written to no node.
    for (std::size_t row = 0; row < contract::kParams.size(); ++row) {
      const bool in_node =
          std::any_of(kValues.begin(), kValues.end(), [&](const Value& one) { return one.field == contract::kParams[row].field; });
      if (!in_node) contract::set_param_unchecked(params, row, contract::get_param(params, row) + 1);
    }
    master.params_changed(before, params);
    rule.params_changed(before, params);
    ASSERT_EQ(master.all_running(), rule.all_running);  // a start of this step must wait, too
  }
};

TEST(OutBusMaster, H3EachStepSendsAndKnowsWhatTheRulesSay) {
  int all_running = 0, other_version = 0, gave_up = 0;
  std::array<int, 5> phases{};
  for (unsigned seed = 1; seed <= 45; ++seed) {
    SCOPED_TRACE(seed);
    Bench bench(seed);
    for (FakeNode& node : bench.nodes) {
      node.on = bench.below(8) != 0;
      node.product = seed % 3 == 0 ? 0x80000000U : 5U;
      node.serial = static_cast<std::uint32_t>(bench.random());
      node.odd_percent = seed % 4 == 0 ? 30 : seed % 2 == 0 ? 2 : 0;
    }
    const std::uint64_t calm = seed % 5 == 0 ? 200 : 40;
    const int quiet = seed % 2 == 0 ? 150 : 5;
    for (int i = 0; i < 700; ++i) {
      bench.begin_step();
      if (i > quiet && bench.below(calm) == 0) bench.disturb();
      if (i > quiet && bench.rule.asked && bench.below(40) == 0) bench.interrupt();
      bench.end_step();
      if (testing::Test::HasFatalFailure()) return;
      all_running += bench.rule.all_running ? 1 : 0;
      other_version += bench.master.any_other_version() ? 1 : 0;
      for (const NodeRule& node : bench.rule.nodes) {
        ++phases[static_cast<std::size_t>(node.phase)];
        gave_up += node.rest_steps == 100 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(all_running, 1000);
  EXPECT_GT(other_version, 100);
  EXPECT_GT(gave_up, 30);
  for (const int steps : phases) EXPECT_GT(steps, 500);
}

// A node in its loader is asked again after a minute and a half, which leaves it the minute that it waits.
TEST(OutBusMaster, ALoaderIsLeftAloneForAMinuteAndAHalf) {
  Bench bench(1);
  for (FakeNode& node : bench.nodes) node.on = true;
  bench.nodes[3].product = 0x40000005;
  bench.nodes[3].beats_always = true;
  for (int i = 0; i < 9200; ++i) {
    if (i == 8900) bench.nodes[3].product = 5;
    bench.begin_step();
    bench.end_step();
    if (HasFatalFailure()) return;
    ASSERT_FALSE(bench.rule.all_running && i < 9000) << i;
  }
  EXPECT_TRUE(bench.rule.all_running);
}

// 0 stands for parts that were never checked.
TEST(OutBusMaster, H2NoSetOfPartsHasTheNumberOfNone) {
  Bench bench(1);
  constexpr std::array<std::uint32_t, kNodes> kSerials{1, 2, 3, 4, 5, 0x057B8B41};
  for (std::size_t n = 0; n < kNodes; ++n) {
    bench.nodes[n].on = true;
    bench.nodes[n].serial = kSerials[n];
  }
  for (int i = 0; i < 300; ++i) {
    bench.begin_step();
    bench.end_step();
    if (HasFatalFailure()) return;
  }
  EXPECT_TRUE(bench.rule.all_running);
  EXPECT_EQ(bench.master.nodes_id(), 1U);
}

}  // namespace
}  // namespace hoist::core::test::out_bus_master
