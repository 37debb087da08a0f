// Service: nodes get new programs through the running core. Permissions, allowed frames, end, and no motion meanwhile.
#include <gtest/gtest.h>

#include <bit>
#include <initializer_list>
#include <limits>

#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

namespace canopen = contract::canopen;
using contract::CanFrame;
using contract::Node;
using contract::Role;

constexpr auto kEngineer = static_cast<std::uint32_t>(Role::engineer);
constexpr contract::FaultBits kProtective = faults_with(contract::Reaction::protective_stop);
constexpr std::uint32_t kRequest = canopen::kSdoRequestBase + contract::node_id(Node::tilt_left);

CanFrame ask_product(Node node = Node::tilt_left) {
  return canopen::sdo(canopen::kSdoRequestBase + contract::node_id(node), canopen::kSdoUploadRequest, 0x1018, 2, 0);
}

class ServiceTest : public ::testing::Test {
 protected:
  ScriptedHoist hoist;

  std::uint32_t begin(std::uint32_t client = 7, std::uint32_t role = kEngineer) {
    return hoist.ask(CommandKind::begin_service, client, 0, role);
  }
  std::uint32_t send(const CanFrame& frame, std::uint32_t client = 7) {
    return hoist.send(CommandKind::service_frame, client, frame.id, 0, std::bit_cast<double>(frame.data), frame.dlc);
  }
  std::uint32_t ask(const CanFrame& frame, std::uint32_t client = 7) {
    const std::uint32_t id = send(frame, client);
    hoist.step();
    return hoist.answer(id);
  }
  int left(const CanFrame& frame) const {
    int n = 0;
    for (const CanFrame& f : hoist.sent) n += f.id == frame.id && f.data == frame.data ? 1 : 0;
    return n;
  }
  bool on() const { return hoist.state.in_mode.service.on; }
  void in_service() {
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(begin(), 0U);
    ASSERT_TRUE(on());
    ASSERT_EQ(hoist.state.mode, Mode::init);
  }
  /// Frames of a step in service: drives off, heartbeat, SYNC, and at most one frame of the tool.
  void expect_hands_off(int& of_the_tool) {
    for (const CanFrame& f : hoist.sent) {
      const auto function = f.id & 0x780U;
      if (f.id == canopen::kSync || function == canopen::kHeartbeatBase) continue;
      if (f.id == contract::pdo_cob_id(contract::Pdo::io_rx1, Node::io)) continue;  // the relay stays fed
      if (f.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, Node::drive_left) ||
          f.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, Node::drive_right)) {
        const auto control = contract::read_slot(f, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040));
        EXPECT_NE(control, canopen::drive::kEnable);
        EXPECT_NE(control, canopen::drive::kSwitchOn);
        EXPECT_EQ(contract::read_slot(f, contract::pdo_slot(contract::Pdo::drive_rx1, 0x60FF)), 0);
        continue;
      }
      ++of_the_tool;
    }
  }
};

TEST_F(ServiceTest, IsForAnEngineerWithTheLease) {
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(begin(7, static_cast<std::uint32_t>(Role::viewer)), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(7, static_cast<std::uint32_t>(Role::therapist)), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(7, kEngineer + 1), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(8), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(begin(8, 0), refusal_bit(Refusal::no_lease) | refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(hoist.ask(CommandKind::end_service), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_FALSE(on());
  EXPECT_EQ(begin(), 0U);
  EXPECT_TRUE(on());
  EXPECT_EQ(ask(ask_product(), 8), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(hoist.ask(CommandKind::end_service, 8), refusal_bit(Refusal::no_lease));
  EXPECT_TRUE(on());
}

TEST_F(ServiceTest, IsRefusedWhereAnythingMovesOrIsHeld) {
  for (const Mode mode : {Mode::user, Mode::remote, Mode::protective_stop}) {
    hoist = ScriptedHoist();
    if (mode == Mode::protective_stop) {
      ASSERT_TRUE(hoist.ready());
      ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
    } else {
      ASSERT_TRUE(hoist.start(mode));
    }
    ASSERT_EQ(hoist.state.mode, mode);
    EXPECT_EQ(begin(), refusal_bit(Refusal::not_standby) | (mode == Mode::protective_stop ? refusal_bit(Refusal::fault_active) : 0U));
    EXPECT_EQ(ask(ask_product()), refusal_bit(Refusal::out_of_order));
    EXPECT_EQ(left(ask_product()), 0);
    EXPECT_EQ(hoist.state.mode, mode);
    EXPECT_FALSE(on());
  }
}

TEST_F(ServiceTest, IsRefusedToAHoistThatIsBeingPushed) {
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.2;
  hoist.step(100);
  EXPECT_EQ(begin(), refusal_bit(Refusal::moving));
  EXPECT_FALSE(on());
}

TEST_F(ServiceTest, NothingPassesOutsideOfIt) {
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(ask(ask_product()), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(left(ask_product()), 0);
  EXPECT_FALSE(hoist.has_fault(Fault::gate_refused));
}

TEST_F(ServiceTest, OneFrameAStepPassesAndNobodyElseAsksWhileTheDrivesStayOff) {
  in_service();
  const std::uint32_t requests = hoist.tilt_left.sdo_requests;
  for (int i = 0; i < 500; ++i) {
    // A restarting node is accessed only by the tool: a request of the core would abort its transfer.
    if (i == 100) hoist.tilt_left.booted = false;
    const std::uint32_t first = send(ask_product()), second = send(ask_product());
    hoist.step();
    EXPECT_EQ(hoist.answer(first), 0U);
    EXPECT_EQ(hoist.answer(second), refusal_bit(Refusal::out_of_order));
    int of_the_tool = 0;
    expect_hands_off(of_the_tool);
    EXPECT_EQ(of_the_tool, 1);
    EXPECT_EQ(left(ask_product()), 1);
    ASSERT_EQ(hoist.state.mode, Mode::init);
  }
  EXPECT_EQ(hoist.tilt_left.sdo_requests, requests + 500);
  EXPECT_FALSE(hoist.has_fault(Fault::gate_refused));
  ASSERT_EQ(hoist.ask(CommandKind::end_service), 0U);
  EXPECT_TRUE(hoist.to_standby()) << "afterwards the core configures its nodes from the start";
  EXPECT_EQ(hoist.state.latched & kProtective, 0U);
}

TEST_F(ServiceTest, OnlyTheFramesOfAnUpdatePass) {
  in_service();
  const auto node = contract::node_id(Node::tilt_left);
  const auto sdo = [](std::uint8_t command, std::uint16_t index, std::uint8_t sub, std::uint32_t id = kRequest) {
    return canopen::sdo(id, command, index, sub, 1);
  };
  for (const CanFrame& frame : {sdo(0x2F, 0x1F51, 1), sdo(0x21, 0x1F50, 1), sdo(0x2F, 0x1F57, 1), sdo(0x40, 0x2F00, 1),
                                sdo(0x40, 0x6010, 0), sdo(0x00, 0, 0), sdo(0x11, 0x1234, 5), sdo(0x70, 0, 0), sdo(0x80, 0x1F50, 1),
                                canopen::nmt(canopen::NmtCommand::pre_operational, node), canopen::nmt(canopen::NmtCommand::start, node)}) {
    EXPECT_EQ(ask(frame), 0U) << std::hex << frame.id << " " << int{frame.data[0]};
    EXPECT_EQ(left(frame), 1);
  }
  CanFrame shorter = ask_product(), extended = ask_product();
  shorter.dlc = 7;
  extended.id |= 0x10000;
  const contract::ParamObject& own = contract::kParamObjects[0];
  for (const CanFrame& frame :
       {sdo(0x23, 0x1017, 0), sdo(0x2F, 0x1F4F, 1), sdo(0x2F, 0x1F58, 1), sdo(0x2F, 0x1F51, 0), sdo(0x2F, 0x1F51, 2),
        // What the core itself may write is not the tool's.
        sdo(0x23, own.index, own.sub,
            canopen::kSdoRequestBase + contract::node_id(own.kind == contract::NodeKind::drive ? Node::drive_left : Node::tilt_left)),
        sdo(0xC0, 0x1F50, 1), sdo(0xA0, 0x1F50, 1), sdo(0xE0, 0x1F50, 1), sdo(0x81, 0x1F50, 1),
        sdo(0x40, 0x1018, 2, canopen::kSdoRequestBase + contract::node_id(Node::core)), sdo(0x40, 0x1018, 2, canopen::kSdoRequestBase + 5),
        sdo(0x40, 0x1018, 2, canopen::kSdoRequestBase), shorter, extended, canopen::nmt(canopen::NmtCommand::reset_node, node),
        canopen::nmt(canopen::NmtCommand::stop, node), canopen::nmt(canopen::NmtCommand::start, 0),
        canopen::nmt(canopen::NmtCommand::pre_operational, contract::node_id(Node::core)), canopen::sync(),
        canopen::heartbeat(contract::node_id(Node::core), canopen::NmtState::operational),
        CanFrame{contract::pdo_cob_id(contract::Pdo::drive_rx1, Node::drive_left), 6, 0, {0x0F, 0, 1}}}) {
    EXPECT_EQ(ask(frame), refusal_bit(Refusal::out_of_range)) << std::hex << frame.id << " " << int{frame.data[0]};
    int of_the_tool = 0;
    expect_hands_off(of_the_tool);
    EXPECT_EQ(of_the_tool, 0);
  }
  for (const double dlc : {-1.0, 7.5, 9.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(hoist.ask(CommandKind::service_frame, 7, kRequest, 0, std::bit_cast<double>(ask_product().data), dlc),
              refusal_bit(Refusal::out_of_range));
  }
  EXPECT_TRUE(on());
  EXPECT_FALSE(hoist.has_fault(Fault::gate_refused)) << "what is refused at the door never comes to the gate";
}

TEST_F(ServiceTest, TheGateJudgesByItself) {
  const CanFrame start = canopen::sdo(kRequest, 0x2F, 0x1F51, 1, 1);
  for (const Mode mode : {Mode::init, Mode::standby, Mode::user, Mode::remote, Mode::protective_stop}) {
    for (const bool service : {false, true}) {
      GateView view{mode, false, false, false, service};
      EXPECT_EQ(SafetyGate::judge(start, view), mode == Mode::init && service);
    }
  }
  const GateView view{Mode::init, false, false, false, true};
  EXPECT_FALSE(SafetyGate::judge(canopen::sdo(kRequest, 0x23, 0x1017, 0, 0), view));
  EXPECT_FALSE(SafetyGate::judge(canopen::nmt(canopen::NmtCommand::reset_node, 17), view));
  // Drive commands are checked as a pair, and no drive may run in service: both, or either alone.
  const auto drive = [](Node node, std::uint16_t control) {
    CanFrame frame{contract::pdo_cob_id(contract::Pdo::drive_rx1, node), 6, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_rx1, 0x6040), control);
    return frame;
  };
  const contract::Params params;
  const Derived derived = derive(params);
  const auto judge_pair = [&](std::uint16_t left, std::uint16_t right, const GateView& seen) {
    SafetyGate gate;
    return gate.judge_drives(drive(Node::drive_left, left), drive(Node::drive_right, right), seen, params, derived, kTick_s);
  };
  EXPECT_TRUE(judge_pair(canopen::drive::kEnable, canopen::drive::kEnable, {Mode::user, false, false, false, false}))
      << "the pair is sound";
  for (const Mode mode : {Mode::init, Mode::standby}) {
    const GateView serviced{mode, false, false, false, true};
    EXPECT_TRUE(judge_pair(0, 0, serviced));
    EXPECT_FALSE(judge_pair(canopen::drive::kEnable, canopen::drive::kEnable, serviced));
    EXPECT_FALSE(judge_pair(canopen::drive::kEnable, 0, serviced));
    EXPECT_FALSE(judge_pair(0, canopen::drive::kEnable, serviced));
  }
}

TEST_F(ServiceTest, EndsTwoSecondsAfterTheLastWord) {
  in_service();
  hoist.step(150);
  EXPECT_EQ(ask(ask_product()), 0U);
  hoist.step(150);
  EXPECT_TRUE(on());
  EXPECT_EQ(begin(), 0U) << "a word without a frame";
  hoist.step(198);
  EXPECT_TRUE(on());
  hoist.step(2);
  EXPECT_FALSE(on());
  EXPECT_EQ(ask(ask_product()), refusal_bit(Refusal::out_of_order));
  EXPECT_TRUE(hoist.to_standby());
  EXPECT_EQ(hoist.state.latched & kProtective, 0U);
}

TEST_F(ServiceTest, EndsWithItsLeaseOrItsServer) {
  for (int how = 0; how < 3; ++how) {
    hoist = ScriptedHoist();
    in_service();
    if (how == 0) {
      EXPECT_EQ(hoist.ask(CommandKind::release_lease), 0U);
    } else if (how == 1) {
      EXPECT_EQ(hoist.ask(CommandKind::take_lease, 8, 1), 0U);
    } else {
      hoist.server_up = false;
      hoist.step(30);
    }
    hoist.step();
    EXPECT_FALSE(on()) << how;
    EXPECT_TRUE(hoist.to_standby()) << how;
  }
}

TEST_F(ServiceTest, STOPEndsItAndHolds) {
  in_service();
  EXPECT_EQ(hoist.ask(CommandKind::stop, 9), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_FALSE(on());
  EXPECT_EQ(ask(ask_product()), refusal_bit(Refusal::out_of_order));
  hoist.step(150);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

TEST_F(ServiceTest, ANodeThatGoesAwayNeedsNoAcknowledgement) {
  in_service();
  hoist.events.clear();
  FakeNode* const nodes[] = {&hoist.tilt_left, &hoist.drive_right, &hoist.io};
  for (FakeNode* node : nodes) node->silent = true;
  for (int i = 0; i < 500; ++i) {
    if (i % 100 == 0) {
      EXPECT_EQ(ask(ask_product(Node::tilt_right)), 0U);
    } else {
      hoist.step();
    }
    EXPECT_EQ(hoist.state.mode, Mode::init);
    EXPECT_EQ(hoist.state.latched & kProtective, 0U);
  }
  EXPECT_EQ(hoist.ask(CommandKind::end_service), 0U);
  hoist.step(300);
  EXPECT_EQ(hoist.state.mode, Mode::init) << "not everybody is there";
  for (FakeNode* node : nodes) {
    node->silent = false;
    node->booted = false;
  }
  EXPECT_TRUE(hoist.to_standby());
  EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
}

// Otherwise a program that was cut off could only be sent by the tool, with the core ended.
TEST_F(ServiceTest, CanBeginAgainInINIT) {
  in_service();
  hoist.drive_left.silent = true;
  EXPECT_EQ(hoist.ask(CommandKind::end_service), 0U);
  hoist.step(100);
  ASSERT_EQ(hoist.state.mode, Mode::init);
  EXPECT_EQ(begin(7, static_cast<std::uint32_t>(Role::therapist)), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(8), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(begin(), 0U);
  EXPECT_TRUE(on());
  EXPECT_EQ(ask(ask_product()), 0U);
}

// A loader with a valid program starts it after a minute without requests.
TEST_F(ServiceTest, ANodeThatStaysInItsLoaderIsAskedTwiceAndThenLeftAlone) {
  in_service();
  hoist.tilt_left.product_bits = contract::kLoaderProduct;
  hoist.tilt_left.booted = false;
  const std::uint32_t asked = hoist.tilt_left.sdo_requests;
  const auto written = hoist.tilt_left.written.size();
  EXPECT_EQ(hoist.ask(CommandKind::end_service), 0U);
  hoist.step(6500);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  EXPECT_EQ(hoist.tilt_left.sdo_requests, asked + 2) << "a garbled answer alone keeps nobody away";
  EXPECT_EQ(hoist.tilt_left.written.size(), written);
  hoist.tilt_left.product_bits = 0;
  hoist.tilt_left.booted = false;
  EXPECT_TRUE(hoist.to_standby()) << "its boot-up message is heard at once";
}

}  // namespace
}  // namespace hoist::core::test
