// The gate judges every kind of frame alone, and says no to what it does not know.
#include <gtest/gtest.h>

#include <bit>

#include "control/core/output/safety_gate.hpp"
#include "control/core/types.hpp"

namespace hoist::core {
namespace {

namespace canopen = contract::canopen;
using contract::CanFrame;
using contract::Mode;
using contract::Node;
using contract::Pdo;

class Gate : public ::testing::Test {
 protected:
  contract::Params params;
  Derived derived = derive(params);
  SafetyGate gate;
  GateView view{Mode::user, false, false, false};

  bool judge(const CanFrame& frame) { return gate.judge(frame, view, params, derived, kTick_s); }
  static CanFrame drive(Node node, std::uint16_t control, double wheel_m_s) {
    CanFrame f{contract::pdo_cob_id(Pdo::drive_rx1, node), 6, 0, {}};
    contract::write_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x6040), control);
    contract::write_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x60FF), std::lround(wheel_m_s / 0.1 * 30 * 1000));
    return f;
  }
  bool left(double wheel_m_s, std::uint16_t control = canopen::drive::kEnable) {
    return judge(drive(Node::drive_left, control, wheel_m_s));
  }
  // A legal ramp up to the speed.
  void bring_to(double wheel_m_s) {
    for (double v = 0; v < wheel_m_s; v += 0.004) ASSERT_TRUE(left(v)) << v;
    ASSERT_TRUE(left(wheel_m_s));
  }
};

TEST_F(Gate, EnablesDrivesOnlyWhereTheModeLetsThemRun) {
  for (const auto& [mode, may] :
       {std::pair{Mode::init, false}, {Mode::standby, false}, {Mode::user, true}, {Mode::remote, true}, {Mode::protective_stop, true}}) {
    view.mode = mode;
    EXPECT_EQ(left(0), may);
    EXPECT_EQ(left(0, canopen::drive::kSwitchOn), may);
    EXPECT_TRUE(left(0, canopen::drive::kShutdown));
    EXPECT_TRUE(left(0, canopen::drive::kQuickStop));
    EXPECT_TRUE(left(0, canopen::drive::kFaultReset));
    EXPECT_FALSE(left(0.001, canopen::drive::kShutdown)) << "a target for a drive that does not run";
    EXPECT_FALSE(left(0, 0x1F)) << "an unknown control word";
  }
}

TEST_F(Gate, H23OfTheOutputsOnlyTheRelaysFeedLeaves) {
  const std::uint32_t id = contract::pdo_cob_id(Pdo::io_rx1, Node::io);
  EXPECT_TRUE(judge({id, 1, 0, {0}}));
  EXPECT_TRUE(judge({id, 1, 0, {canopen::kRelayFeed}}));
  for (unsigned bit = 1; bit < 8; ++bit) EXPECT_FALSE(judge({id, 1, 0, {static_cast<std::uint8_t>(1U << bit)}})) << bit;
  EXPECT_FALSE(judge({id, 0, 0, {}}));
  EXPECT_FALSE(judge({id, 2, 0, {1}}));
}

TEST_F(Gate, H13LeadsOnlyAwayFromAPressedBumper) {
  view.mode = Mode::remote;
  view.driver_fresh = true;
  view.bumpers = 1;
  EXPECT_TRUE(left(0));
  EXPECT_FALSE(left(0.004));
  for (double v = 0; v > -0.099; v -= 0.004) EXPECT_TRUE(left(v));
  EXPECT_TRUE(left(-0.1));
  EXPECT_FALSE(left(-0.104));
  view.mode = Mode::protective_stop;
  EXPECT_TRUE(left(-0.09)) << "a stop ends on its ramp";
  view.bumpers = 2;
  EXPECT_TRUE(left(-0.08));
  view.mode = Mode::remote;
  EXPECT_FALSE(left(-0.07));
}

TEST_F(Gate, BoundsSpeedAndSteps) {
  bring_to(0.3);
  EXPECT_FALSE(left(0.35)) << "a jump";
  EXPECT_FALSE(left(0.2)) << "harder than any stop";
  EXPECT_TRUE(left(0.3 - 0.015));
  EXPECT_FALSE(left(-0.3));
  SafetyGate fresh;
  gate = fresh;
  EXPECT_FALSE(left(0.1)) << "motion begins at rest";
  EXPECT_TRUE(left(0.005));
}

TEST_F(Gate, TopSpeedHoldsWhateverTheSteps) {
  bool refused = false;
  for (double v = 0; v < 1.5 && !refused; v += 0.01) {
    refused = !left(v);
    if (!refused) {
      ASSERT_LE(v, 0.65 + 0.872664626 * 0.35 + 1e-3);
    }
  }
  EXPECT_TRUE(refused);
}

TEST_F(Gate, NothingSpeedsUpBlindlyOrWithoutADriver) {
  const double turn_step = 2.0943951 * 0.35 * kTick_s;
  for (int blind = 0; blind < 4; ++blind) {
    gate = SafetyGate{};
    view = {Mode::user, false, false, true};
    bring_to(0.2);
    if (blind == 0) view.tilts_lost = true;
    if (blind == 1) view.drives_lost = true;
    if (blind == 2) view = {Mode::remote, false, false, false};
    if (blind == 3) view.mode = Mode::protective_stop;
    EXPECT_FALSE(left(0.2 + turn_step + 0.001)) << blind;
    EXPECT_TRUE(left(0.19)) << "slowing is always allowed: " << blind;
    EXPECT_TRUE(left(0.18));
  }
}

TEST_F(Gate, AStopMayTakeOverAHoistThatRollsButNoOtherModeMay) {
  view.mode = Mode::protective_stop;
  EXPECT_TRUE(left(0.4));
  gate = SafetyGate{};
  view.mode = Mode::remote;
  view.driver_fresh = true;
  EXPECT_FALSE(left(0.4));
}

TEST_F(Gate, WrongShapesAreRefused) {
  CanFrame f = drive(Node::drive_left, canopen::drive::kEnable, 0);
  f.dlc = 5;
  EXPECT_FALSE(judge(f));
  f = drive(Node::drive_left, canopen::drive::kEnable, 0);
  f.flags = CanFrame::kExtended;
  EXPECT_FALSE(judge(f));
  EXPECT_FALSE(judge(CanFrame{0x205, 6, 0, {}})) << "no such drive";
  EXPECT_FALSE(judge(CanFrame{0x181, 8, 0, {}})) << "a node's own frame";
  EXPECT_FALSE(judge(CanFrame{0x123, 0, 0, {}}));
}

TEST_F(Gate, SyncAndHeartbeatOnlyAsTheyAre) {
  EXPECT_TRUE(judge(canopen::sync()));
  CanFrame longer = canopen::sync();
  longer.dlc = 1;
  EXPECT_FALSE(judge(longer));
  EXPECT_TRUE(judge(canopen::heartbeat(0x7F, canopen::NmtState::operational)));
  EXPECT_FALSE(judge(canopen::heartbeat(0x7F, canopen::NmtState::stopped)));
  EXPECT_FALSE(judge(canopen::heartbeat(0x01, canopen::NmtState::operational))) << "speaking for a node";
}

TEST_F(Gate, NmtStartsNodesAndNeverResetsThem) {
  EXPECT_TRUE(judge(canopen::nmt(canopen::NmtCommand::start, 0x11)));
  EXPECT_TRUE(judge(canopen::nmt(canopen::NmtCommand::pre_operational, 0x11)));
  for (const auto command : {canopen::NmtCommand::stop, canopen::NmtCommand::reset_node, canopen::NmtCommand::reset_communication})
    EXPECT_FALSE(judge(canopen::nmt(command, 0x01)));
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0))) << "all at once";
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0x20)));
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0x7F)));
}

TEST_F(Gate, SdoWritesOnlyNodeParametersInTheirRange) {
  const auto write = [](std::uint8_t node, std::uint16_t index, std::uint8_t sub, float value) {
    return canopen::sdo(canopen::kSdoRequestBase + node, canopen::sdo_download_command(4), index, sub, std::bit_cast<std::uint32_t>(value));
  };
  view.mode = Mode::standby;
  EXPECT_TRUE(judge(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x1018, 2, 0)));
  EXPECT_FALSE(judge(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x7777, 2, 0)));
  EXPECT_TRUE(judge(write(0x01, 0x2200, 1, 0.12F)));
  EXPECT_TRUE(judge(write(0x02, 0x2200, 5, 12.0F))) << "the edge of the range";
  EXPECT_FALSE(judge(write(0x01, 0x2200, 5, 13.0F)));
  EXPECT_FALSE(judge(write(0x01, 0x2200, 1, NAN)));
  EXPECT_FALSE(judge(write(0x01, 0x2200, 3, 1.0F))) << "no parameter of the table";
  EXPECT_FALSE(judge(write(0x01, 0x60FF, 0, 1.0F))) << "no driving by SDO";
  EXPECT_FALSE(judge(write(0x11, 0x2200, 1, 0.12F))) << "not an object of a tilt sensor";
  EXPECT_TRUE(judge(write(0x11, 0x2102, 1, 0.0102F)));
  EXPECT_FALSE(judge(canopen::sdo(0x601, canopen::sdo_download_command(2), 0x2200, 1, 0))) << "two bytes of a float";
  EXPECT_FALSE(judge(canopen::sdo(0x630, canopen::kSdoUploadRequest, 0x1018, 2, 0)));
  view.mode = Mode::user;
  EXPECT_TRUE(judge(write(0x01, 0x2200, 1, 0.2F))) << "a live gain";
  EXPECT_FALSE(judge(write(0x01, 0x2200, 5, 6.0F))) << "the current limit needs standstill";
}

TEST_F(Gate, WhatReplacesARefusedCommandIsZero) {
  const CanFrame zero = gate.zero_command(0x201, view);
  EXPECT_EQ(contract::read_slot(zero, contract::pdo_slot(Pdo::drive_rx1, 0x60FF)), 0);
  EXPECT_EQ(contract::read_slot(zero, contract::pdo_slot(Pdo::drive_rx1, 0x6040)), canopen::drive::kEnable);
  view.mode = Mode::standby;
  EXPECT_EQ(contract::read_slot(gate.zero_command(0x202, view), contract::pdo_slot(Pdo::drive_rx1, 0x6040)), canopen::drive::kShutdown);
}

}  // namespace
}  // namespace hoist::core
