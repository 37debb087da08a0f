// The shown cause of a stop, what counts towards FAULT, and that every stop can be left (hazard table 2.3, H22).
#include <gtest/gtest.h>

#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::fault_bit;
using contract::Node;

constexpr std::uint16_t kBlocked = 0x7121, kEncoder = 0x7305;

std::uint8_t cause(Fault fault) { return static_cast<std::uint8_t>(static_cast<unsigned>(fault) + 1U); }

// The drive stops with this code: its emergency message first, then its status word.
void fail(ScriptedHoist& hoist, FakeDrive& drive, std::uint16_t code) {
  const Node node = &drive == &hoist.drive_left ? Node::drive_left : Node::drive_right;
  hoist.extra.push_back({contract::canopen::kEmcyBase + contract::node_id(node),
                         8,
                         0,
                         {static_cast<std::uint8_t>(code & 0xFFU), static_cast<std::uint8_t>(code >> 8U), 0x21, 0, 0, 0, 0, 0}});
  drive.fault = true;
  drive.status = 0x08;
}
void end_error(ScriptedHoist& hoist, Node node) {
  hoist.extra.push_back({contract::canopen::kEmcyBase + contract::node_id(node), 8, 0, {}});
}

void each_node(ScriptedHoist& hoist, bool silent) {
  for (FakeNode* node :
       {static_cast<FakeNode*>(&hoist.drive_left), static_cast<FakeNode*>(&hoist.drive_right), static_cast<FakeNode*>(&hoist.io),
        static_cast<FakeNode*>(&hoist.tilt_left), static_cast<FakeNode*>(&hoist.tilt_right), static_cast<FakeNode*>(&hoist.tilt_base)})
    node->silent = silent;
}

// A drive that drops out of a motion: the word to run goes on, the alarm comes after 50 ms, and the stop leads both to rest.
TEST(Recovery, H2ADriveThatDropsOutOfAMotionIsADriveFault) {
  for (const Mode mode : {Mode::user, Mode::remote})
    for (const bool left : {true, false})
      for (const std::uint16_t status : {0x40, 0x21}) {
        SCOPED_TRACE(testing::Message() << (left ? "left, " : "right, ") << status);
        ScriptedHoist hoist;
        ASSERT_TRUE(hoist.start(mode));
        const auto go_on = [&](int steps) { mode == Mode::user ? hoist.step(steps) : hoist.drive_for(steps, 0.8, 0.3); };
        if (mode == Mode::user) hoist.lean_gently(6, 0);
        go_on(100);
        ASSERT_GT(hoist.command_m_s(), 0.05);
        FakeDrive& drive = left ? hoist.drive_left : hoist.drive_right;
        drive.status = status;
        go_on(8);
        EXPECT_TRUE(hoist.has_fault(left ? Fault::drive_left_fault : Fault::drive_right_fault));
        hoist.step(100);
        EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
        EXPECT_EQ(drive.status, 0x27) << "the stop holds with both";
        EXPECT_FALSE(hoist.has_fault(Fault::gate_refused));
      }
}

// A line without a checksum damages the status of a drive that runs: led by it, the core itself would take one wheel out of the motion.
TEST(Recovery, H2ADamagedStatusTakesNoDriveOutOfAMotion) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 100);
  for (const bool left : {true, false})
    for (const std::uint16_t status : {0x00, 0x40, 0x21, 0x23, 0x07})
      for (int steps = 1; steps < 5; ++steps) {
        FakeDrive& drive = left ? hoist.drive_left : hoist.drive_right;
        for (int i = 0; i < steps; ++i) {
          drive.status = status;
          hoist.step();
          ASSERT_EQ(drive.last_control, 0x0F) << status;
        }
        drive.status = 0x27;
        hoist.step(20);
        ASSERT_EQ(hoist.state.mode, Mode::user) << status << ", " << steps;
        ASSERT_EQ(hoist.state.latched, 0U);
      }
}

// A door sill blocks a wheel any number of times: the therapist frees it and continues.
TEST(Recovery, H22AWheelBlockedByTheFloorNeverLeadsToFault) {
  for (const bool left : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    FakeDrive& drive = left ? hoist.drive_left : hoist.drive_right;
    for (int i = 0; i < 5; ++i) {
      fail(hoist, drive, kBlocked);
      hoist.step(150);
      ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
      EXPECT_EQ(hoist.out.record.stop_cause, cause(left ? Fault::drive_left_fault : Fault::drive_right_fault));
      EXPECT_EQ(left ? hoist.out.record.drive_left_fault_code : hoist.out.record.drive_right_fault_code, kBlocked);
      static_cast<void>(acknowledge_as(hoist, kTherapist));
      end_error(hoist, left ? Node::drive_left : Node::drive_right);
      ASSERT_TRUE(hoist.reach(Mode::standby, 60)) << i;
      EXPECT_EQ(hoist.out.record.drive_left_fault_code, 0);
      hoist.step(100);
    }
    EXPECT_FALSE(hoist.has_fault(Fault::control_fault));
  }
}

TEST(Recovery, H22AnEncoderThatFailsThreeTimesStillDoes) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 3; ++i) {
    fail(hoist, hoist.drive_left, kEncoder);
    hoist.step(150);
    static_cast<void>(acknowledge_as(hoist, kTherapist));
    end_error(hoist, Node::drive_left);
    hoist.step(100);
  }
  EXPECT_TRUE(hoist.reach(Mode::fault, 200));
  EXPECT_EQ(hoist.out.record.drive_left_fault_code, kEncoder) << "what it was about is still told";
  EXPECT_EQ(hoist.out.record.stop_cause, cause(Fault::drive_left_fault)) << "and what it was for";
}

// The code of an emergency message that was lost comes with the drive's second process data, up to 50 ms later.
TEST(Recovery, ACodeThatComesLateIsStillTheCauses) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.fault = true;
  hoist.drive_left.status = 0x08;
  hoist.step(5);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.out.record.drive_left_fault_code, 0);
  fail(hoist, hoist.drive_left, kBlocked);
  hoist.step(5);
  EXPECT_EQ(hoist.out.record.drive_left_fault_code, kBlocked);
}

TEST(Recovery, H22ATwistedPelvisNeverLeadsToFaultAndIsCalledWhatItIs) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 5; ++i) {
    hoist.lean(0, 26);
    hoist.step(150);
    ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
    EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible));
    EXPECT_EQ(hoist.out.record.tilt_implausible_code, 1);
    hoist.lean(0, 0);
    hoist.step(200);
    ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U) << i;
  }
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(hoist.out.record.tilt_implausible_code, 0);
}

// H1: a wheel that is slower than commanded under full current is held; one without current has lost its drive.
TEST(Recovery, H1AWheelThatIsHeldBackIsNotTheMachinesFault) {
  for (const bool pushes : {true, false}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(200, 0.9);
    hoist.drive_left.forced_m_s = 0;
    hoist.drive_left.current_a = pushes ? 5.4 : 0.6;
    hoist.drive_for(40, 0.9);
    ASSERT_TRUE(hoist.has_fault(Fault::overspeed));
    EXPECT_EQ(hoist.out.record.overspeed_code, pushes ? 1 : 0);
  }
}

// The cable is cut behind the interface, which does not notice: every node is silent, and one alarm gives the cause.
TEST(Recovery, H5ACutCableIsCalledOne) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  each_node(hoist, true);
  hoist.step(20);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_TRUE(hoist.has_fault(Fault::bus_down));
  EXPECT_EQ(hoist.out.record.stop_cause, cause(Fault::bus_down));
}

// Nodes are lost before the interface reports bus-off.
TEST(Recovery, H5ACauseThatIsFoundLaterTakesThePlaceOfItsConsequence) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.tilt_left.silent = hoist.drive_right.silent = true;
  hoist.step(8);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_NE(hoist.out.record.stop_cause, cause(Fault::bus_down));
  hoist.bus_up = false;
  hoist.step();
  EXPECT_EQ(hoist.out.record.stop_cause, cause(Fault::bus_down));
}

// A fault a minute later is a separate one.
TEST(Recovery, ACauseThatComesLaterThanASecondIsNotTheFirst) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.tilt_left.silent = true;
  hoist.step(200);
  hoist.bus_up = false;
  hoist.step(10);
  EXPECT_EQ(hoist.out.record.stop_cause, cause(Fault::tilt_left_lost));
}

TEST(Recovery, H22ConsequencesDoNotCount) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  each_node(hoist, true);
  hoist.step(120);
  const StopHistory history = stop_history(hoist.state);
  ASSERT_EQ(history.count, 1U);
  EXPECT_EQ(history.stops[0].fault, static_cast<std::uint64_t>(Fault::bus_down));
}

// A drive that has died must not hold the hoist for ever: the patient is freed, the hoist waits in INIT and can be served.
TEST(Recovery, H3ASilentDriveLeadsToInitByAcknowledgement) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.drive_left.silent = true;
  hoist.step(200);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_NE(acknowledge_as(hoist, kTherapist) & refusal_bit(Refusal::cause_not_cleared), 0U) << "it may be back at once";
  hoist.step(200);
  hoist.drive_right.forced_m_s = 0.1;
  hoist.step(5);
  EXPECT_NE(acknowledge_as(hoist, kTherapist), 0U) << "the other wheel turns";
  hoist.drive_right.forced_m_s = 0;
  hoist.tilt_base.yaw_rate_deg_s = 6;
  hoist.step(150);
  EXPECT_NE(acknowledge_as(hoist, kTherapist), 0U) << "the chassis turns about the wheel that is heard";
  hoist.tilt_base.yaw_rate_deg_s = 0;
  hoist.step(150);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  EXPECT_EQ(hoist.state.latched, 0U);
  hoist.step(500);
  EXPECT_EQ(hoist.state.mode, Mode::init) << "it waits for its drive";
  EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(Refusal::nodes_missing), 0U);
  EXPECT_NE(hoist.drive_right.last_control, 0x0F) << "with the other one off";
  hoist.drive_left = FakeDrive{};
  EXPECT_TRUE(hoist.reach(Mode::standby));
}

// A fault that acknowledgement clears does not block it: the other drive's fault is reset with it.
TEST(Recovery, ASilentDriveBesideOneInFaultLeadsToInitToo) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.silent = true;
  fail(hoist, hoist.drive_right, kEncoder);
  hoist.step(500);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  hoist.step(60);
  EXPECT_FALSE(hoist.drive_right.fault);
}

TEST(Recovery, ACauseThatIsNoSilenceIsNotLeftThatWay) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_left.silent = true;
  hoist.tilt_right.alpha_deg = hoist.tilt_right.alpha_now_deg = 25;
  hoist.step(500);
  EXPECT_NE(acknowledge_as(hoist, kEngineer) & refusal_bit(Refusal::cause_not_cleared), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

TEST(Recovery, TheEmergencyStopIsLeftWithASilentDrive) {
  for (const bool both : {false, true}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.drive_left.silent = true;
    hoist.drive_right.silent = both;
    hoist.step(100);
    hoist.io.switches = 1;
    hoist.step(200);
    ASSERT_EQ(hoist.state.mode, Mode::emergency_stop);
    hoist.io.switches = 0;
    hoist.step(100);
    ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
    EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
    EXPECT_EQ(hoist.state.mode, Mode::init);
  }
}

TEST(Recovery, H22TheThirdLossOfADriveGoesOutOfServiceAlthoughTheDriveIsSilent) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 2; ++i) {
    hoist.drive_left.silent = true;
    hoist.step(10);
    hoist.drive_left.silent = false;
    hoist.step(300);
    ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
    hoist.step(100);
  }
  hoist.drive_left.silent = true;
  EXPECT_TRUE(hoist.reach(Mode::fault, 500));
  hoist.step(200);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U) << "a plug is the therapist's to mend";
  EXPECT_EQ(hoist.state.mode, Mode::init);
}

// ---- a restart of the core

TEST(Restart, H22TheCountGoesOn) {
  StopHistory stored;
  bool told = false;
  {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    for (int i = 0; i < 2; ++i) {
      hoist.tilt_left.silent = true;
      hoist.step(10);
      hoist.tilt_left.silent = false;
      for (int k = 0; k < 300; ++k) {
        hoist.step();
        if (!hoist.out.stops_changed) continue;
        told = true;
        stored = stop_history(hoist.state);
      }
      ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
    }
    ASSERT_EQ(hoist.state.mode, Mode::standby);
  }
  ASSERT_TRUE(told);
  ASSERT_EQ(stored.count, 2U);
  for (const bool in_time : {true, false}) {
    ScriptedHoist hoist;
    // The clock of another start of the computer: what was before it has a negative time.
    StopHistory known = stored;
    for (std::size_t i = 0; i < known.count; ++i) known.stops[i].time_ns = in_time ? -300'000'000'000 : -700'000'000'000;
    restore_stops(hoist.state, known);
    ASSERT_TRUE(hoist.ready());
    hoist.tilt_left.silent = true;
    hoist.step(10);
    hoist.tilt_left.silent = false;
    EXPECT_EQ(hoist.reach(Mode::fault, 300), in_time);
  }
}

TEST(Restart, H22OutOfServiceStaysSoUntilItIsAcknowledged) {
  ScriptedHoist hoist;
  StopHistory known;
  known.out_of_service = fault_bit(Fault::control_fault) | fault_bit(Fault::tilt_frozen);
  restore_stops(hoist.state, known);
  hoist.step(300);
  EXPECT_EQ(hoist.state.mode, Mode::fault);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_frozen)) << "what it was about is still told";
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(acknowledge_as(hoist, kEngineer), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby));
  EXPECT_EQ(stop_history(hoist.state).out_of_service, 0U);
  EXPECT_EQ(stop_history(hoist.state).count, 0U);
}

TEST(Restart, H1ANewStartGivesARunawayHoistNoSupply) {
  ScriptedHoist hoist;
  StopHistory known;
  known.out_of_service = fault_bit(Fault::control_fault) | fault_bit(Fault::overspeed);
  restore_stops(hoist.state, known);
  hoist.step(300);
  EXPECT_TRUE(hoist.state.relay.is_cut());
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_EQ(acknowledge_as(hoist, kEngineer), 0U);
  EXPECT_FALSE(hoist.state.relay.is_cut());
}

TEST(Restart, WhatIsNoHistoryChangesNothing) {
  ScriptedHoist hoist;
  StopHistory wild;
  wild.count = ~0ULL;
  wild.out_of_service = fault_bit(Fault::stop_pressed) | fault_bit(Fault::emergency_stop);
  restore_stops(hoist.state, wild);
  EXPECT_TRUE(hoist.to_standby());
  EXPECT_LE(stop_history(hoist.state).count, wild.stops.size());
  restore_stops(hoist.state, {.stops = {}, .count = 0, .out_of_service = fault_bit(Fault::control_fault)});
  EXPECT_EQ(hoist.state.mode, Mode::standby) << "only before the first step";
}

// ---- the headline

constexpr contract::FaultBits bits(std::initializer_list<Fault> faults) {
  contract::FaultBits all = 0;
  for (const Fault fault : faults) all |= fault_bit(fault);
  return all;
}

TEST(Headline, TheCauseIsToldBeforeItsConsequences) {
  const contract::FaultBits cut = bits({Fault::tilt_left_lost, Fault::tilt_right_lost, Fault::tilt_base_lost, Fault::drive_left_lost,
                                        Fault::drive_right_lost, Fault::io_lost, Fault::bus_down});
  EXPECT_EQ(contract::headline(cut), Fault::bus_down);
  EXPECT_EQ(contract::headline(cut, cause(Fault::tilt_left_lost)), Fault::bus_down);
  EXPECT_EQ(contract::consequences(cut), cut & ~fault_bit(Fault::bus_down));
}

TEST(Headline, ThePatientGoesFirst) {
  EXPECT_EQ(contract::headline(bits({Fault::tilt_left_lost, Fault::fall_detected}), cause(Fault::tilt_left_lost)), Fault::fall_detected);
  EXPECT_EQ(contract::headline(bits({Fault::tilt_left_lost, Fault::control_fault}), cause(Fault::tilt_left_lost)), Fault::control_fault);
}

TEST(Headline, OtherwiseWhatCameFirst) {
  const contract::FaultBits two = bits({Fault::tilt_left_lost, Fault::tilt_frozen, Fault::battery_low});
  EXPECT_EQ(contract::headline(two, cause(Fault::tilt_frozen)), Fault::tilt_frozen);
  EXPECT_EQ(contract::headline(two, cause(Fault::bumper_pressed)), Fault::tilt_left_lost) << "it is no longer in force";
  EXPECT_EQ(contract::headline(two), Fault::tilt_left_lost);
}

}  // namespace
}  // namespace hoist::core::test
