// The drive on a motor, commanded over its own frames. Times are milliseconds of virtual time.
#include "firmware/nodes/drive/drive_node.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/firmware/drive_fixture.hpp"

namespace hoist::firmware {
namespace {

class DriveTest : public DriveFixture {};

TEST_F(DriveTest, ReachesOperationInOrderAndTheBridgeIsOffUntilThen) {
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  run(20, kEnable, 50);  // enabling without the steps before it
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  run(10, kShutdown, 50);
  EXPECT_EQ(canopen::drive::state(status()), State::ready);
  run(10, kSwitchOn, 50);
  EXPECT_EQ(canopen::drive::state(status()), State::switched_on);
  EXPECT_FALSE(board_.bridge_on);
  run(10, kEnable, 50);
  EXPECT_EQ(canopen::drive::state(status()), State::operation_enabled);
  EXPECT_TRUE(board_.bridge_on);
  run(500, kEnable, 50);
  EXPECT_NEAR(motor_.speed_rad_s(), 50, 0.5);
  EXPECT_EQ(status() & 0x1610, 0x0610);  // target reached, remote, voltage, not at zero
  EXPECT_NEAR((node_.stack().values().get<0x606C>()), 50000, 3000);
  run(10, kSwitchOn, 50);  // disable operation: ramps down first
  EXPECT_EQ(node_.state(), State::operation_enabled);
  run(400, kSwitchOn, 50);
  EXPECT_EQ(node_.state(), State::switched_on);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  EXPECT_FALSE(board_.bridge_on);
  run(10, kShutdown, 0);
  EXPECT_EQ(node_.state(), State::ready);
  run(10, kOff, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveTest, H15_EnabledAgainOnTheWayToStandstillItGoesOnWithoutAJump) {
  // The last: an order to run from which a serial line without a checksum took a bit.
  for (const int leave : {int{kShutdown}, int{kSwitchOn}, kEnable & ~1}) {
    SCOPED_TRACE(leave);
    start_anew(loaded_motor());
    drive_at(100);
    run(150, leave, 100);
    EXPECT_EQ(node_.state(), State::operation_enabled);
    float before = node_.reference_rad_s();
    EXPECT_NEAR(before, 55, 4);  // 300 rad/s2
    peak_current_a_ = 0;
    for (int i = 0; i < 1000; ++i) {
      run(1, kEnable, 100);
      ASSERT_EQ(node_.state(), State::operation_enabled);
      ASSERT_TRUE(board_.bridge_on);
      ASSERT_LE(std::fabs(node_.reference_rad_s() - before), 0.451F);  // 450 rad/s2 are the most
      before = node_.reference_rad_s();
    }
    EXPECT_NEAR(motor_.speed_rad_s(), 100, 1);
    EXPECT_TRUE(emergencies().empty());
  }
}

TEST_F(DriveTest, H15_EnabledAgainAtRestItHoldsAndTheNextLeavingTakesItsWholeTime) {
  for (const int leave : {kShutdown, kSwitchOn}) {
    SCOPED_TRACE(leave);
    start_anew(loaded_motor());
    enable();
    run(100, kEnable, 0);
    while (now_ms_ % 10 != 0) run(1, kEnable, 0);
    run(10, leave, 0);  // half of the required time at rest
    load_n_m_ = -0.3;
    for (int i = 0; i < 1000; ++i) {
      run(1, kEnable, 0);
      ASSERT_EQ(node_.state(), State::operation_enabled);
      ASSERT_TRUE(board_.bridge_on);
    }
    EXPECT_NEAR(motor_.speed_rad_s(), 0, 1);
    load_n_m_ = 0;
    run(1000, kEnable, 0);
    run(19, leave, 0);
    EXPECT_TRUE(board_.bridge_on);
    run(10, leave, 0);
    EXPECT_FALSE(board_.bridge_on);
    EXPECT_EQ(node_.state(), leave == kShutdown ? State::ready : State::switched_on);
  }
}

TEST_F(DriveTest, AQuickStopIsNotTakenBack) {
  enable();
  run(100, kEnable, 100);
  run(10, kQuickStop, 100);
  run(10, kShutdown, 100);
  run(10, kEnable, 100);
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  run(1000, kEnable, 100);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, ShutdownToEnableInOneStepAsTheStandardAllows) {
  run(10, kShutdown, 0);
  run(10, kEnable, 0);
  EXPECT_EQ(node_.state(), State::operation_enabled);
}

TEST_F(DriveTest, TheReferenceRampsAndTheSpeedFollows) {
  enable();
  int reached = until(
      1000, [&] { return node_.reference_rad_s() >= 90; }, [&] { run(1, kEnable, 90); });
  EXPECT_NEAR(reached, 200, 12);  // 450 rad/s2
  run(300, kEnable, 90);
  EXPECT_NEAR(motor_.speed_rad_s(), 90, 1);
  run(1000, kEnable, -90);
  EXPECT_NEAR(motor_.speed_rad_s(), -90, 1);
  run(1000, kHalt, -90);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 1);
  EXPECT_TRUE(board_.bridge_on);  // halted is held, not released
}

// H5, H23: commands are missing, for any cause.
TEST_F(DriveTest, RpdoDeadlineBrakesWithinFiftyMilliseconds) {
  drive_at(150);
  const double before = node_.reference_rad_s();
  const int braking = until(
      100, [&] { return node_.reference_rad_s() < before - 0.5F; }, [&] { silence(1); });
  EXPECT_GT(braking, 20);      // one lost command is tolerated
  EXPECT_LE(braking + 9, 50);  // the last command may have come up to 9 ms before
  silence(1);
  EXPECT_EQ(emergencies(), std::vector{0x8250});
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  const int off = until(
      2000, [&] { return !board_.bridge_on; }, [&] { silence(1); });
  EXPECT_NEAR(off, 560, 40);  // 150 / 300 s, the loop's lag and a moment at rest
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  silence(5000);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, AfterALossTheOldWordDoesNotEnableAgain) {
  drive_at(100);
  silence(60);
  run(2000, kEnable, 100);  // the computer returns and continues as before
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  enable();
}

TEST_F(DriveTest, LostCommandsInARowAreToleratedUpToTheDeadline) {
  drive_at(100);
  for (int i = 0; i < 600; ++i) {
    if (now_ms_ % 30 == 0) node_.on_frame(rpdo(kEnable, 100));  // two of three are lost
    if (now_ms_ % 100 == 0) node_.on_frame(canopen::heartbeat(0x7F, canopen::NmtState::operational));
    one_ms();
  }
  EXPECT_EQ(node_.state(), State::operation_enabled);
  EXPECT_TRUE(emergencies().empty());
}

TEST_F(DriveTest, LosingTheComputersHeartbeatStopsAlthoughCommandsGoOn) {
  drive_at(100);
  heartbeats_ = false;
  const int stopping = until(
      400, [&] { return node_.state() == State::quick_stop_active; }, [&] { run(1, kEnable, 100); });
  EXPECT_GT(stopping, 140);
  EXPECT_LE(stopping, 251);
  EXPECT_EQ(node_.stack().state(), canopen::NmtState::pre_operational);
  run(2000, kEnable, 100);
  EXPECT_EQ(emergencies().at(0), 0x8130);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
}

// H23: the control program crashed and was started again.
TEST_F(DriveTest, ARestartedComputerIsALostOne) {
  drive_at(100);
  node_.on_frame(canopen::heartbeat(0x7F, canopen::NmtState::boot_up));
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  run(2000, kEnable, 100);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, LeavingOperationalStopsOnTheRamp) {
  for (const canopen::NmtCommand command :
       {canopen::NmtCommand::pre_operational, canopen::NmtCommand::stop, canopen::NmtCommand::reset_communication}) {
    node_.power_on();
    begin();
    drive_at(100);
    node_.on_frame(canopen::nmt(command, 1));
    EXPECT_EQ(node_.state(), State::quick_stop_active);
    run(100, kEnable, 100);
    EXPECT_NEAR(node_.reference_rad_s(), 70, 1);
    EXPECT_NEAR(motor_.speed_rad_s(), 85, 5);  // the loop follows its reference 50 ms later
    run(1000, kEnable, 100);
    EXPECT_FALSE(board_.bridge_on);
    EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  }
}

TEST_F(DriveTest, ResetNodeSwitchesOffAtOnce) {
  drive_at(100);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 1));
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_EQ(node_.state(), State::not_ready);
  silence(25);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveTest, QuickStopUsesItsOwnRampAndEndsDisabled) {
  drive_at(150);
  const int stopped = until(
      2000, [&] { return node_.reference_rad_s() == 0.0F; }, [&] { run(1, kQuickStop, 150); });
  EXPECT_NEAR(stopped, 500, 15);  // 300 rad/s2, 1.0 m/s2 at the wheel
  run(100, kQuickStop, 150);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, QuickStopOptionSixStaysAndHolds) {
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(2), 0x605A, 0, 6)).data[0], 0x60);
  drive_at(100);
  run(1500, kQuickStop, 100);
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  EXPECT_TRUE(board_.bridge_on);
  EXPECT_NE(status() & 0x400, 0) << "stopped, which was the target";
  run(500, kEnable, 100);  // does not run on
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  silence(1000);  // and the loss of the computer ends the holding
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, DisableVoltageLetsGoAtOnce) {
  drive_at(100);
  run(1, kOff, 100);
  while (now_ms_ % 10 != 1) run(1, kOff, 100);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, RefusedCommandsAreNoSignOfLife) {
  drive_at(100);
  for (int i = 0; i < 60; ++i) {
    if (i % 10 == 0) node_.on_frame(rpdo(kEnable, 401));  // beyond the range
    one_ms();
  }
  EXPECT_EQ(node_.state(), State::quick_stop_active);
  EXPECT_EQ(node_.stack().counters().out_of_range, 6U);
  EXPECT_EQ(emergencies(), std::vector{0x8250});
}

TEST_F(DriveTest, WrongLengthCommandsAreRefusedAndReported) {
  for (const auto& [bytes, code] : {std::pair{8, 0x8220}, std::pair{5, 0x8210}}) {
    start_anew(loaded_motor());
    drive_at(100);
    CanFrame other = rpdo(kEnable, 100);
    other.dlc = static_cast<std::uint8_t>(bytes);
    for (int i = 0; i < 60; ++i) {
      if (i % 10 == 0) node_.on_frame(other);
      one_ms();
    }
    EXPECT_EQ(node_.state(), State::quick_stop_active) << bytes;
    EXPECT_EQ(node_.stack().counters().wrong_length, 6U) << bytes;
    EXPECT_EQ(emergencies().at(0), code) << bytes;
    // One of the right length ends the error.
    run(300, kOff, 0);
    EXPECT_EQ(node_.stack().values().get<0x1001>(), 0) << bytes;
  }
}

// CiA 402, bit 10: with halt set, and in a quick stop that stays, the target that is reached is standstill.
TEST_F(DriveTest, HaltReportsTargetReachedAtStandstillAndNotBefore) {
  drive_at(100);
  EXPECT_NE(status() & 0x400, 0);
  run(100, kHalt, 100);
  EXPECT_GT(motor_.speed_rad_s(), 20.0);
  EXPECT_EQ(status() & 0x400, 0) << "still turning";
  run(1500, kHalt, 100);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  EXPECT_NE(status() & 0x400, 0);
  EXPECT_EQ(node_.stack().values().get<0x606B>(), 0);
  run(40, kEnable, 100);
  EXPECT_EQ(status() & 0x400, 0) << "on the way to its target again";
}

TEST_F(DriveTest, UnderVoltageLatchesUntilAnEdgeAfterItsEnd) {
  drive_at(50);
  board_.supply_voltage_v = 18.9F;
  run(9, kEnable, 50);
  EXPECT_EQ(node_.state(), State::operation_enabled);  // the sag of a moment
  run(2, kEnable, 50);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_EQ(error_code(), 0x3220);
  EXPECT_EQ(emergencies(), std::vector{0x3220});
  EXPECT_EQ(node_.stack().values().get<0x1001>(), 0x05);
  run(20, kReset, 0);  // the cause is still there
  EXPECT_EQ(node_.state(), State::fault);
  board_.supply_voltage_v = 24;
  run(200, kReset, 0);  // a level is no edge
  EXPECT_EQ(node_.state(), State::fault);
  run(20, kOff, 0);
  EXPECT_EQ(node_.state(), State::fault);
  run(10, kReset, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_EQ(error_code(), 0);
  run(1000, kReset, 0);
  EXPECT_EQ(emergencies().back(), 0);
  enable();
}

TEST_F(DriveTest, AResetBitHeldSinceTheLossOfTheComputerIsNoEdge) {
  drive_at(50);
  board_.supply_voltage_v = 10;
  run(20, kEnable, 50);
  board_.supply_voltage_v = 24;
  silence(100);
  run(50, kReset, 0);
  EXPECT_EQ(node_.state(), State::fault);
  run(10, kOff, 0);
  run(10, kReset, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveTest, H1_ACurrentInABridgeThatIsOffIsAFaultThatNoResetTakesBack) {
  readings_by_hand_ = true;
  run(50, kShutdown, 0);
  for (const float noise_a : {0.9F, -0.9F}) {
    board_.current_a = noise_a;
    run(500, kShutdown, 0);
    EXPECT_EQ(node_.state(), State::ready);
  }
  load_n_m_ = -0.1;  // pushed quickly, it feeds the supply through the diodes
  run(500, kShutdown, 0);
  board_.current_a = -6;
  run(500, kShutdown, 0);
  EXPECT_EQ(node_.state(), State::ready);
  board_.current_a = 0;
  load_n_m_ = 0;
  run(3000, kShutdown, 0);
  board_.current_a = 1.2F;
  run(15, kShutdown, 0);
  EXPECT_EQ(node_.state(), State::ready) << "a winding may still empty itself";
  board_.current_a = 0;
  run(5, kShutdown, 0);
  board_.current_a = 1.2F;
  run(21, kShutdown, 0);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ((node_.stack().values().get<0x603F>()), 0x5400);
  EXPECT_FALSE(board_.bridge_on);
  run(50, kReset, 0);
  EXPECT_EQ(node_.state(), State::fault) << "it still flows";
  board_.current_a = 0;
  run(10, kOff, 0);
  run(10, kReset, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveTest, DoesNotSwitchOnWithoutSupply) {
  board_.supply_voltage_v = 0;  // the emergency cut-off relay
  run(10, kShutdown, 0);
  run(10, kSwitchOn, 0);
  run(10, kEnable, 0);
  EXPECT_EQ(node_.state(), State::ready);
  EXPECT_EQ(status() & 0x10, 0);
  board_.supply_voltage_v = 24;
  run(50, kEnable, 50);  // an old controlword does not enable
  EXPECT_NE(node_.state(), State::operation_enabled);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, TheSpeedIsMeasuredAlsoWithoutSupply) {
  board_.supply_voltage_v = 0;
  load_n_m_ = -0.1;  // an external push
  run(500, kOff, 0);
  EXPECT_GT(motor_.speed_rad_s(), 30);
  EXPECT_NEAR(node_.speed_rad_s(), motor_.speed_rad_s(), 3);
}

TEST_F(DriveTest, H2_AnEncoderThatDiesUnderWayIsFoundBeforeTheWheelRunsAway) {
  for (const double speed_rad_s : {25.0, 60.0, 120.0, 195.0, -120.0}) {
    SCOPED_TRACE(speed_rad_s);
    start_anew(loaded_motor());
    drive_at(speed_rad_s);
    encoder_dead_ = true;
    const int found = until(
        500, [&] { return node_.state() == State::fault; }, [&] { run(1, kEnable, speed_rad_s); });
    EXPECT_GE(found, 50);
    EXPECT_LE(found, 75);
    EXPECT_FALSE(board_.bridge_on);
    EXPECT_EQ(error_code(), 0x7305);
    EXPECT_LT(peak_current_a_, 9.0);
    EXPECT_LT(std::fabs(motor_.speed_rad_s()), 240);  // 0.8 m/s
    run(200, kEnable, speed_rad_s);
    EXPECT_EQ(emergencies(), std::vector{0x7305});
  }
}

TEST_F(DriveTest, H2_AnEncoderThatNeverCountedIsFoundWhenMotionBegins) {
  for (const double load_n_m : {0.0, 0.6}) {  // freely, and against nearly what the limiter allows
    SCOPED_TRACE(load_n_m);
    start_anew(loaded_motor());
    encoder_dead_ = true;
    enable();
    load_n_m_ = load_n_m;
    const int found = until(
        1000, [&] { return node_.state() == State::fault; }, [&] { run(1, kEnable, 60); });
    EXPECT_GT(found, 50);
    EXPECT_LE(found, 250);
    EXPECT_EQ(error_code(), 0x7305);
    EXPECT_FALSE(board_.bridge_on);
    EXPECT_LT(std::fabs(motor_.speed_rad_s()), 150);
  }
}

TEST_F(DriveTest, H2_NoHonestMotorLooksLikeALostEncoder) {
  for (const float supply_v : {21.6F, 24.0F, 27.0F}) {
    for (const double resistance : {0.8, 1.0, 1.2}) {
      for (const double constant : {0.9, 1.0, 1.1}) {
        for (const float limit_a : {6.0F, 12.0F}) {
          SCOPED_TRACE(testing::Message() << supply_v << " V, resistance x " << resistance << ", constant x " << constant << ", " << limit_a
                                          << " A");
          sim::MotorConfig config = loaded_motor();
          config.resistance_ohm *= resistance;
          config.constant_v_s_rad *= constant;
          board_.supply_voltage_v = supply_v;
          start_anew(config);
          ASSERT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x2200, 5, bits_of(limit_a))).data[0], 0x60);
          enable();
          const auto go = [&](int milliseconds, int word, double target_rad_s, const char* what) {
            run(milliseconds, word, target_rad_s);
            EXPECT_EQ(error_code(), 0) << what << " " << target_rad_s;
          };
          go(1500, kEnable, 180, "fastest walk, as far as the supply goes");
          go(1500, kEnable, 0, "braking");
          go(700, kEnable, 120, "setting off");
          go(1500, kEnable, -120, "reversal at the limit");
          for (const double load_n_m : {0.45, -0.45, 0.0}) {
            load_n_m_ = load_n_m;
            go(800, kEnable, 0, "held on a slope");
            go(1000, kEnable, 100, "on a slope");
            go(800, kEnable, 0, "braking on a slope");
          }
          go(800, kEnable, 120, "setting off");
          go(800, kQuickStop, 120, "quick stop");
          EXPECT_EQ(node_.state(), State::switch_on_disabled);  // the quick stop's proper end
          EXPECT_TRUE(emergencies().empty());
        }
      }
    }
  }
}

TEST_F(DriveTest, H2_ABlockedWheelIsLeftToTheStallRuleWhateverTheWinding) {
  for (const double resistance : {0.8, 1.0, 1.2}) {
    for (const float supply_v : {21.6F, 27.0F}) {
      SCOPED_TRACE(testing::Message() << supply_v << " V, resistance x " << resistance);
      sim::MotorConfig config = loaded_motor();
      config.resistance_ohm *= resistance;
      board_.supply_voltage_v = supply_v;
      start_anew(config);
      drive_at(100);
      motor_.lock(true);
      const int found = until(
          1000, [&] { return node_.state() == State::fault; }, [&] { run(1, kEnable, 100); });
      EXPECT_GE(found, 100);  // the other rule would need half of that
      EXPECT_LE(found, 200);
      EXPECT_EQ(error_code(), 0x7121) << "the floor's doing, not the encoder's";
    }
  }
}

TEST_F(DriveTest, ReversedEncoderIsFoundBeforeItRunsAway) {
  encoder_reversed_ = true;
  enable();
  const int found = until(
      1000, [&] { return node_.state() == State::fault; }, [&] { run(1, kEnable, 60); });
  EXPECT_GT(found, 0);
  EXPECT_LE(found, 200);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_EQ(error_code(), 0x7305);
  EXPECT_LT(std::fabs(motor_.speed_rad_s()), 100);
}

TEST_F(DriveTest, ABlockedWheelIsFoundAndDoesNotBurn) {
  enable();
  motor_.lock(true);
  const int found = until(
      1000, [&] { return node_.state() == State::fault; }, [&] { run(1, kEnable, 100); });
  EXPECT_GT(found, 100);
  EXPECT_LE(found, 250);
  EXPECT_EQ(error_code(), 0x7121);
  EXPECT_LT(peak_current_a_, 9.0);
}

TEST_F(DriveTest, HonestMotionNeverLooksLikeAnEncoderFault) {
  enable();
  // Hard reversals, holding against a push near the current limit, being driven down a slope.
  for (int i = 0; i < 6; ++i) run(700, kEnable, i % 2 == 0 ? 180 : -180);
  run(1000, kEnable, 0);
  load_n_m_ = 0.55;  // 4.8 A of 6
  run(2000, kEnable, 0);
  load_n_m_ = -0.55;
  run(2000, kEnable, 0);
  run(2000, kEnable, 100);
  load_n_m_ = -0.8;  // more than the current limit can hold: the wheel yields
  run(300, kEnable, 0);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  EXPECT_EQ(error_code(), 0);
  EXPECT_TRUE(emergencies().empty());
}

TEST_F(DriveTest, SlowCrawlingIsNoStall) {
  enable();
  run(5000, kEnable, 2.5);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  EXPECT_NEAR(motor_.speed_rad_s(), 2.5, 1.0);
}

// H1: the drive's own limit, for any command.
TEST_F(DriveTest, OverSpeedRampsDownIntoTheFault) {
  drive_at(190);
  load_n_m_ = -1.2;  // driven by something stronger
  const int found = until(
      1000, [&] { return node_.state() == State::fault_reaction; }, [&] { run(1, kEnable, 190); });
  ASSERT_GE(found, 0);
  EXPECT_EQ(error_code(), 0x8400);
  load_n_m_ = 0;
  run(2000, kEnable, 190);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_LT(std::fabs(motor_.speed_rad_s()), 3.0);
}

TEST_F(DriveTest, ImpossibleReadingsSwitchOff) {
  readings_by_hand_ = true;
  for (const bool current : {true, false}) {
    board_.current_a = 0;
    board_.supply_voltage_v = 24;
    node_.power_on();
    begin();
    enable();
    (current ? board_.current_a : board_.supply_voltage_v) = std::numeric_limits<float>::quiet_NaN();
    one_ms();
    EXPECT_EQ(node_.state(), State::fault);
    EXPECT_FALSE(board_.bridge_on);
    EXPECT_EQ(error_code(), 0x5000);
    run(20, kOff, 0);
    run(20, kReset, 0);
    EXPECT_EQ(node_.state(), State::fault);  // still impossible
  }
}

TEST_F(DriveTest, ACurrentBeyondEveryLimitTripsInTwoMilliseconds) {
  readings_by_hand_ = true;
  enable();
  board_.current_a = -18.5F;
  one_ms();
  EXPECT_EQ(node_.state(), State::operation_enabled);
  one_ms();
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ(error_code(), 0x2310);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveTest, ParametersWrittenOverTheBusAct) {
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x2200, 5, bits_of(2.0F))).data[0], 0x60);
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x6083, 0, 100)).data[0], 0x60);
  enable();
  const int reached = until(
      2000, [&] { return node_.reference_rad_s() >= 90; }, [&] { run(1, kEnable, 90); });
  EXPECT_NEAR(reached, 900, 20);
  run(30, kEnable, 90);  // updated every 20 ms at least
  EXPECT_EQ(node_.stack().values().get<0x606B>(), 90000);
  load_n_m_ = 0.5;  // needs 4.3 A
  peak_current_a_ = 0;
  run(100, kEnable, 90);
  EXPECT_LT(peak_current_a_, 2.0 * 1.5);
}

TEST_F(DriveTest, TheFeedbackGainOfTheLawIsFixed) {
  const auto write = [&](float value) {
    return ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x2200, 3, bits_of(value))).data[0];
  };
  EXPECT_EQ(write(1.0F), 0x60);
  EXPECT_EQ(write(0.5F), 0x80);
}

TEST_F(DriveTest, TakesOverAPushedWheelSmoothly) {
  load_n_m_ = -0.1;
  run(1200, kOff, 0);
  load_n_m_ = 0;
  const double pushed = motor_.speed_rad_s();
  ASSERT_GT(pushed, 80);
  run(10, kShutdown, 0);
  const double before = motor_.speed_rad_s();
  peak_current_a_ = 0;
  run(20, kEnable, 0);
  EXPECT_LT(before - motor_.speed_rad_s(), 8.0);  // 450 rad/s2 would be 9; shorted it would lose 15
  EXPECT_LT(peak_current_a_, 4.0);
  EXPECT_NEAR(node_.reference_rad_s(), before - 9, 2);  // the ramp begins where the wheel is
  run(500, kEnable, 0);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 1.5);
}

TEST_F(DriveTest, LateTicksAreCounted) {
  node_.note_late_tick();
  node_.note_late_tick();
  EXPECT_EQ((node_.stack().values().get<0x2220, 1>()), 2U);
}

TEST_F(DriveTest, NothingThatArrivesCanTurnTheBridgeOnOutsideItsStates) {
  std::mt19937 random(5);
  readings_by_hand_ = true;
  std::uint64_t enabled_ticks = 0;
  for (int i = 0; i < 300000; ++i) {
    switch (random() % 12U) {
      case 0:
        node_.on_frame(rpdo(static_cast<int>(random() & 0x1FFU), static_cast<double>(random() % 800U) - 400));
        break;
      case 1:
      case 2:
      case 3: {
        static constexpr int kWords[] = {kShutdown, kSwitchOn, kEnable, kEnable, kEnable, kQuickStop, kReset, kOff};
        node_.on_frame(rpdo(kWords[random() % 8U], 100));
        break;
      }
      case 4: {
        CanFrame frame{static_cast<std::uint32_t>(random() % 0x800U), static_cast<std::uint8_t>(random() % 9U), 0, {}};
        for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(random());
        if (random() % 2U == 0) frame.id = 0x601;
        node_.on_frame(frame);
        break;
      }
      case 5:
        node_.on_frame(canopen::nmt(random() % 50U == 0 ? canopen::NmtCommand::reset_node : canopen::NmtCommand::start, 0));
        break;
      case 6:
        board_.current_a = random() % 500U == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(random() % 16U) - 8.0F;
        break;
      case 7:
        board_.supply_voltage_v = random() % 50U == 0 ? std::bit_cast<float>(static_cast<std::uint32_t>(random())) : 24.0F;
        break;
      case 8:
        board_.counts += static_cast<std::int32_t>(random() % 61U) - 30;
        break;
      default:
        break;
    }
    node_.tick_1ms();
    if (board_.sent.size() > 1000) board_.sent.clear();
    ASSERT_TRUE(std::isfinite(board_.duty_norm) && std::fabs(board_.duty_norm) <= 1.0F);
    const bool may =
        node_.state() == State::operation_enabled || node_.state() == State::quick_stop_active || node_.state() == State::fault_reaction;
    ASSERT_TRUE(may || !board_.bridge_on);
    ASSERT_TRUE(may || board_.duty_norm == 0.0F);
    enabled_ticks += node_.state() == State::operation_enabled ? 1U : 0U;
  }
  EXPECT_GT(enabled_ticks, 1000U);
}

}  // namespace
}  // namespace hoist::firmware
