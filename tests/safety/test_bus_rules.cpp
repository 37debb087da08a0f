// The monitors of nodes, bus, inputs and loop against their rules (monitor_bench.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "tests/safety/monitor_bench.hpp"

namespace hoist::core::test {
namespace {

// ----- the six node_lost, bus_down

TEST(NodeLostRule, H3H4H14EachStepOfRandomlySilentNodesIsJudgedByTheRule) {
  using contract::Node;
  std::array<int, 6> found{};
  int down_steps = 0, battery_steps = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    std::tuple<NodeLost<Node::drive_left>, NodeLost<Node::drive_right>, NodeLost<Node::io>, NodeLost<Node::tilt_left>,
               NodeLost<Node::tilt_right>, NodeLost<Node::tilt_base>>
        monitors;
    BusDown bus_down;
    std::vector<Spells<bool>> silent(6, Spells<bool>(random, 12, {false, false, true}));
    Spells<bool> all_silent(random, 60, {false, false, false, false, false, false, false, true});
    Spells<bool> rates_silent(random, 12, {false, false, true}), batteries_silent(random, 500, {false, true});
    Spells<bool> up(random, 200, {true, true, true, true, false}), settled(random, 200, {true, true, true, true, false});
    Spells<Mode> mode(random, 300, {Mode::user, Mode::standby, Mode::init});
    // Steps since each was heard; never at first.
    std::array<int, 6> age{255, 255, 255, 255, 255, 255};
    int rates_age = 255, batteries_age = -1;
    for (int i = 0; i < 1200; ++i) {
      SCOPED_TRACE(i);
      Estimate& sensed = bench.sensed;
      sensed.next_tick();
      const bool none = all_silent.step();
      for (std::size_t n = 0; n < 6; ++n) {
        const bool speaks = !silent[n].step() && !none;
        age[n] = speaks ? 0 : age[n] + 1;
        if (!speaks) continue;
        const auto node = static_cast<Node>(n);
        if (node == Node::drive_left) send_state(sensed.left_drive, 0, 0);
        if (node == Node::drive_right) send_state(sensed.right_drive, 0, 0);
        if (node == Node::io) send_inputs(sensed.io, 0, 0);
        if (node == Node::tilt_left) send_angles(sensed.left_strut, {});
        if (node == Node::tilt_right) send_angles(sensed.right_strut, {});
        if (node == Node::tilt_base) send_angles(sensed.base, {});
      }
      const bool rates = !rates_silent.step();
      rates_age = rates ? 0 : rates_age + 1;
      if (rates) send_rates(sensed.base, {});
      if (batteries_age >= 0) ++batteries_age;
      if (!batteries_silent.step()) {
        send_batteries(sensed.io, 12, 12);
        batteries_age = 0;
      }
      bench.mode = mode.step();
      bench.bus_up = up.step();
      bench.bus_settled = settled.step();
      std::array<bool, 6> expected{};
      for (std::size_t n = 0; n < 6; ++n) expected[n] = age[n] >= 5;
      expected[2] = expected[2] || batteries_age >= 250;
      expected[5] = expected[5] || rates_age >= 5;
      const bool judged = bench.mode != Mode::init, silence = std::all_of(age.begin(), age.end(), [](int ticks) { return ticks >= 5; });
      for (bool& lost : expected) lost = lost && judged && bench.bus_settled;
      const MonitorView view = bench.view();
      const auto checked = std::apply([&view](auto&... monitor) { return std::array{monitor.check(view)...}; }, monitors);
      ASSERT_EQ(checked, expected);
      const bool down = judged && (silence || !bench.bus_up || !bench.bus_settled);
      ASSERT_EQ(bus_down.check(view), down);
      for (std::size_t n = 0; n < 6; ++n) found[n] += expected[n] ? 1 : 0;
      down_steps += silence && judged && bench.bus_up && bench.bus_settled ? 1 : 0;
      battery_steps += batteries_age >= 250 ? 1 : 0;
    }
  }
  for (const int steps : found) EXPECT_GT(steps, 100);
  EXPECT_GT(down_steps, 20);
  EXPECT_GT(battery_steps, 100);
}

// ----- node_babbling, node_duplicate

TEST(BusHealthRules, H30AFullBusAFloodAndASecondComputerAreReportedOutsideInit) {
  struct Case {
    const char* name;
    int own_frames, flood_frames;  // in each step
    bool second_computer, babbles, doubles;
  };
  // 135 bits a frame, 2500 in a step: 17 frames are a load of 0.92, 18 of 0.97.
  for (const Case& one :
       {Case{"quiet", 3, 0, false, false, false}, Case{"nearly full", 17, 0, false, false, false}, Case{"full", 18, 0, false, true, false},
        Case{"a flood", 0, 5, false, true, false}, Case{"a second computer", 1, 0, true, false, true}}) {
    SCOPED_TRACE(one.name);
    MonitorBench bench;
    NodeBabbling babbling;
    NodeDuplicate duplicate;
    const contract::CanFrame own{0x201, 8, 0, {}}, stranger{0x010, 0, 0, {}}, sync{contract::canopen::kSync, 0, 0, {}};
    for (std::uint64_t i = 1; i <= 300; ++i) {
      bench.health.next_tick(i * 10'000'000, true);
      for (int k = 0; k < one.own_frames; ++k) bench.health.sent(own);
      for (int k = 0; k < one.flood_frames; ++k) static_cast<void>(bench.health.take(stranger, contract::classify(stranger)));
      if (one.second_computer && i > 250) static_cast<void>(bench.health.take(sync, contract::classify(sync)));
    }
    for (const Mode mode : {Mode::user, Mode::standby, Mode::init}) {
      bench.mode = mode;
      EXPECT_EQ(babbling.check(bench.view()), one.babbles && mode != Mode::init);
      EXPECT_EQ(duplicate.check(bench.view()), one.doubles && mode != Mode::init);
    }
  }
}

// ----- bumper_pressed

TEST(BumperRule, H13EachPressThatIsNotAcknowledgedIsReportedWhereTheHoistMayMove) {
  MonitorBench bench;
  BumperPressed monitor;
  for (std::uint8_t pressed = 0; pressed < 16; ++pressed) {
    send_inputs(bench.sensed.io, pressed, 0);
    for (std::uint8_t known = 0; known < 16; ++known) {
      bench.bumpers_acknowledged = known;
      bool any_new = false;
      for (int side = 0; side < 4; ++side) any_new = any_new || ((pressed >> side) % 2 == 1 && (known >> side) % 2 == 0);
      for (const auto& mode : contract::kModes) {
        bench.mode = static_cast<Mode>(mode.value);
        const bool expected = any_new && bench.mode != Mode::init && bench.mode != Mode::calibrate;
        ASSERT_EQ(monitor.check(bench.view()), expected) << int{pressed} << " " << int{known} << " " << mode.name;
      }
    }
  }
}

// ----- loop_overrun

TEST(LoopOverrunRule, H22EachStepOfARandomlyLateLoopIsJudgedByTheRule) {
  int found = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    LoopOverrun monitor;
    Spells<bool> moving(random, 500, {true, true, false});
    int since_late = 1000;
    for (int i = 0; i < 4000; ++i) {
      SCOPED_TRACE(i);
      const bool late = random.once_in(seed % 2 == 0 ? 100 : 60), far_too_late = random.once_in(400);
      bench.wake_lateness_s = far_too_late ? 0.031F : late ? (random.once_in(2) ? 0.0051F : 0.0290F) : 0.0049F;
      bench.moving = moving.step();
      ++since_late;
      const bool expected = bench.moving && (far_too_late || (late && since_late < 100));
      if (late || far_too_late) since_late = 0;
      ASSERT_EQ(monitor.check(bench.view()), expected);
      found += expected ? 1 : 0;
    }
  }
  EXPECT_GT(found, 100);
  // Two late steps are a second apart, or a step less.
  for (const int apart_ticks : {99, 100}) {
    MonitorBench bench;
    LoopOverrun monitor;
    for (int i = 0; i <= apart_ticks; ++i) {
      bench.wake_lateness_s = i % apart_ticks == 0 ? 0.006F : 0.0F;
      EXPECT_EQ(monitor.check(bench.view()), i == 99 && apart_ticks == 99);
    }
  }
}

// ----- server_lost

TEST(ServerLostRule, H21AServerThatNeverCameIsMissedAfterFiveSeconds) {
  MonitorBench bench;
  ServerLost monitor;
  for (const std::uint64_t ticks : {1U, 499U, 500U, 501U, 502U, 10'000U})
    for (const bool alive : {false, true})
      for (const bool seen : {false, true}) {
        bench.ticks = ticks;
        bench.server_alive = alive;
        bench.server_seen = seen;
        EXPECT_EQ(monitor.check(bench.view()), !alive && (seen || ticks > 500)) << ticks << alive << seen;
      }
}

}  // namespace
}  // namespace hoist::core::test
