// Random commands and frames (hazards H28, H30): no motion, no crash, no non-finite output.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "control/core/modes/mode_list.hpp"
#include "control/core/serve/commands.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

bool same_params(const contract::Params& a, const contract::Params& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

TEST(Hostile, AHundredThousandRandomCommandsChangeNothing) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const contract::Params before = hoist.state.params;
  const auto lease = hoist.state.lease;
  std::mt19937_64 random(42);
  std::uint32_t sent = 0;
  const auto refused_before = hoist.state.commands_refused;
  while (sent < 100'000) {
    for (int i = 0; i < 60; ++i) {
      contract::Command c;
      std::uint64_t words[8];
      for (auto& w : words) w = random();
      std::memcpy(static_cast<void*>(&c), words, sizeof c);
      // One in two has a kind that exists; STOP is left out, because that one is never refused.
      if (i % 2 == 0) c.kind = static_cast<CommandKind>(2 + random() % 11);
      if (c.kind == CommandKind::stop) c.kind = CommandKind::none;
      hoist.commands.push_back(c);
      ++sent;
    }
    std::uint64_t words[6];
    for (auto& w : words) w = random();
    std::memcpy(static_cast<void*>(&hoist.drive_command), words, sizeof hoist.drive_command);
    hoist.drive_fresh = true;
    hoist.step();
    hoist.events.clear();
    ASSERT_EQ(hoist.state.mode, Mode::standby);
    ASSERT_EQ(hoist.command_m_s(), 0.0);
  }
  EXPECT_TRUE(same_params(hoist.state.params, before));
  EXPECT_EQ(hoist.state.lease.holder, lease.holder);
  EXPECT_EQ(hoist.state.lease.epoch, lease.epoch);
  EXPECT_GE(hoist.state.commands_refused - refused_before, sent) << "each one is counted";
  EXPECT_FALSE(hoist.ever_not_finite);
}

TEST(Hostile, InOrderCommandsWithRandomContentNeitherMoveNorBreakTheRanges) {
  std::mt19937_64 random(7);
  for (int run = 0; run < 20; ++run) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    for (int i = 0; i < 2000; ++i) {
      contract::Command c;
      std::uint64_t words[8];
      for (auto& w : words) w = random();
      std::memcpy(static_cast<void*>(&c), words, sizeof c);
      c.sequence = ++hoist.sequence;
      c.kind = static_cast<CommandKind>(2 + random() % 11);
      c.client = static_cast<std::uint32_t>(random() % 3);  // 7 holds the lease
      c.a %= 100;
      c.b %= 3;
      hoist.commands.push_back(c);
      hoist.step();
      ASSERT_FALSE(is_moving(hoist.state.mode));
      for (std::size_t p = 0; p < contract::kParamCount; ++p)
        ASSERT_EQ(contract::check_param(p, contract::get_param(hoist.state.params, p)), contract::ParamCheck::ok);
      ASSERT_EQ(contract::check_param_set(hoist.state.params), nullptr);
    }
    EXPECT_FALSE(hoist.ever_not_finite);
  }
}

TEST(Hostile, ReplayedAndReorderedCommandsAreRefused) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  contract::Command c;
  c.kind = CommandKind::release_lease;
  c.client = 7;
  c.request_id = 901;
  c.sequence = hoist.sequence;  // seen before
  hoist.commands.push_back(c);
  hoist.step();
  EXPECT_EQ(hoist.answer(901), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(hoist.state.lease.holder, 7U);
  c.sequence = hoist.sequence + 5;  // some were lost: this one is refused, and the order continues from it
  c.request_id = 902;
  hoist.commands.push_back(c);
  hoist.step();
  EXPECT_EQ(hoist.answer(902), refusal_bit(Refusal::out_of_order));
  c.sequence = hoist.sequence + 2;  // and never back
  c.request_id = 903;
  hoist.commands.push_back(c);
  hoist.step();
  EXPECT_EQ(hoist.answer(903), refusal_bit(Refusal::out_of_order));
  hoist.sequence += 5;
  EXPECT_EQ(hoist.ask(CommandKind::release_lease), 0U);
}

TEST(Hostile, StopWorksEvenOutOfOrderAndInAFlood) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 500; ++i) {
    contract::Command c;
    c.sequence = 1;
    c.kind = i == 499 ? CommandKind::stop : CommandKind::set_neutral;
    hoist.commands.push_back(c);
  }
  hoist.step();
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

// A server without sense for 200 s: as many commands in each step as the ring and the loop can bring, most of them valid. Each has one answer, each
// row of a set that is in force one event, and after a STOP the hoist does not move.
TEST(Hostile, NoAnswerIsLostWhateverIsSentForHowLong) {
  constexpr std::array kKinds{CommandKind::stage_parameter,
                              CommandKind::stage_parameter,
                              CommandKind::stage_parameter,
                              CommandKind::commit_parameters,
                              CommandKind::revert_parameters,
                              CommandKind::confirm_parameters,
                              CommandKind::set_neutral,
                              CommandKind::take_lease,
                              CommandKind::release_lease,
                              CommandKind::request_mode,
                              CommandKind::acknowledge,
                              CommandKind::set_pose,
                              CommandKind::pause_alarm,
                              CommandKind::begin_calibration,
                              CommandKind::cancel_calibration,
                              CommandKind::begin_guided,
                              CommandKind::none};
  std::mt19937_64 random(17);
  const auto below = [&](std::uint64_t n) { return static_cast<std::uint32_t>(random() % n); };
  for (int run = 0; run < 20; ++run) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(run % 2 == 0 ? Mode::user : Mode::remote));
    std::map<std::uint32_t, std::uint32_t> rows, changed;  // by request: of its set
    std::map<std::uint32_t, int> answers;
    std::uint32_t staged = 0;
    int most = 0;
    for (int i = 0; i < 1000; ++i) {
      const bool quiet = below(3) == 0;  // lets the hoist come to standby, and trials run out
      const CommandKind often = kKinds[below(kKinds.size())];
      bool stop = false;
      for (std::uint32_t k = 0, n = quiet ? below(3) : below(kCommandsPerTick + 1); k < n; ++k) {
        const CommandKind kind = below(900) == 0 ? CommandKind::stop : below(10) < 9 ? often : kKinds[below(kKinds.size())];
        stop |= kind == CommandKind::stop;
        const bool stages = kind == CommandKind::stage_parameter, commits = kind == CommandKind::commit_parameters;
        if (stages && staged == contract::kParamCount) continue;
        const contract::ParamInfo& info = contract::kParams[stages ? staged : 0];
        const std::uint32_t a = stages    ? info.id
                                : commits ? staged
                                          : below(kind == CommandKind::request_mode ? contract::kModes.size() : 2);
        const double v0 = stages ? info.default_value : commits ? 2.0 * below(2) : kind == CommandKind::set_neutral ? 1.0 : 0.0;
        const std::uint32_t id = hoist.send(kind, 7, a, stages ? staged++ : 2, v0);
        answers[id] = 0;
        if (commits) rows[id] = std::exchange(staged, 0);
      }
      const std::size_t before = hoist.events.size();
      hoist.step();
      most = std::max(most, static_cast<int>(hoist.events.size() - before));
      ASSERT_FALSE(stop && is_moving(hoist.state.mode)) << "step " << i << " of run " << run;
    }
    hoist.step(100);
    for (const contract::Event& e : hoist.events) {
      if (e.kind == EventKind::command_done || e.kind == EventKind::command_refused) ++answers[e.request_id];
      if (e.kind == EventKind::parameter_changed && rows.count(e.request_id) != 0) ++changed[e.request_id];
    }
    ASSERT_EQ(hoist.state.events.dropped(), 0U);
    for (const auto& [id, count] : answers) ASSERT_TRUE(id == 0 || count == 1) << "request " << id << " of run " << run << ": " << count;
    for (const auto& [id, n] : rows) ASSERT_TRUE(hoist.answer(id) != 0 || changed[id] == n) << changed[id] << " of " << n;
    EXPECT_GT(most, 100);
  }
}

// The step's own events have taken any part of their share: what else is asked is refused as busy where its answers might not fit; a STOP acts.
TEST(Hostile, AFullStepRefusesAsBusyAndStillStops) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  constexpr auto kMost = static_cast<std::uint32_t>(kCommandsPerTick);
  int busy = 0, done = 0;
  for (std::size_t told = 0; told <= kOwnEventsMost; ++told) {
    CoreState state = hoist.state;
    EventSink::List events;
    events.clear();
    for (std::size_t i = 0; i < told; ++i) static_cast<void>(events.push_back({}));
    state.events.begin(events);
    std::vector<contract::Command> commands(kMost);
    for (std::uint32_t i = 0; i < kMost; ++i) {
      contract::Command& c = commands[i];
      c.sequence = state.next_sequence + i;
      c.kind = i + 1 == kMost ? CommandKind::stop : CommandKind::set_pose;
      c.request_id = 1000 + i;
      c.client = 7;
    }
    take_commands(state, commands);
    EXPECT_EQ(state.events.dropped(), 0U);
    EXPECT_EQ(state.mode, Mode::protective_stop);
    EXPECT_GE(state.events.room(), kEventsAfterCommands - 3) << "for the rest of the step";
    std::uint32_t next = 1000;
    for (const contract::Event& e : events) {
      if (e.kind != EventKind::command_done && e.kind != EventKind::command_refused) continue;
      ASSERT_EQ(e.request_id, next++);
      busy += e.bits == refusal_bit(Refusal::busy) ? 1 : 0;
      done += e.kind == EventKind::command_done ? 1 : 0;
    }
    ASSERT_EQ(next, 1000 + kMost);
  }
  EXPECT_GT(busy, 100);
  EXPECT_GT(done, 100);
}

// After the server was lost the first command sets the count. An old one that arrives then must not prevent the end of the motion.
TEST(Hostile, ARequestForStandbyIsDoneInAnyOrder) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.state.next_sequence = 5000;  // as an old command would set it
  contract::Command c;
  c.sequence = 3;
  c.kind = CommandKind::request_mode;
  c.a = static_cast<std::uint32_t>(Mode::standby);
  c.client = 7;
  c.lease_epoch = hoist.state.lease.epoch;
  c.request_id = 902;
  hoist.commands.push_back(c);
  hoist.step();
  EXPECT_EQ(hoist.answer(902), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby, 300));
  EXPECT_EQ(hoist.state.next_sequence, 5000U) << "and the count stays";
  c.a = static_cast<std::uint32_t>(Mode::user);
  c.request_id = 903;
  hoist.commands.push_back(c);
  hoist.step();
  EXPECT_NE(hoist.answer(903) & refusal_bit(Refusal::out_of_order), 0U) << "nothing that moves";
}

TEST(Hostile, RandomFramesNeverCrashMoveOrLeakANumberThatIsNone) {
  std::mt19937_64 random(99);
  for (const Mode mode : {Mode::standby, Mode::user, Mode::remote}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(mode == Mode::standby ? hoist.ready() : hoist.start(mode));
    for (int i = 0; i < 3000; ++i) {
      for (int k = 0; k < 10; ++k) {
        contract::CanFrame f;
        f.id = static_cast<std::uint32_t>(random() % (k % 3 == 0 ? 0x20000000ULL : 0x800ULL));
        f.dlc = static_cast<std::uint8_t>(random() % 17);
        f.flags = static_cast<std::uint8_t>(k % 5 == 0 ? random() % 8 : 0);
        const std::uint64_t bytes = random();
        std::memcpy(f.data.data(), &bytes, 8);
        hoist.extra.push_back(f);
      }
      const double before = hoist.state.limiter.speed_m_s();
      hoist.step();
      hoist.events.clear();
      ASSERT_LE(std::abs(hoist.state.limiter.speed_m_s() - before), 1.5 * kTick_s + 1e-9);
      if (mode == Mode::standby) {
        ASSERT_EQ(hoist.command_m_s(), 0.0);
      }
    }
    EXPECT_FALSE(hoist.ever_not_finite);
    EXPECT_GT(hoist.out.record.bus_refused, 10000U);
  }
}

TEST(Hostile, FramesThatAreNotOursAreCounted) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto refused = hoist.out.record.bus_refused;
  contract::CanFrame short_tilt{0x191, 5, 0, {}}, remote{0x191, 6, contract::CanFrame::kRemote, {}},
      extended{0x191, 6, contract::CanFrame::kExtended, {}}, stranger{0x1A5, 8, 0, {}}, as_core{0x77F, 1, 0, {5}}, order{0x201, 6, 0, {}},
      unasked = contract::canopen::sdo(0x581, 0x60, 0x2200, 1, 0), state{0x711, 1, 0, {42}};
  for (const auto& f : {short_tilt, remote, extended, stranger, as_core, order, unasked, state}) hoist.extra.push_back(f);
  hoist.step();
  EXPECT_EQ(hoist.out.record.bus_refused, refused + 8);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

TEST(Hostile, APositionThatJumpsIsNotDriven) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const float x = hoist.out.record.x_m;
  hoist.drive_left.counts += 1e6;
  hoist.drive_right.counts += 1e6;
  hoist.step(3);
  EXPECT_FLOAT_EQ(hoist.out.record.x_m, x);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

TEST(Hostile, ThePositionMayWrapAround) {
  ScriptedHoist hoist;
  hoist.drive_left.counts = hoist.drive_right.counts = 2147483647.0 - 5000.0;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(400, 1.0);
  EXPECT_LT(hoist.out.record.left_counts, 0) << "past 2^31";
  EXPECT_NEAR(hoist.out.record.x_m, 4 * 0.3 - 0.3 * 0.3, 0.2);
  EXPECT_EQ(hoist.state.mode, Mode::remote);
}

TEST(Hostile, SameInputsGiveTheSameBytes) {
  ScriptedHoist a, b;
  for (ScriptedHoist* h : {&a, &b}) {
    ASSERT_TRUE(h->start(Mode::user));
    h->lean_gently(6, 300);
  }
  EXPECT_EQ(std::memcmp(&a.out.record, &b.out.record, sizeof a.out.record), 0);
}

}  // namespace
}  // namespace hoist::core::test
