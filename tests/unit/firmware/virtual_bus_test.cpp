#include "control/bus/virtual_bus.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace hoist::bus {
namespace {

using contract::CanFrame;

struct Heard {
  std::size_t port;
  CanFrame frame;
  std::uint64_t at_ns;
};

class VirtualBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (std::size_t& port : ports_) port = bus_->add_port();
  }
  void advance(std::uint64_t dt_ns) {
    bus_->advance(dt_ns, [this](std::size_t port, const CanFrame& frame) { heard_.push_back({port, frame, bus_->now_ns()}); });
  }
  std::vector<std::uint32_t> ids_at(std::size_t port) const {
    std::vector<std::uint32_t> ids;
    for (const Heard& h : heard_)
      if (h.port == port) ids.push_back(h.frame.id);
    return ids;
  }
  static CanFrame frame(std::uint32_t id, std::uint8_t dlc = 8) { return CanFrame{id, dlc, 0, {}}; }

  std::unique_ptr<VirtualBus> bus_ = std::make_unique<VirtualBus>();
  std::array<std::size_t, 3> ports_{};
  std::vector<Heard> heard_;
};

TEST(VirtualBusBits, MatchTheTableOfTheBusPlan) {
  const std::uint32_t none[] = {47, 55, 63, 71, 79, 87, 95, 103, 111};
  const std::uint32_t worst[] = {55, 65, 75, 85, 95, 105, 115, 125, 135};
  for (std::uint8_t dlc = 0; dlc <= 8; ++dlc) {
    EXPECT_EQ(frame_bits(CanFrame{1, dlc, 0, {}}, false), none[dlc]);
    EXPECT_EQ(frame_bits(CanFrame{1, dlc, 0, {}}, true), worst[dlc]);
    EXPECT_EQ(frame_bits(CanFrame{1, dlc, CanFrame::kRemote, {}}, false), 47U);
  }
  EXPECT_EQ(frame_bits(CanFrame{1, 8, CanFrame::kExtended, {}}, false), 131U);
  EXPECT_EQ(frame_bits(CanFrame{1, 8, CanFrame::kExtended, {}}, true), 160U);
}

TEST(VirtualBusBits, ArbitrationFollowsTheWire) {
  const auto key = [](std::uint32_t id, std::uint8_t flags) { return arbitration_key(CanFrame{id, 0, flags, {}}); };
  EXPECT_LT(key(0x080, 0), key(0x081, 0));
  EXPECT_LT(key(0x123, 0), key(0x123, CanFrame::kRemote));
  EXPECT_LT(key(0x123, CanFrame::kRemote), key(0x123U << 18, CanFrame::kExtended));
  EXPECT_LT(key(0x123U << 18, CanFrame::kExtended), key((0x123U << 18) + 1, CanFrame::kExtended));
  EXPECT_LT(key((0x123U << 18) + 1, CanFrame::kExtended), key(0x124, 0));
}

TEST_F(VirtualBusTest, AFrameTakesItsBitTimesAndReachesEveryoneButItsSender) {
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x181)));
  advance(432000 - 1);  // 111 bits of 4 us less the intermission
  EXPECT_TRUE(heard_.empty());
  advance(1);
  ASSERT_EQ(heard_.size(), 2U);
  EXPECT_EQ(heard_[0].port, ports_[1]);
  EXPECT_EQ(heard_[1].port, ports_[2]);
  EXPECT_EQ(heard_[0].at_ns, 432000U);
  EXPECT_EQ(bus_->counters().busy_ns, 444000U);
}

TEST_F(VirtualBusTest, ASyncPassesQueuedSdosButNotTheFrameOnTheWire) {
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(bus_->send(ports_[0], frame(0x601)));
  advance(100000);  // the first SDO is being sent
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x080, 0)));
  advance(10'000'000);
  EXPECT_EQ(ids_at(ports_[1]), (std::vector<std::uint32_t>{0x601, 0x080, 0x601, 0x601, 0x601, 0x601}));
}

TEST_F(VirtualBusTest, TheLowestIdOfAllPortsWinsAndEqualIdsKeepTheirOrder) {
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x300)));
  CanFrame first = frame(0x200), second = frame(0x200);
  second.data[0] = 1;
  ASSERT_TRUE(bus_->send(ports_[1], first));
  ASSERT_TRUE(bus_->send(ports_[1], second));
  ASSERT_TRUE(bus_->send(ports_[1], frame(0x100)));
  advance(10'000'000);
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x100, 0x200, 0x200, 0x300}));
  std::vector<int> marks;
  for (const Heard& h : heard_)
    if (h.port == ports_[2] && h.frame.id == 0x200) marks.push_back(h.frame.data[0]);
  EXPECT_EQ(marks, (std::vector{0, 1}));
}

TEST_F(VirtualBusTest, AnAnswerSentWhileReceivingCompetesAtOnce) {
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x080, 0)));
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x601)));
  bool answered = false;
  bus_->advance(10'000'000, [&](std::size_t port, const CanFrame& f) {
    heard_.push_back({port, f, bus_->now_ns()});
    if (f.id == 0x080 && port == ports_[1]) answered = bus_->send(ports_[1], frame(0x181));
  });
  EXPECT_TRUE(answered);
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x080, 0x181, 0x601}));
}

TEST_F(VirtualBusTest, TimeCutsDoNotMatter) {
  const auto run = [](std::uint64_t step_ns) {
    auto bus = std::make_unique<VirtualBus>();
    const std::size_t a = bus->add_port(), b = bus->add_port();
    std::vector<std::pair<std::uint32_t, std::uint64_t>> heard;
    for (std::uint32_t id : {0x700U, 0x181U, 0x201U, 0x080U, 0x601U}) EXPECT_TRUE(bus->send(id % 2 == 0 ? a : b, frame(id)));
    for (std::uint64_t t = 0; t < 4'000'000; t += step_ns)
      bus->advance(step_ns, [&](std::size_t, const CanFrame& f) { heard.emplace_back(f.id, bus->now_ns()); });
    return heard;
  };
  const auto whole = run(4'000'000);
  EXPECT_EQ(whole.size(), 5U);
  EXPECT_EQ(run(1'000), whole);
  EXPECT_EQ(run(250'000), whole);
}

TEST_F(VirtualBusTest, FullAndImpossibleSendsAreRefusedAndCounted) {
  for (std::size_t i = 0; i < kVirtualTxQueueMax; ++i) ASSERT_TRUE(bus_->send(ports_[0], frame(0x601)));
  EXPECT_FALSE(bus_->send(ports_[0], frame(0x080)));
  EXPECT_FALSE(bus_->send(ports_[1], frame(0x800)));
  EXPECT_FALSE(bus_->send(ports_[1], frame(0x100, 9)));
  EXPECT_FALSE(bus_->send(ports_[1], CanFrame{1, 0, CanFrame::kError, {}}));
  EXPECT_FALSE(bus_->send(99, frame(0x100)));
  EXPECT_EQ(bus_->counters().tx_refused, 5U);
}

TEST_F(VirtualBusTest, ReceiveQueuesAreBoundedAndCountWhatTheyLose) {
  for (std::size_t sent = 0; sent < kVirtualRxQueueMax + 3; ++sent) {
    ASSERT_TRUE(bus_->send(ports_[0], frame(0x100, 0)));
    bus_->advance(200'000);
  }
  std::size_t got = 0;
  for (CanFrame f; bus_->receive(ports_[1], f);) ++got;
  EXPECT_EQ(got, kVirtualRxQueueMax);
  EXPECT_EQ(bus_->counters().rx_lost, 6U);  // three frames at each of two ports
}

TEST_F(VirtualBusTest, FaultsOnRequest) {
  int corrupted = 0;
  bus_->set_fault_hook([&](std::size_t, const CanFrame& f, std::uint64_t) {
    if (f.id == 0x100) return BusFault{BusFault::Kind::drop, 0, 0};
    if (f.id == 0x200 && corrupted < 2) {
      ++corrupted;
      return BusFault{BusFault::Kind::corrupt, 0, 0};
    }
    if (f.id == 0x300 && bus_->now_ns() < 5'000'000) return BusFault{BusFault::Kind::delay, 5'000'000, 0};
    if (f.id == 0x400) return BusFault{BusFault::Kind::none, 0, 1U << ports_[1]};
    return BusFault{};
  });
  for (std::uint32_t id : {0x100U, 0x200U, 0x300U, 0x400U}) ASSERT_TRUE(bus_->send(ports_[0], frame(id)));
  advance(20'000'000);
  EXPECT_EQ(ids_at(ports_[1]), (std::vector<std::uint32_t>{0x200, 0x300}));
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x200, 0x400, 0x300}));
  EXPECT_EQ(bus_->counters().dropped, 1U);
  EXPECT_EQ(bus_->counters().corrupted, 2U);
  EXPECT_EQ(bus_->counters().delayed, 1U);
}

TEST_F(VirtualBusTest, AFrameThatIsAlwaysDestroyedIsGivenUp) {
  bus_->set_fault_hook([](std::size_t, const CanFrame&, std::uint64_t) { return BusFault{BusFault::Kind::corrupt, 0, 0}; });
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x100)));
  advance(100'000'000);
  EXPECT_TRUE(heard_.empty());
  EXPECT_EQ(bus_->counters().given_up, 1U);
  EXPECT_EQ(bus_->counters().corrupted, kVirtualRetryMax);
  EXPECT_EQ(bus_->waiting(ports_[0]), 0U);
}

TEST_F(VirtualBusTest, AnUnpluggedPortIsDeafAndDumb) {
  ASSERT_TRUE(bus_->send(ports_[1], frame(0x181)));
  bus_->set_connected(ports_[1], false);
  EXPECT_FALSE(bus_->send(ports_[1], frame(0x181)));
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x080, 0)));
  advance(1'000'000);
  EXPECT_EQ(ids_at(ports_[1]), (std::vector<std::uint32_t>{}));
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x080}));
  bus_->set_connected(ports_[1], true);
  ASSERT_TRUE(bus_->send(ports_[1], frame(0x181)));
  advance(1'000'000);
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x080, 0x181}));
}

TEST_F(VirtualBusTest, PullingThePlugDuringAFrameLosesIt) {
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x181)));
  advance(100'000);
  bus_->set_connected(ports_[0], false);
  advance(1'000'000);
  EXPECT_TRUE(heard_.empty());
}

TEST_F(VirtualBusTest, AloneOnTheBusNothingIsEverSent) {
  bus_->set_connected(ports_[1], false);
  bus_->set_connected(ports_[2], false);
  ASSERT_TRUE(bus_->send(ports_[0], frame(0x100)));
  advance(10'000'000);
  EXPECT_EQ(bus_->counters().frames, 0U);
  bus_->set_connected(ports_[2], true);
  advance(10'000'000);
  EXPECT_EQ(ids_at(ports_[2]), (std::vector<std::uint32_t>{0x100}));
}

}  // namespace
}  // namespace hoist::bus
