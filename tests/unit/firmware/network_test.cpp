// All six nodes and a computer on one virtual bus: timing of their frames.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "control/bus/virtual_bus.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/gateway/gateway_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

struct BusBoard : TestBoard {
  bus::VirtualBus* bus = nullptr;
  std::size_t port = 0;
  bool send(const CanFrame& frame) { return bus->send(port, frame); }
};

class NetworkTest : public ::testing::TestWithParam<bool> {
 protected:
  NetworkTest() : bus_(std::make_unique<bus::VirtualBus>(bus::VirtualBusOptions{250000, GetParam()})) {
    host_ = bus_->add_port();
    for (BusBoard* board : {&tilt_left_, &tilt_right_, &tilt_base_, &drive_left_, &drive_right_, &io_board_}) {
      board->bus = bus_.get();
      board->port = bus_->add_port();
    }
  }
  void deliver(std::size_t port, const CanFrame& frame) {
    if (port == host_) {
      heard_.emplace_back(frame.id, bus_->now_ns());
      return;
    }
    if (port == tilt_left_.port) a_.on_frame(frame);
    if (port == tilt_right_.port) b_.on_frame(frame);
    if (port == tilt_base_.port) c_.on_frame(frame);
    if (port == drive_left_.port) d_.on_frame(frame);
    if (port == drive_right_.port) e_.on_frame(frame);
    if (port == io_board_.port) f_.on_frame(frame);
  }
  void one_ms() {
    a_.tick_1ms(), b_.tick_1ms(), c_.tick_1ms(), d_.tick_1ms(), e_.tick_1ms(), f_.tick_1ms();
    bus_->advance(1'000'000, [this](std::size_t port, const CanFrame& frame) { deliver(port, frame); });
  }
  CanFrame rpdo(std::uint32_t id) const { return frame_of(id, {0x06, 0, 0, 0, 0, 0}); }

  std::unique_ptr<bus::VirtualBus> bus_;
  std::size_t host_ = 0;
  BusBoard tilt_left_, tilt_right_, tilt_base_, drive_left_, drive_right_, io_board_;
  TiltNode<BusBoard> a_{tilt_left_, contract::Node::tilt_left}, b_{tilt_right_, contract::Node::tilt_right},
      c_{tilt_base_, contract::Node::tilt_base};
  DriveNode<BusBoard> d_{drive_left_, contract::Node::drive_left}, e_{drive_right_, contract::Node::drive_right};
  IoNode<BusBoard> f_{io_board_, contract::Node::io};
  std::vector<std::pair<std::uint32_t, std::uint64_t>> heard_;
};

TEST_P(NetworkTest, AllBootUpAndTheCycleFitsItsTimes) {
  for (int i = 0; i < 10; ++i) one_ms();
  std::vector<std::uint32_t> booted;
  for (const auto& [id, at] : heard_) booted.push_back(id);
  EXPECT_EQ(booted, (std::vector<std::uint32_t>{0x701, 0x702, 0x708, 0x711, 0x712, 0x713}));
  ASSERT_TRUE(bus_->send(host_, canopen::nmt(canopen::NmtCommand::start, 0)));
  one_ms();
  heard_.clear();

  // 10 s of the cycle: SYNC at 0, RPDOs at 5 ms, heartbeat each 100 ms, an SDO every 20 ms that must not delay others.
  std::uint64_t sync_ns = 0, latest_tpdo_ns = 0;
  std::map<std::uint32_t, int> count;
  const std::uint64_t busy_before_ns = bus_->counters().busy_ns;
  for (int ms = 0; ms < 10000; ++ms) {
    if (ms % 10 == 0) {
      sync_ns = bus_->now_ns();
      ASSERT_TRUE(bus_->send(host_, canopen::sync()));
    }
    if (ms % 10 == 5) {
      ASSERT_TRUE(bus_->send(host_, rpdo(0x201)) && bus_->send(host_, rpdo(0x202)));
    }
    if (ms % 100 == 3) {
      ASSERT_TRUE(bus_->send(host_, canopen::heartbeat(0x7F, canopen::NmtState::operational)));
    }
    if (ms % 20 == 9) {
      ASSERT_TRUE(bus_->send(host_, canopen::sdo(0x601, 0x40, 0x1017, 0, 0)));
    }
    one_ms();
    for (const auto& [id, at] : heard_) {
      ++count[id];
      if (id == 0x181 || id == 0x182 || id == 0x191 || id == 0x192 || id == 0x193) latest_tpdo_ns = std::max(latest_tpdo_ns, at - sync_ns);
    }
    heard_.clear();
  }
  for (const std::uint32_t id : {0x181U, 0x182U, 0x191U, 0x192U, 0x193U, 0x293U}) EXPECT_EQ(count[id], 1000) << std::hex << id;
  for (const std::uint32_t id : {0x281U, 0x282U}) EXPECT_EQ(count[id], 200) << std::hex << id;
  EXPECT_EQ(count[0x188], 1000);
  EXPECT_EQ(count[0x288], 100);
  EXPECT_EQ(count[0x581], 500);
  for (const std::uint32_t id : {0x701U, 0x702U, 0x708U, 0x711U, 0x712U, 0x713U}) EXPECT_NEAR(count[id], 100, 1) << std::hex << id;
  EXPECT_EQ(count.count(0x291), 0U);
  EXPECT_EQ(count.count(0x081), 0U);      // no emergency in an undisturbed run
  EXPECT_LE(latest_tpdo_ns, 4'600'000U);  // bus plan, section 5
  EXPECT_GT(latest_tpdo_ns, 2'000'000U);
  const double load = static_cast<double>(bus_->counters().busy_ns - busy_before_ns) / 10e9;
  RecordProperty("load_percent", static_cast<int>(std::lround(100 * load)));
  EXPECT_LT(load, GetParam() ? 0.56 : 0.47);
  EXPECT_GT(load, GetParam() ? 0.46 : 0.38);
  EXPECT_EQ(bus_->counters().tx_refused, 0U);
}

TEST_P(NetworkTest, AnUnpluggedSensorIsMissedAndTheOthersGoOn) {
  for (int i = 0; i < 10; ++i) one_ms();
  ASSERT_TRUE(bus_->send(host_, canopen::nmt(canopen::NmtCommand::start, 0)));
  one_ms();
  bus_->set_connected(tilt_left_.port, false);
  heard_.clear();
  ASSERT_TRUE(bus_->send(host_, canopen::sync()));
  for (int i = 0; i < 9; ++i) one_ms();
  int left = 0, right = 0;
  for (const auto& [id, at] : heard_) {
    left += id == 0x191 ? 1 : 0;
    right += id == 0x192 ? 1 : 0;
  }
  EXPECT_EQ(left, 0);
  EXPECT_EQ(right, 1);
}

INSTANTIATE_TEST_SUITE_P(Stuffing, NetworkTest, ::testing::Bool(), [](const auto& param) { return param.param ? "worst" : "none"; });

}  // namespace
}  // namespace hoist::firmware
