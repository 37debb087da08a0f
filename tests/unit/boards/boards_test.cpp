// What can be said about the boards without a board: places in memory that two programs must agree on, pins that may be used once.
#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/pins.hpp"
#include "firmware/boot/mailbox.hpp"

namespace hoist::firmware {
namespace {

TEST(Lpc11c24Memory, TheLoaderAndTheApplicationMeanTheSamePlaces) {
  const contract::ImageChipInfo* chip = contract::find_image_chip("lpc11c24");
  ASSERT_NE(chip, nullptr);
  EXPECT_EQ(chip->application_at, lpc11c24::kApplicationStart);
  EXPECT_EQ(chip->application_max, lpc11c24::kApplicationBytes);
  EXPECT_EQ(chip->ram_at, lpc11c24::kRamStart);
  EXPECT_EQ(chip->ram_bytes, lpc11c24::kRamBytes);
}

TEST(Lpc11c24Memory, NothingOverlaps) {
  using namespace lpc11c24;
  EXPECT_EQ(kLoaderStart + kLoaderBytes, kApplicationStart);
  EXPECT_EQ(kApplicationStart + kApplicationBytes, kParametersStart);
  EXPECT_EQ(kParametersStart + 2 * kSectorBytes, 0x8000U);  // 32 KB of flash
  EXPECT_EQ(kParametersStart % kSectorBytes, 0U);           // an erase must not reach into the program
  EXPECT_EQ(kMailboxBytes, sizeof(Mailbox));
  EXPECT_EQ(kMailboxStart + kMailboxBytes + 32, kRamStart + kRamBytes);  // the factory's flash routines use the last 32 bytes
  EXPECT_LE(kStackTop, kMailboxStart);
  EXPECT_EQ(kStackTop % 8, 0U);  // ARM procedure call standard
}

TEST(Lpc11c24Pins, NoPinHasTwoJobsOnOneBoard) {
  using namespace lpc11c24;
  const std::vector<Pin> everywhere{kStrap0, kStrap1, kService, kLed};
  const std::vector<std::vector<Pin>> boards{
      {kI2cScl, kI2cSda, kSpiSck, kSpiMiso, kSpiMosi, kSpiSelect},
      {kBridgeEnable, kBridgePhase, kBridgeAwake, kBridgeFault, kEncoderA, kEncoderB, kMotorCurrent, kBusVoltage},
      {kBumperFront, kBumperRear, kBumperLeft, kBumperRight, kSwitch0, kSwitch1, kSwitch2, kSwitch3, kOutput0, kOutput1, kOutput2, kOutput3,
       kOutput4, kOutput5, kOutput6, kOutput7, kBatteryA, kBatteryBoth},
      {kUartRxd, kUartTxd, kUartRts, kUartCts}};
  // Reset, factory loader, and the two of the debugger.
  const std::vector<Pin> reserved{{0, 0}, {0, 1}, {0, 10}, {1, 3}};
  for (const std::vector<Pin>& board : boards) {
    std::set<std::pair<int, int>> used;
    const auto take = [&used](const std::vector<Pin>& pins) {
      for (const Pin& pin : pins) EXPECT_TRUE(used.emplace(pin.port, pin.bit).second) << "PIO" << int{pin.port} << "_" << int{pin.bit};
    };
    take(reserved);
    take(everywhere);
    take(board);
  }
}

TEST(Lpc11c24Pins, MeasuringRangesHoldWhatTheNodesJudge) {
  using namespace lpc11c24;
  EXPECT_GT(kCurrent_a_per_count * kAdcCounts / 2, 20.0F);  // over-current is at 18 A, both ways
  EXPECT_LT(kCurrent_a_per_count, 0.1F);
  EXPECT_GT(kBus_v_per_count * kAdcCounts, 32.0F);  // braking into full batteries
  EXPECT_GT(kBatteryADivider * kAdcReference_v, 15.0F);
  EXPECT_GT(kBatteryBothDivider * kAdcReference_v, 30.0F);
}

TEST(Ring, KeepsOrderAndRefusesWhenFull) {
  cortex_m0::Ring<int, 4> ring;
  int out = 0;
  EXPECT_TRUE(ring.empty());
  EXPECT_FALSE(ring.take(out));
  for (int lap = 0; lap < 100; ++lap) {
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(ring.put(10 * lap + i));
    ASSERT_TRUE(ring.full());
    ASSERT_FALSE(ring.put(-1));
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(ring.take(out));
      ASSERT_EQ(out, 10 * lap + i);
    }
    ASSERT_FALSE(ring.take(out));
  }
}

}  // namespace
}  // namespace hoist::firmware
