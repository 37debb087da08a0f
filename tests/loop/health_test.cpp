// Frames are lost between real nodes and the real core: only the right node is named, soon, without false reports of duplicate ids or
// floods.
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <random>

#include "tests/support/closed_loop.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::tests {
namespace {

using contract::Fault;
using contract::Mode;
using contract::Node;

ClosedLoopOptions walk(std::uint64_t seed = 1, bool through_gateway = false) {
  ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  options.world.seed = seed;
  options.world.patient.wish_m_s = 0.30;
  options.through_gateway = through_gateway;
  return options;
}

std::uint32_t lost(const ClosedLoop& loop, Node node) { return loop.core().health.node(node).lost_frames; }
std::uint8_t lost_lately(const ClosedLoop& loop, Node node) { return loop.core().health.node(node).lost_10s; }

void expect_nobody_accused(const ClosedLoop& loop) {
  EXPECT_FALSE(loop.ever_raised(Fault::node_duplicate));
  EXPECT_FALSE(loop.ever_raised(Fault::node_babbling));
  EXPECT_FALSE(loop.ever_raised(Fault::tilt_frozen));
  EXPECT_EQ(loop.record().duplicate_id, 0);
  EXPECT_EQ(loop.record().babbling_id, core::BusHealth::kNoId);
}

class OneInAHundred : public testing::TestWithParam<std::tuple<Node, bool>> {};
TEST_P(OneInAHundred, NamesTheRightNodeWithinTwoSecondsAndNoOtherInAMinute) {
  const Node node = std::get<0>(GetParam());
  ClosedLoop loop(walk(1, std::get<1>(GetParam())));
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(3.0);
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) ASSERT_EQ(lost(loop, static_cast<Node>(n)), 0U);
  const std::size_t port = loop.world().port_of(node);
  int seen = 0;
  std::uint32_t dropped = 0;
  loop.world().set_frame_fault([&](std::size_t from, const contract::CanFrame&, std::uint64_t) {
    bus::BusFault fault;
    if (from == port && ++seen % 100 == 0) {
      fault.kind = bus::BusFault::Kind::drop;
      ++dropped;
    }
    return fault;
  });
  const double begin_s = loop.time_s();
  ASSERT_TRUE(loop.run_until([&] { return lost_lately(loop, node) > 0; }, 2.0)) << "after " << dropped << " lost frames";
  RecordProperty("shown_after_ms", static_cast<int>((loop.time_s() - begin_s) * 1000.0));
  loop.run(58.0);
  loop.world().set_frame_fault({});
  loop.run(1.0);
  EXPECT_GE(dropped, 30U);
  EXPECT_GE(lost(loop, node) + 1, dropped);
  EXPECT_LE(lost(loop, node), dropped);
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) {
    if (static_cast<Node>(n) == node) continue;
    EXPECT_EQ(lost(loop, static_cast<Node>(n)), 0U) << contract::kNodes[n].name;
  }
  EXPECT_EQ(loop.record().syncs_lost, 0U);
  expect_nobody_accused(loop);
}
INSTANTIATE_TEST_SUITE_P(Nodes, OneInAHundred,
                         testing::Combine(testing::Values(Node::drive_left, Node::drive_right, Node::io, Node::tilt_left, Node::tilt_right,
                                                          Node::tilt_base),
                                          testing::Bool()),
                         [](const auto& row) {
                           return std::string(contract::kNodes[static_cast<std::size_t>(std::get<0>(row.param))].name) +
                                  (std::get<1>(row.param) ? "_through_the_gateway" : "");
                         });

// Random loss in both directions: every node loses some, and no node is reported as anything else.
TEST(BusHealth, OnePercentOfAllFramesLostAccusesNobodyOfMore) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(seed);
    ClosedLoop loop(walk(seed, seed == 2));
    ASSERT_TRUE(loop.start(Mode::user));
    std::mt19937_64 random(seed);
    std::array<std::uint32_t, contract::kRemoteNodeCount> dropped{};
    loop.world().set_frame_fault([&](std::size_t from, const contract::CanFrame&, std::uint64_t) {
      bus::BusFault fault;
      if (random() % 100 != 0) return fault;
      fault.kind = bus::BusFault::Kind::drop;
      for (std::size_t n = 0; n < dropped.size(); ++n)
        if (loop.world().port_of(static_cast<Node>(n)) == from) ++dropped[n];
      return fault;
    });
    loop.run(120.0);
    for (std::size_t n = 0; n < dropped.size(); ++n) {
      EXPECT_GT(lost(loop, static_cast<Node>(n)), dropped[n] * 7 / 10) << contract::kNodes[n].name;
      // A SYNC unanswered by one node, while others lost the next answer, cannot be distinguished.
      EXPECT_LT(lost(loop, static_cast<Node>(n)), dropped[n] * 13 / 10 + 20) << contract::kNodes[n].name;
    }
    EXPECT_GT(loop.record().syncs_lost, 60U);
    expect_nobody_accused(loop);
  }
}

TEST(BusHealth, FaultFreeWalkingLosesNothingAndAccusesNobody) {
  for (const std::uint64_t seed : {11, 12, 13}) {
    SCOPED_TRACE(seed);
    ClosedLoop loop(walk(seed, seed == 12));
    ASSERT_TRUE(loop.start(Mode::user));
    loop.run(seeds_for(1200, 1200, 90));
    for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n)
      EXPECT_EQ(lost(loop, static_cast<Node>(n)), 0U) << contract::kNodes[n].name;
    EXPECT_EQ(loop.record().syncs_lost, 0U);
    EXPECT_GT(loop.record().bus_load_norm, 0.3F);
    EXPECT_LT(loop.record().bus_load_norm, 0.6F);
    expect_nobody_accused(loop);
  }
}

TEST(BusHealth, AnUnpluggedNodeThatComesBackIsNoSecondOne) {
  for (const Node node : {Node::tilt_left, Node::io, Node::drive_right}) {
    SCOPED_TRACE(contract::kNodes[static_cast<std::size_t>(node)].name);
    ClosedLoop loop(walk());
    ASSERT_TRUE(loop.start(Mode::user));
    for (const double pause_s : {0.02, 0.3, 1.5}) {
      loop.world().unplug(node, true);
      loop.run(pause_s);
      loop.world().unplug(node, false);
      loop.run(3.0);
    }
    expect_nobody_accused(loop);
  }
}

TEST(BusHealth, AComputerThatWasHeldUpAccusesNobody) {
  ClosedLoop loop(walk());
  ASSERT_TRUE(loop.start(Mode::user));
  for (int ms : {35, 120, 260, 700}) {
    // The loop is suspended while the world continues; then it finds all frames that arrived meanwhile.
    for (int i = 0; i < ms; ++i) loop.world().advance_1ms();
    loop.be_late(0.001 * ms);
    loop.run(2.0);
  }
  expect_nobody_accused(loop);
}

TEST(BusHealth, ADrivesEmergencyIsTold) {
  ClosedLoop loop(walk());
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(5.0);
  EXPECT_EQ(loop.record().drive_left_emcy_count, 0);
  loop.world().break_encoder(Node::drive_left, sim::World::EncoderFault::reversed);
  loop.run(1.0);
  EXPECT_EQ(loop.record().drive_left_emcy_code, 0x7305);
  EXPECT_GE(loop.record().drive_left_emcy_count, 1);
  EXPECT_NE(loop.record().drive_left_error_register, 0);
  EXPECT_EQ(loop.record().drive_right_error_register, 0);
  bool told = false;
  for (const contract::Event& event : loop.events())
    told = told || (event.kind == contract::EventKind::emergency && event.code == 0x7305 &&
                    event.item == static_cast<std::uint32_t>(Node::drive_left));
  EXPECT_TRUE(told);
}

}  // namespace
}  // namespace hoist::tests
