// What a drive does before anything breaks, and what it remembers afterwards: self-test, folding back, latched faults, first-fault snapshot.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "deploy/tools/hoist/drive_fault.hpp"
#include "tests/unit/firmware/drive_fixture.hpp"

namespace hoist::firmware {
namespace {

class DriveProtection : public DriveFixture {
 protected:
  const ObjectValues<contract::NodeKind::drive>& values() const { return node_.stack().values(); }
  // Like run(), with the current sensor showing `offset_a` too much.
  void run_with_offset(int milliseconds, int word, double target_rad_s, float offset_a) {
    readings_by_hand_ = true;
    for (int i = 0; i < milliseconds; ++i) {
      board_.current_a = static_cast<float>(motor_.current_a()) + offset_a;
      run(1, word, target_rad_s);
    }
  }
  void reset_fault() {
    run(20, kOff, 0);
    run(10, kReset, 0);
  }
};

TEST_F(DriveProtection, TheBridgeStaysOffUntilTheSelfTestHasPassed) {
  node_.power_on();
  make_operational(node_, board_);
  EXPECT_EQ(node_.state(), State::not_ready);
  EXPECT_EQ(status() & 0x4F, 0x00);
  for (int i = 2; i < static_cast<int>(kSelfTest_ms); ++i) {
    node_.on_frame(rpdo(i % 2 == 0 ? kShutdown : kEnable, 50));
    one_ms();
    ASSERT_EQ(node_.state(), State::not_ready);
    ASSERT_FALSE(board_.bridge_on);
    ASSERT_EQ((values().get<0x2251>()), self_test_bit::kRunning);
  }
  one_ms();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_EQ((values().get<0x2251>()), 0);
}

TEST_F(DriveProtection, TheCurrentSensorsOffsetIsTakenOut) {
  readings_by_hand_ = true;
  board_.current_a = 0.3F;
  node_.power_on();
  begin();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  tick(node_, 10);
  EXPECT_EQ((values().get<0x2252>()), 300);
  EXPECT_EQ((values().get<0x6078>()), 0);
  now_ms_ = 0;
  run_with_offset(10, kShutdown, 0, 0.3F);
  run_with_offset(10, kEnable, 0, 0.3F);
  run_with_offset(1000, kEnable, 100, 0.3F);
  EXPECT_NEAR(motor_.speed_rad_s(), 100, 1.0);
  EXPECT_NEAR(values().get<0x6078>() * 0.006, motor_.current_a(), 0.1);
}

TEST_F(DriveProtection, H11_ABrokenCurrentSensorFailsTheSelfTestUntilItIsWell) {
  readings_by_hand_ = true;
  for (const bool noisy : {false, true}) {
    SCOPED_TRACE(noisy);
    board_.current_a = 0.9F;
    node_.power_on();
    make_operational(node_, board_);
    for (int i = 0; i < 25; ++i) {
      if (noisy) board_.current_a = i % 2 == 0 ? 0.8F : -0.8F;
      node_.tick_1ms();
    }
    EXPECT_EQ(node_.state(), State::fault);
    EXPECT_EQ(error_code(), 0x5000);
    EXPECT_EQ((values().get<0x2251>()), self_test_bit::kCurrentSensor);
    now_ms_ = 0;
    reset_fault();
    run(30, kOff, 0);
    if (!noisy) {  // tested again, still failed
      EXPECT_EQ(node_.state(), State::fault);
    }
    board_.current_a = 0;
    reset_fault();
    run(30, kOff, 0);
    EXPECT_EQ(node_.state(), State::switch_on_disabled);
  }
}

TEST_F(DriveProtection, H11_TheBridgeDriversFaultSwitchesOffAndAGlitchDoesNot) {
  drive_at(50);
  board_.driver_good = false;
  run(1, kEnable, 50);
  board_.driver_good = true;
  run(100, kEnable, 50);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  board_.driver_good = false;
  run(2, kEnable, 50);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_FALSE(board_.bridge_on);
  EXPECT_EQ(error_code(), 0x5400);
  reset_fault();
  EXPECT_EQ(node_.state(), State::fault);
  board_.driver_good = true;
  reset_fault();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  node_.power_on();
  board_.driver_good = false;
  begin();
  tick(node_, 5);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ((values().get<0x2251>()), self_test_bit::kDriver);
}

TEST_F(DriveProtection, WithoutSupplyTheDriversComplaintIsNoFaultButNothingSwitchesOn) {
  board_.supply_voltage_v = 0;  // emergency stop pressed
  board_.driver_good = false;
  node_.power_on();
  begin();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  board_.supply_voltage_v = 24;
  run(10, kShutdown, 0);
  run(20, kSwitchOn, 0);
  EXPECT_EQ(node_.state(), State::ready);
  board_.driver_good = true;
  run(20, kSwitchOn, 0);
  EXPECT_EQ(node_.state(), State::switched_on);
}

TEST_F(DriveProtection, H2_IllegalEncoderStepsInARowSwitchOff) {
  drive_at(100);
  for (int i = 0; i < 20; ++i) {  // one now and then is noise
    ++board_.illegal_steps;
    run(150, kEnable, 100);
  }
  EXPECT_EQ(node_.state(), State::operation_enabled);
  EXPECT_EQ((values().get<0x2250, 1>()), 20U);
  int found = 0;
  for (; found < 100 && node_.state() == State::operation_enabled; ++found) {
    if (found % 10 == 0) ++board_.illegal_steps;
    run(1, kEnable, 100);
  }
  EXPECT_LE(found, 31);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ(error_code(), 0x7305);
  EXPECT_FALSE(board_.bridge_on);
}

TEST_F(DriveProtection, LostParametersAreAFaultUntilTheyAreSavedAgain) {
  for (auto& page : board_.pages.pages) std::fill(page.begin(), page.end(), std::byte{0x5A});
  node_.power_on();
  begin();
  tick(node_, 5);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ(error_code(), 0x6310);
  now_ms_ = 0;
  reset_fault();
  EXPECT_EQ(node_.state(), State::fault);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 1));
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x1010, 1, 0x65766173)).data[0], 0x60);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 1));
  reset_fault();
  run(30, kOff, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  node_.power_on();
  begin();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveProtection, AWatchdogResetIsAFaultThatOnlyAResetOfTheFaultEnds) {
  board_.cause = ResetCause::watchdog;
  node_.power_on();
  begin();
  tick(node_, 5);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ(error_code(), 0x6010);
  EXPECT_EQ((values().get<0x2221>()), 2);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 1));
  begin();
  tick(node_, 5);
  EXPECT_EQ(node_.state(), State::fault);  // a reset over the bus clears nothing
  now_ms_ = 0;
  reset_fault();
  run(30, kOff, 0);
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  enable();
}

TEST_F(DriveProtection, TheFirstFaultIsRememberedWithItsCircumstances) {
  drive_at(100);
  const double current_a = motor_.current_a();
  board_.supply_voltage_v = 18.5F;
  run(15, kEnable, 100);
  ASSERT_EQ(error_code(), 0x3220);
  const auto at = [&] {
    EXPECT_EQ((values().get<0x2240, 1>()), 0x3220);
    EXPECT_NEAR((values().get<0x2240, 2>()), 1070U, 40U);
    EXPECT_NEAR((values().get<0x2240, 4>()), 100'000, 3'000);
    EXPECT_NEAR((values().get<0x2240, 5>()), 1000 * current_a, 1'000);
    EXPECT_EQ((values().get<0x2240, 6>()), 18'500U);
    EXPECT_GT((values().get<0x2240, 7>()), 450);
    EXPECT_NEAR((values().get<0x2240, 8>()), 900, 20);
  };
  at();
  board_.driver_good = false;  // with any later fault
  run(500, kOff, 0);
  at();
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 1));
  make_operational(node_, board_);
  EXPECT_EQ((values().get<0x1001>()), 0x05);  // still an error, and said so
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 1));
  board_.driver_good = true;
  board_.supply_voltage_v = 24;
  begin();
  at();
  now_ms_ = 0;
  reset_fault();
  EXPECT_EQ((values().get<0x2240, 1>()), 0);
  EXPECT_EQ((values().get<0x2240, 6>()), 0U);
}

TEST_F(DriveProtection, OverVoltageSwitchesOffAfterBrakingHasGivenWay) {
  drive_at(150);
  board_.supply_voltage_v = 31;  // half of the 2 V below the limit
  peak_current_a_ = 0;
  double strongest_a = 0;
  for (int i = 0; i < 200; ++i) {
    run(1, kEnable, 0);
    strongest_a = std::max(strongest_a, -motor_.current_a());
  }
  EXPECT_LT(strongest_a, 3.3);  // of 6 A
  EXPECT_GT(strongest_a, 2.0);
  EXPECT_NE(status() & 0x80, 0);  // and reports the reduced limit
  EXPECT_EQ(node_.state(), State::operation_enabled);
  board_.supply_voltage_v = 32.5F;
  run(4, kEnable, 0);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  run(2, kEnable, 0);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_EQ(error_code(), 0x3210);
  EXPECT_FALSE(board_.bridge_on);
  board_.supply_voltage_v = 30.5F;
  reset_fault();
  EXPECT_EQ(node_.state(), State::fault);
  board_.supply_voltage_v = 27;
  reset_fault();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveProtection, H12_ASaggingSupplyGetsLessLoadBeforeItIsCutOff) {
  enable();
  board_.supply_voltage_v = 20;
  peak_current_a_ = 0;
  run(100, kEnable, 150);
  EXPECT_NEAR(node_.current_limit_a(), 6.0 * 0.5, 0.05);
  EXPECT_LT(peak_current_a_, 3.4);
  EXPECT_NE(status() & 0x80, 0);
  board_.supply_voltage_v = 19.2F;
  run(50, kEnable, 150);
  EXPECT_NEAR(node_.current_limit_a(), 6.0 * 0.25, 0.01);
  EXPECT_EQ(node_.state(), State::operation_enabled);
  board_.supply_voltage_v = 24;
  run(500, kEnable, 50);
  EXPECT_EQ(node_.current_limit_a(), 6.0F);
  EXPECT_EQ(status() & 0x80, 0);
}

// Shorter than the limit of a supply that is too low: the wheel rolls, and is taken over as it rolls.
TEST_F(DriveProtection, H12_ASupplyThatIsGoneForAMomentIsNoJerk) {
  for (const int gone_ms : {1, 5, 9}) {
    for (const float supply_v : {5.0F, 0.0F}) {
      SCOPED_TRACE(testing::Message() << gone_ms << " ms at " << supply_v << " V");
      board_.supply_voltage_v = 24;
      start_anew(loaded_motor());
      drive_at(150);
      board_.supply_voltage_v = supply_v;
      run(gone_ms, kEnable, 150);
      EXPECT_FALSE(board_.bridge_on);
      board_.supply_voltage_v = 24;
      peak_current_a_ = 0;
      for (int i = 0; i < 500; ++i) {
        const double before_rad_s = motor_.speed_rad_s();
        run(1, kEnable, 150);
        ASSERT_LT(before_rad_s - motor_.speed_rad_s(), 0.3);  // the ramp of a quick stop
      }
      EXPECT_EQ(node_.state(), State::operation_enabled);
      EXPECT_LT(peak_current_a_, 6.0);
      EXPECT_NEAR(motor_.speed_rad_s(), 150, 1);
    }
  }
}

TEST_F(DriveProtection, H12_BrakingIsNeverWeakenedByALowSupply) {
  drive_at(100);
  board_.supply_voltage_v = 19.2F;
  int braking = 0;
  for (int i = 0; i < 150; ++i) {
    run(1, kEnable, 0);
    if (motor_.current_a() > -0.3) continue;
    ++braking;
    ASSERT_EQ(node_.current_limit_a(), 6.0F);
  }
  EXPECT_GT(braking, 50);
}

TEST_F(DriveProtection, H11_AHotWindingGetsLessCurrentAndTheDriveGoesOn) {
  const auto write = [&](std::uint16_t index, std::uint8_t sub, float value) {
    return ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), index, sub, bits_of(value))).data[0];
  };
  EXPECT_EQ(write(0x2200, 5, 12.0F), 0x60);
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x6083, 0, 2000)).data[0], 0x60);
  EXPECT_EQ(write(0x2230, 5, 10.0F), 0x60);
  enable();
  // Back and forth at full current, longer than any real use.
  float hottest_dc = 0, lowest_limit_a = 12;
  for (int i = 0; i < 60; ++i) {
    run(400, kEnable, i % 2 == 0 ? 150 : -150);
    ASSERT_EQ(node_.state(), State::operation_enabled) << i;
    hottest_dc = std::max(hottest_dc, static_cast<float>(values().get<0x2230, 1>()));
    lowest_limit_a = std::min(lowest_limit_a, node_.current_limit_a());
  }
  EXPECT_GT(hottest_dc, 1050);
  EXPECT_LT(hottest_dc, 1200);
  EXPECT_LT(lowest_limit_a, 11.0F);
  EXPECT_GE(lowest_limit_a, 3.6F);
  EXPECT_NE(status() & 0x80, 0);
}

TEST_F(DriveProtection, H11_AWindingThatGetsTooHotAllTheSameRampsDownAndWaits) {
  drive_at(60);
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x2230, 2, bits_of(80.0F))).data[0], 0x60);
  run(20, kEnable, 60);
  EXPECT_EQ(node_.state(), State::fault_reaction);  // 90 degrees after power-on, the limit is 80 now
  EXPECT_EQ(error_code(), 0x4310);
  EXPECT_TRUE(board_.bridge_on);
  run(1500, kEnable, 60);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_NEAR(motor_.speed_rad_s(), 0, 2.0);
  reset_fault();
  EXPECT_EQ(node_.state(), State::fault);
  run(60'000, kOff, 0);
  reset_fault();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
}

TEST_F(DriveProtection, AResetOverTheBusChangesNothingAboutTheWindingsHeat) {
  tick(node_, 60'000);
  const auto before = values().get<0x2230, 1>();
  ASSERT_LT(before, 700);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 1));
  begin();
  tick(node_, 10);
  EXPECT_NEAR((values().get<0x2230, 1>()), before, 10);
  node_.power_on();  // but a power cycle clears it
  begin();
  tick(node_, 10);
  EXPECT_NEAR((values().get<0x2230, 1>()), 900, 10);
}

// What `hoist bus reset-fault` sends, one frame each 10 ms and without a computer's heartbeat, to a drive that has just shown a fault.
TEST_F(DriveProtection, TheToolsResetEndsAFaultAndNothingElse) {
  heartbeats_ = false;
  enable();
  board_.supply_voltage_v = 18;
  run(30, kEnable, 0);
  ASSERT_EQ(node_.state(), State::fault);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 1));
  const auto reset = [&] {
    board_.sent.clear();
    for (const CanFrame& frame : tool::fault_reset_frames(1, 0x201)) {
      node_.on_frame(frame);
      for (int i = 0; i < 10; ++i) {
        one_ms();
        EXPECT_FALSE(board_.bridge_on);
      }
    }
    tick(node_, 100);
    EXPECT_EQ(node_.stack().state(), NmtState::pre_operational);
  };
  reset();
  EXPECT_EQ(node_.state(), State::fault) << "the supply is still low";
  board_.supply_voltage_v = 24;
  tick(node_, 5);
  reset();
  EXPECT_EQ(node_.state(), State::switch_on_disabled);
  EXPECT_EQ(error_code(), 0);
  EXPECT_EQ(emergencies(), std::vector{0x0000}) << "the end of the fault, and no missed deadline";
}

// Faults during the ramp of an over-speed fault, and how soon they must end it.
struct Second {
  const char* what;
  int code;
  int within_ms;
  bool stands;  // seen also with the bridge off
};
constexpr Second kSeconds[] = {
    {"bridge driver", 0x5400, 2, true},           {"current beyond every limit", 0x2310, 2, true},
    {"supply too low", 0x3220, 10, true},         {"supply too high", 0x3210, 5, true},
    {"no number for a current", 0x5000, 1, true}, {"illegal encoder steps", 0x7305, 1, false},
    {"encoder stands still", 0x7305, 75, false},
};

class SecondFault : public DriveProtection {
 protected:
  void break_now(const Second& second) {
    readings_by_hand_ = second.code == 0x2310 || second.code == 0x5000;
    if (second.code == 0x5400) board_.driver_good = false;
    if (second.code == 0x2310) board_.current_a = 25;
    if (second.code == 0x3220) board_.supply_voltage_v = 18;
    if (second.code == 0x3210) board_.supply_voltage_v = 33;
    if (second.code == 0x5000) board_.current_a = std::numeric_limits<float>::quiet_NaN();
    if (second.code == 0x7305 && second.within_ms == 1) board_.illegal_steps += 3;
    if (second.code == 0x7305 && second.within_ms != 1) encoder_dead_ = true;
  }
  void repair() {
    readings_by_hand_ = encoder_dead_ = false;
    board_.driver_good = true;
    board_.supply_voltage_v = 24;
    board_.current_a = 0;
  }
  // Over-speed found, its ramp begun, the ramp's first EMCY sent.
  void begin_ramp() {
    repair();
    start_anew(loaded_motor());
    drive_at(190);
    load_n_m_ = -1.2;
    ASSERT_GE(until(
                  1000, [&] { return node_.state() == State::fault_reaction; }, [&] { run(1, kEnable, 190); }),
              0);
    load_n_m_ = 0;
    run(100, kOff, 0);
    ASSERT_EQ(node_.state(), State::fault_reaction);
    ASSERT_TRUE(board_.bridge_on);
  }
};

TEST_F(SecondFault, H2_H11_OneThatMustSwitchOffDoesSoDuringTheRampOfAnother) {
  for (const Second& second : kSeconds) {
    SCOPED_TRACE(second.what);
    ASSERT_NO_FATAL_FAILURE(begin_ramp());
    const auto found_ms = values().get<0x2240, 2>();
    break_now(second);
    const int off = until(
        second.within_ms, [&] { return !board_.bridge_on; }, [&] { run(1, kOff, 0); });
    EXPECT_GE(off, 0);
    EXPECT_EQ(node_.state(), State::fault);
    run(10, kOff, 0);
    EXPECT_EQ(error_code(), 0x8400);  // the first one is reported
    EXPECT_EQ((values().get<0x2240, 1>()), 0x8400);
    EXPECT_EQ((values().get<0x2240, 2>()), found_ms);
    EXPECT_EQ(emergencies(), (std::vector{0x8400, second.code}));
  }
}

TEST_F(SecondFault, H2_H11_TheResetWaitsForTheEndOfBothCauses) {
  for (const Second& second : kSeconds) {
    SCOPED_TRACE(second.what);
    ASSERT_NO_FATAL_FAILURE(begin_ramp());
    break_now(second);
    run(200, kOff, 0);
    ASSERT_EQ(node_.state(), State::fault);
    node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 1));
    make_operational(node_, board_);
    EXPECT_NE((values().get<0x1001>()), 0);  // still an error, and said so
    if (second.stands) {
      reset_fault();
      EXPECT_EQ(node_.state(), State::fault);
      EXPECT_EQ(error_code(), 0x8400);
    }
    repair();
    run(100, kOff, 0);  // a returning encoder jumps
    reset_fault();
    EXPECT_EQ(node_.state(), State::switch_on_disabled);
    EXPECT_EQ(error_code(), 0);
    EXPECT_EQ((values().get<0x1001>()), 0);
    enable();
    run(500, kEnable, 50);
    EXPECT_EQ(node_.state(), State::operation_enabled);
  }
}

TEST_F(SecondFault, AResetDuringTheRampNeitherEndsNorForgetsTheFirst) {
  ASSERT_NO_FATAL_FAILURE(begin_ramp());
  const auto found_ms = values().get<0x2240, 2>();
  reset_fault();
  EXPECT_EQ(node_.state(), State::fault_reaction);
  EXPECT_EQ((values().get<0x2240, 1>()), 0x8400);
  EXPECT_EQ((values().get<0x2240, 2>()), found_ms);
}

TEST_F(SecondFault, OneThatOnlyRampsChangesNothing) {
  ASSERT_NO_FATAL_FAILURE(begin_ramp());
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(4), 0x2230, 2, bits_of(80.0F))).data[0], 0x60);
  run(50, kOff, 0);
  EXPECT_EQ(node_.state(), State::fault_reaction);
  EXPECT_TRUE(board_.bridge_on);
  run(1500, kOff, 0);
  EXPECT_EQ(node_.state(), State::fault);
  EXPECT_LT(std::fabs(motor_.speed_rad_s()), 3.0);
  EXPECT_EQ(error_code(), 0x8400);
  EXPECT_TRUE(emergencies().empty());  // since the winding's limit was written
}

TEST_F(DriveProtection, WhateverBreaksTheBridgeIsOffInEveryFaultAndTheFirstOneStays) {
  std::mt19937 random(12);
  int faults = 0;
  for (int run_number = 0; run_number < 150; ++run_number) {
    board_ = TestBoard{};
    start_anew(loaded_motor());
    enable();
    run(static_cast<int>(random() % 300U), kEnable, 80);
    std::uint16_t first = 0;
    for (int k = 0; k < 4; ++k) {
      switch (random() % 7U) {
        case 0:
          board_.driver_good = false;
          break;
        case 1:
          board_.supply_voltage_v = 17;
          break;
        case 2:
          board_.supply_voltage_v = 35;
          break;
        case 3:
          board_.illegal_steps += 3;
          break;
        case 4:
          encoder_dead_ = true;
          break;
        case 5:
          board_.supply_voltage_v = std::numeric_limits<float>::quiet_NaN();
          break;
        default:
          board_.driver_good = true;
          break;
      }
      for (int i = 0; i < 120; ++i) {
        run(1, kEnable, 80);
        if (node_.state() == State::fault) {
          if (first == 0) first = error_code();
          ASSERT_FALSE(board_.bridge_on);
          ASSERT_EQ(error_code(), first);
          ASSERT_EQ((values().get<0x2240, 1>()), first);
        }
      }
    }
    faults += first != 0 ? 1 : 0;
  }
  EXPECT_GT(faults, 120);
}

}  // namespace
}  // namespace hoist::firmware
