// Health of bus and nodes: lost frames by node, emergency messages, duplicate ids and floods, and no false reports.
#include <gtest/gtest.h>

#include "control/contract/emergencies.hpp"
#include "control/core/health/bus_health.hpp"
#include "firmware/lib/canopen_node.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::CanFrame;
using contract::Node;
using contract::Pdo;
namespace canopen = contract::canopen;

constexpr std::int32_t kEach = kStreamUnit;  // one frame a step

CanFrame tpdo1(Node node) {
  switch (contract::kNodes[static_cast<std::size_t>(node)].kind) {
    case contract::NodeKind::tilt:
      return {contract::pdo_cob_id(Pdo::tilt_tx1, node), contract::pdo_bytes(Pdo::tilt_tx1), 0, {}};
    case contract::NodeKind::drive:
      return {contract::pdo_cob_id(Pdo::drive_tx1, node), contract::pdo_bytes(Pdo::drive_tx1), 0, {}};
    default:
      return {contract::pdo_cob_id(Pdo::io_tx1, node), contract::pdo_bytes(Pdo::io_tx1), 0, {}};
  }
}

// ----- one stream -----

TEST(StreamWatchTest, EvenFramesLoseNothing) {
  StreamWatch stream;
  for (std::uint32_t step = 0; step < 1000; ++step) {
    EXPECT_NE(stream.take(step * kStreamUnit, kEach), StreamWatch::Came::too_many);
    if (step % 25 == 24) {
      EXPECT_EQ(stream.settle(), 0U);
    }
  }
}

TEST(StreamWatchTest, EachMissingFrameIsCountedOnce) {
  StreamWatch stream;
  std::uint32_t lost = 0, dropped = 0;
  for (std::uint32_t step = 0; step < 2000; ++step) {
    if (step % 37 == 5 || step % 370 == 6) {
      ++dropped;
    } else {
      EXPECT_NE(stream.take(step * kStreamUnit, kEach), StreamWatch::Came::too_many);
    }
    if (step % 25 == 24) lost += stream.settle();
  }
  lost += stream.settle();
  lost += stream.settle();
  EXPECT_EQ(lost, dropped);
}

TEST(StreamWatchTest, HeldUpFramesAreLateAndNotLost) {
  StreamWatch stream;
  std::uint32_t waiting = 0;
  for (std::uint32_t step = 0; step < 1000; ++step) {
    ++waiting;
    if (step % 90 >= 70) continue;  // 200 ms of silence, then everything at once
    for (; waiting > 0; --waiting) EXPECT_NE(stream.take(step * kStreamUnit, kEach), StreamWatch::Came::too_many);
    if (step % 25 == 24) {
      EXPECT_EQ(stream.settle(), 0U) << step;
    }
  }
}

TEST(StreamWatchTest, ATimerOfItsOwnMayDriftAndItsFramesMayWaitForTheBus) {
  // A frame each 20 ms, seen in the step after it came: between the steps lies up to a step, and up to 4 ms more on the bus.
  for (const double drift : {-0.002, -0.0001, 0.0, 0.0001, 0.002}) {
    SCOPED_TRACE(drift);
    StreamWatch stream;
    std::uint32_t seed = 1;
    int sent = 0, lost = 0, dropped = 0;
    double due_ticks = 0.37;
    std::uint32_t tick = 0;
    for (; due_ticks < 20'000; due_ticks += 2.0 * (1.0 + drift)) {
      seed = seed * 1664525U + 1013904223U;
      const auto seen = static_cast<std::uint32_t>(due_ticks + 0.4 * (seed >> 8) / 16777216.0);
      for (; tick < seen; ++tick)
        if (tick % 25 == 24) lost += static_cast<int>(stream.settle());
      if (++sent % 150 == 149) {
        ++dropped;
      } else {
        EXPECT_NE(stream.take(seen * kStreamUnit, 2 * kStreamUnit), StreamWatch::Came::too_many) << seen;
      }
    }
    EXPECT_NEAR(lost, dropped, 1);
    EXPECT_GT(dropped, 60);
  }
}

// A timer of one step whose clock drifts across ours misses a step, or brings two, each time they cross: no frame was lost.
TEST(StreamWatchTest, ATimerOfOneStepThatDriftsAcrossOursLosesNothing) {
  for (const double drift : {-0.0002, -0.00005, 0.00005, 0.0002}) {
    SCOPED_TRACE(drift);
    StreamWatch stream;
    std::uint32_t seed = 1, tick = 0;
    int lost = 0, slips = 0;
    for (double due_ticks = 0.5; due_ticks < 100'000; due_ticks += 1.0 + drift) {
      seed = seed * 1664525U + 1013904223U;
      const auto seen = static_cast<std::uint32_t>(due_ticks + 0.05 * (seed >> 8) / 16777216.0);
      for (; tick < seen; ++tick) {
        if (tick % 25 != 24) continue;
        const auto missing = static_cast<int>(stream.settle());
        slips += missing;
        if (!stream.wavers(tick * kStreamUnit)) lost += missing;
      }
      static_cast<void>(stream.take(seen * kStreamUnit, kEach));
    }
    EXPECT_EQ(lost, 0);
    if (drift > 0) {
      EXPECT_GT(slips, 2) << "or this test shows nothing";
    }
  }
}

TEST(StreamWatchTest, TheSecondAnswerIsOneTooMany) {
  StreamWatch stream;
  std::uint32_t surplus = 0;
  for (std::uint32_t step = 0; step < 100; ++step) {
    EXPECT_NE(stream.take(step * kStreamUnit, kEach), StreamWatch::Came::too_many);
    surplus += stream.take(step * kStreamUnit, kEach) == StreamWatch::Came::too_many ? 1 : 0;
    if (step % 25 == 24) {
      EXPECT_EQ(stream.settle(), 0U);
    }
  }
  EXPECT_EQ(surplus, 100U);
}

TEST(StreamWatchTest, AfterALongSilenceNobodyGuesses) {
  StreamWatch stream;
  EXPECT_NE(stream.take(0, kEach), StreamWatch::Came::too_many);
  EXPECT_NE(stream.take(5000 * kStreamUnit, kEach), StreamWatch::Came::too_many);
  EXPECT_EQ(stream.settle(), 0U);
  EXPECT_NE(stream.take(5001 * kStreamUnit, kEach), StreamWatch::Came::too_many);
  EXPECT_EQ(stream.settle(), 0U);
}

TEST(RateWatchTest, ThePlanAndHalfAsMuchAgainPassForEverAndAFloodDoesNot) {
  constexpr auto kBudget = RateWatch::budget(100);
  RateWatch once, half_more, flood;
  std::uint32_t refused_at = 0;
  for (std::uint32_t tick = 0; tick < 10'000; ++tick) {
    ASSERT_TRUE(once.take(tick, kBudget));
    for (std::uint32_t i = 0; i < 1 + tick % 2; ++i) ASSERT_TRUE(half_more.take(tick, kBudget));
    for (int i = 0; i < 15; ++i)
      if (!flood.take(tick, kBudget) && refused_at == 0) refused_at = tick;
  }
  EXPECT_GT(refused_at, 0U);
  EXPECT_LE(refused_at, 6U) << "1500 frames a second are found within 60 ms";
}

TEST(BusLoadTest, CountsTheLongestFramesOfThePlan) {
  BusLoad load;
  for (int i = 0; i < 1000; ++i) load.take({0x181, 8, 0, {}});
  load.close(1.0);
  EXPECT_NEAR(load.load_norm(), 1000 * 135 / 250e3, 1e-9);
  EXPECT_EQ(load.frames_per_s(), 1000U);
  load.close(1.0);
  EXPECT_EQ(load.load_norm(), 0.0);
}

// A gap in the input node's data is a lost frame, unless all nodes were delayed then.
TEST(BusHealthTest, AMomentInWhichAllWereHeldUpLosesNothing) {
  for (const bool all : {false, true}) {
    SCOPED_TRACE(all);
    BusHealth health;
    const CanFrame left = tpdo1(Node::drive_left), inputs = tpdo1(Node::io);
    const auto io_ticks = contract::pdo_info(Pdo::io_tx1).period_ms / 10U;
    for (std::uint64_t tick = 1000; tick < 2000; ++tick) {
      health.next_tick(tick * 10'000'000, true);
      const bool hole = tick == 1700;
      if (!(hole && all)) static_cast<void>(health.take(left, contract::classify(left)));
      if (tick == 1701 && all) static_cast<void>(health.take(left, contract::classify(left)));
      // Its timer restarts after the gap: frames missing then never come.
      if (tick % io_ticks == 0 && !hole) static_cast<void>(health.take(inputs, contract::classify(inputs)));
      health.sent(canopen::sync());
    }
    EXPECT_EQ(health.node(Node::drive_left).lost_frames, 0U);
    EXPECT_EQ(health.node(Node::io).lost_frames, all && io_ticks < 2 ? 0U : 1U);
  }
}

// ----- the core -----

TEST(Health, AHealthyHoistLosesNothingAndAccusesNobody) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.step(3000);
  const auto& record = hoist.out.record;
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n)
    EXPECT_EQ(hoist.state.health.node(static_cast<Node>(n)).lost_frames, 0U) << contract::kNodes[n].name;
  EXPECT_EQ(record.syncs_lost, 0U);
  EXPECT_EQ(record.duplicate_id, 0);
  EXPECT_EQ(record.babbling_id, BusHealth::kNoId);
  EXPECT_EQ(record.tilt_left_nmt_state, 5);
  EXPECT_EQ(record.drive_right_heartbeats_missed, 0);
  EXPECT_GT(record.bus_load_norm, 0.3F);
  EXPECT_LT(record.bus_load_norm, 0.6F) << "the load plan says 47 % with everything";
  EXPECT_GT(record.bus_frames_per_s, 700);
}

TEST(Health, ASilentNodeMissesItsHeartbeatsAndNoOther) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.tilt_right.silent = true;
  hoist.step(55);
  EXPECT_GE(hoist.out.record.tilt_right_heartbeats_missed, 4);
  EXPECT_LE(hoist.out.record.tilt_right_heartbeats_missed, 6);
  EXPECT_EQ(hoist.out.record.tilt_left_heartbeats_missed, 0);
  EXPECT_EQ(hoist.out.record.drive_left_heartbeats_missed, 0);
}

TEST(Health, AFrameOfEachNodeThatIsMissingIsThatNodesAlone) {
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) {
    SCOPED_TRACE(contract::kNodes[n].name);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    const std::array<FakeNode*, contract::kRemoteNodeCount> nodes = {&hoist.drive_left, &hoist.drive_right, &hoist.io,
                                                                     &hoist.tilt_left,  &hoist.tilt_right,  &hoist.tilt_base};
    for (int i = 0; i < 400; ++i) {
      nodes[n]->silent = i % 100 >= 48 && i % 100 < 50;  // 20 ms each
      hoist.step();
    }
    nodes[n]->silent = false;
    hoist.step(60);
    for (std::size_t other = 0; other < contract::kRemoteNodeCount; ++other) {
      const NodeHealth& health = hoist.state.health.node(static_cast<Node>(other));
      if (other == n) {
        EXPECT_GE(health.lost_frames, 3U);
        EXPECT_LE(health.lost_frames, 18U);
        EXPECT_EQ(health.lost_10s, health.lost_frames);
      } else {
        EXPECT_EQ(health.lost_frames, 0U) << contract::kNodes[other].name;
      }
    }
    EXPECT_EQ(hoist.state.mode, Mode::user);
  }
}

TEST(Health, WhatWasLostIsForgottenLatelyButNotInAll) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.tilt_left.silent = true;
  hoist.step(3);
  hoist.tilt_left.silent = false;
  hoist.step(100);
  const auto lost = hoist.out.record.tilt_left_lost_frames;
  EXPECT_GE(lost, 3U);
  EXPECT_EQ(hoist.out.record.tilt_left_lost_10s, lost);
  hoist.step(1100);
  EXPECT_EQ(hoist.out.record.tilt_left_lost_10s, 0);
  EXPECT_EQ(hoist.out.record.tilt_left_lost_frames, lost);
}

TEST(Health, ASyncThatReachedNobodyIsNoNodesFault) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 6; ++i) {
    for (FakeNode* node :
         {static_cast<FakeNode*>(&hoist.drive_left), static_cast<FakeNode*>(&hoist.drive_right), static_cast<FakeNode*>(&hoist.tilt_left),
          static_cast<FakeNode*>(&hoist.tilt_right), static_cast<FakeNode*>(&hoist.tilt_base)})
      node->silent = true;
    hoist.step();
    for (FakeNode* node :
         {static_cast<FakeNode*>(&hoist.drive_left), static_cast<FakeNode*>(&hoist.drive_right), static_cast<FakeNode*>(&hoist.tilt_left),
          static_cast<FakeNode*>(&hoist.tilt_right), static_cast<FakeNode*>(&hoist.tilt_base)})
      node->silent = false;
    hoist.step(72);
  }
  hoist.step(60);
  EXPECT_EQ(hoist.out.record.syncs_lost, 6U);
  EXPECT_LE(hoist.out.record.tilt_left_lost_frames, 1U) << "a heartbeat may have been in the gap";
  EXPECT_LE(hoist.out.record.drive_left_lost_frames, 3U) << "and this script's second process data";
}

TEST(Health, AnEmergencyIsToldOnceWithItsCodeAndItsEnd) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  CanFrame frame{canopen::kEmcyBase + contract::node_id(Node::drive_right), 8, 0, {0x05, 0x73, 0x21, 1, 2, 3, 4, 5}};
  hoist.extra.push_back(frame);
  hoist.step();
  EXPECT_EQ(hoist.out.record.drive_right_emcy_code, 0x7305);
  EXPECT_EQ(hoist.out.record.drive_right_emcy_count, 1);
  EXPECT_EQ(hoist.out.record.drive_right_error_register, 0x21);
  EXPECT_EQ(hoist.out.record.drive_left_emcy_count, 0);
  ASSERT_EQ(hoist.count(EventKind::emergency), 1);
  const contract::Event& event = hoist.events.back();
  EXPECT_EQ(event.item, static_cast<std::uint32_t>(Node::drive_right));
  EXPECT_EQ(event.code, 0x7305U);
  EXPECT_EQ(event.bits, 0x21U);
  EXPECT_EQ(event.value, static_cast<double>(0x0504030201LL));
  hoist.extra.push_back({frame.id, 8, 0, {}});
  hoist.step();
  EXPECT_EQ(hoist.out.record.drive_right_error_register, 0);
  EXPECT_EQ(hoist.out.record.drive_right_emcy_code, 0x7305) << "the latest one stays to be read";
  EXPECT_EQ(hoist.out.record.drive_right_emcy_count, 1);
  EXPECT_EQ(hoist.count(EventKind::emergency), 2);
  hoist.extra.push_back({frame.id, 7, 0, {}});  // not the length of an emergency
  hoist.step();
  EXPECT_EQ(hoist.count(EventKind::emergency), 2);
}

TEST(Health, AFloodOfEmergenciesIsNotAFloodOfEvents) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 10; ++k) hoist.extra.push_back({canopen::kEmcyBase + 0x11U, 8, 0, {0x00, 0x50, 0x81}});
    hoist.step();
  }
  EXPECT_LE(hoist.count(EventKind::emergency), 45);
  EXPECT_EQ(hoist.out.record.tilt_left_emcy_count, 1000) << "counted all the same";
  EXPECT_TRUE(hoist.has_fault(Fault::node_babbling));
  EXPECT_EQ(hoist.out.record.babbling_id, 0x91);
}

TEST(Health, TheWordsOfEveryCodeThatOurNodesSend) {
  for (const std::uint16_t code : {firmware::emcy::kOverCurrent, firmware::emcy::kUnderVoltage, firmware::emcy::kHardware,
                                   firmware::emcy::kEncoder, firmware::emcy::kHeartbeat, firmware::emcy::kPdoTooShort,
                                   firmware::emcy::kPdoTooLong, firmware::emcy::kRpdoDeadline, firmware::emcy::kOverSpeed}) {
    const contract::EmergencyInfo& info = contract::emergency_info(code);
    EXPECT_NE(info.mask, 0) << code;
    EXPECT_NE(info.text_en, info.text_de);
  }
  EXPECT_EQ(contract::emergency_info(0x8250).name, "rpdo_timeout");
  EXPECT_EQ(contract::emergency_info(0x2311).name, "current_class") << "a class speaks for its codes";
  EXPECT_EQ(contract::emergency_info(0x1234).name, "generic") << "and anything has words";
}

// ----- two nodes with one id -----

TEST(Health, H30TheSecondNodeIsNamedInTheEvent) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.events.clear();
  for (int i = 0; i < 20; ++i) {
    hoist.extra.push_back(tpdo1(Node::drive_right));
    hoist.step();
  }
  EXPECT_EQ(hoist.out.record.duplicate_id, 2);
  bool named = false;
  for (const contract::Event& event : hoist.events)
    named = named ||
            (event.kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_duplicate) && event.item == 2);
  EXPECT_TRUE(named);
  // The culprit is unplugged: a second later the stop may be acknowledged.
  hoist.lean(0);
  EXPECT_NE(hoist.ask(contract::CommandKind::acknowledge), 0U);
  hoist.step(250);
  EXPECT_EQ(hoist.out.record.duplicate_id, 0);
  EXPECT_EQ(hoist.ask(contract::CommandKind::acknowledge), 0U);
}

TEST(Health, H30ANodeThatBootsBesideALivingOneIsFound) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.tilt_left.sdo_deaf = true;  // the new one has no answer yet; the old one continues with its data
  hoist.extra.push_back(canopen::heartbeat(0x11, canopen::NmtState::boot_up));
  hoist.step(15);
  EXPECT_EQ(hoist.out.record.duplicate_id, 0x11);
}

TEST(Health, ANodeThatReallyRestartsIsNoSecondOne) {
  for (int pause = 0; pause < 60; pause += 7) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    hoist.step(pause % 10);
    hoist.tilt_left.silent = true;
    hoist.step(pause);
    hoist.tilt_left.silent = false;
    hoist.tilt_left.booted = false;
    hoist.tilt_left.nmt = canopen::NmtState::pre_operational;
    for (int i = 0; i < 300; ++i) {
      hoist.step();
      ASSERT_EQ(hoist.out.record.duplicate_id, 0) << pause << " " << i;
    }
  }
}

TEST(Health, H30ASecondControlComputerIsNamedAsOne) {
  const CanFrame orders[] = {canopen::sync(), CanFrame{0x201, 6, 0, {}}, canopen::heartbeat(0x7F, canopen::NmtState::operational)};
  for (const CanFrame& order : orders) {
    SCOPED_TRACE(order.id);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    for (int i = 0; i < 60 && hoist.state.mode == Mode::remote; ++i) {
      hoist.hold(0.5);
      // At the pace at which a core sends them.
      if (order.id != 0x77F || i % 10 == 0) hoist.extra.push_back(order);
      hoist.step();
    }
    EXPECT_TRUE(hoist.has_fault(Fault::node_duplicate));
    EXPECT_EQ(hoist.out.record.duplicate_id, 127);
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  }
}

// ----- floods -----

TEST(Health, H30AServiceToolMayReadWhileTheHoistStands) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.sdo_deaf = true;
  for (int i = 0; i < 3000; ++i) {
    // A request each 4.3 ms, and the node's answers.
    for (int k = 0; k < (i % 3 == 0 ? 3 : 2); ++k) {
      hoist.extra.push_back(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x1018, 1, 0));
      hoist.extra.push_back(canopen::sdo(0x581, 0x43, 0x1018, 1, 0));
    }
    hoist.step();
    ASSERT_EQ(hoist.out.record.babbling_id, BusHealth::kNoId) << i;
    ASSERT_FALSE(hoist.has_fault(Fault::node_babbling)) << i;
  }
}

TEST(Health, H30AFullBusStopsWhoeverFillsIt) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  // Each id within its own budget, together too much.
  for (int i = 0; i < 220 && hoist.state.mode == Mode::user; ++i) {
    for (const std::uint32_t id : {0x581U, 0x582U, 0x588U, 0x591U, 0x592U, 0x593U})
      for (int k = 0; k < 2; ++k) hoist.extra.push_back(canopen::sdo(id, 0x43, 0x1018, 1, 0));
    hoist.step();
  }
  EXPECT_TRUE(hoist.has_fault(Fault::node_babbling));
  EXPECT_EQ(hoist.out.record.babbling_id, BusHealth::kNoId);
  EXPECT_GT(hoist.out.record.bus_load_norm, 0.95F);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

TEST(Health, PortCountersReachTheRecord) {
  CoreState state;
  TickOutputs out;
  TickInputs inputs;
  inputs.bus = {1, 2, 3, 4, 5, 130, 97, 2};
  inputs.bus_up = true;
  tick(state, inputs, kTick_s, out);
  EXPECT_EQ(out.record.bus_refused, 1U);
  EXPECT_EQ(out.record.bus_send_refused, 2U);
  EXPECT_EQ(out.record.bus_reopened, 3U);
  EXPECT_EQ(out.record.bus_overflows, 4U);
  EXPECT_EQ(out.record.bus_errors, 5U);
  EXPECT_EQ(out.record.bus_tx_errors, 130);
  EXPECT_EQ(out.record.bus_rx_errors, 97);
  EXPECT_EQ(out.record.bus_state, 2);
  EXPECT_EQ(out.record.bus_up, 1);
  EXPECT_EQ(out.record.tilt_base_nmt_state, 255) << "nothing heard yet";
}

}  // namespace
}  // namespace hoist::core::test
