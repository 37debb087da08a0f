// What can be said about the boards without a board: places in memory that two programs must agree on, pins that may be used once.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "control/contract/bus_load.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/can_filter.hpp"
#include "firmware/boards/cortex_m0/ring.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/parameter_pages.hpp"
#include "firmware/boards/lpc11c24/pins.hpp"
#include "firmware/boards/lpc11c24/transmit_order.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/boards/stm32f072/pins.hpp"
#include "firmware/boards/stm32f072/transmit_order.hpp"
#include "firmware/lib/mailbox.hpp"
#include "firmware/lib/parameter_store.hpp"

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
  EXPECT_EQ(kParametersStart + kSectorBytes, 0x8000U);  // 32 KB of flash
  EXPECT_EQ(kParametersStart % kSectorBytes, 0U);       // an erase must not reach into the program
  EXPECT_EQ(kMailboxBytes, sizeof(Mailbox));
  EXPECT_EQ(kStackTop + 32, kRamStart + kRamBytes);  // the factory's flash routines use the last 32 bytes
  // The boot ROM runs after each reset and may overwrite RAM.
  EXPECT_TRUE(kMailboxStart + kMailboxBytes <= kRamStart || kMailboxStart >= kRamStart + kRamBytes);
  EXPECT_EQ(kStackTop % 8, 0U);  // ARM procedure call standard
}

// The response times of the bus are computed for senders that send by priority: no two frames of one sender share a message object, and the
// objects rise with the identifiers.
TEST(Lpc11c24Can, NoFrameOfASenderWaitsBehindOneOfLowerPriority) {
  const contract::BusPlan plan = contract::bus_plan(contract::SwitchedPdos::all);
  for (std::size_t n = 0; n < contract::kNodes.size(); ++n) {
    std::uint32_t before = 0;
    for (const contract::BusFrame& frame : plan) {
      // The plan counts all SDO together; each node answers.
      if (frame.sender != static_cast<contract::Node>(n) && frame.kind != contract::FrameKind::service) continue;
      const std::uint32_t object = lpc11c24::transmit_object({frame.id, frame.bytes, 0, {}});
      EXPECT_GT(object, before) << std::hex << frame.id;
      EXPECT_LT(object, lpc11c24::kReceiveFirst);
      before = object;
    }
  }
}
TEST(Lpc11c24Can, ARemoteFrameIsSentFromBehindTheReceivingChain) {
  for (const std::uint32_t id : {0x000U, 0x181U, 0x711U, 0x7FFU})
    EXPECT_GT(lpc11c24::transmit_object({id, 0, contract::CanFrame::kRemote, {}}), lpc11c24::kReceiveLast);
  EXPECT_EQ(lpc11c24::transmit_object({0x711U << 18, 0, contract::CanFrame::kExtended, {}}), lpc11c24::transmit_object({0x711, 0, 0, {}}));
}

// With any lower frames of the board in the mailboxes, SYNC and EMCY find a free one at once, PDOs after one lower PDO has been sent.
TEST(Stm32f072Can, LowerFramesNeverFillAllMailboxes) {
  const auto order = [](std::uint32_t id) { return cortex_m0::arbitration_order({id, 0, 0, {}}); };
  const std::array<std::uint32_t, 7> ids{0x080, 0x081, 0x181, 0x281, 0x282, 0x581, 0x701};
  std::vector<std::uint32_t> waiting;
  // All of them come, the lowest first, again and again: as a busy bus would leave them.
  for (int round = 0; round < 3; ++round)
    for (auto id = ids.rbegin(); id != ids.rend(); ++id)
      if (waiting.size() < 3 && std::find(waiting.begin(), waiting.end(), order(*id)) == waiting.end() &&
          stm32f072::may_take_mailbox(order(*id), waiting))
        waiting.push_back(order(*id));
  EXPECT_EQ(waiting, (std::vector<std::uint32_t>{order(0x701), order(0x282), order(0x081)}));
  const std::array service{order(0x701)};
  const std::array two{order(0x282), order(0x581)};
  EXPECT_FALSE(stm32f072::may_take_mailbox(order(0x581), service));
  EXPECT_TRUE(stm32f072::may_take_mailbox(order(0x181), service));
  EXPECT_FALSE(stm32f072::may_take_mailbox(order(0x181), two));
  EXPECT_TRUE(stm32f072::may_take_mailbox(order(0x080), two));
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

// Every limit that 2231h:1 allows must be one that a reading can pass: with 2 % of the divider and 2 % of the reference.
void expect_over_voltage_measurable(float full_scale_v) {
  const contract::ObjectInfo* limit = contract::find_object(contract::NodeKind::drive, 0x2231, 1);
  ASSERT_NE(limit, nullptr);
  EXPECT_GT(static_cast<double>(full_scale_v), 1.04 * limit->max);
}

TEST(Lpc11c24Pins, MeasuringRangesHoldWhatTheNodesJudge) {
  using namespace lpc11c24;
  EXPECT_GT(kCurrent_a_per_count * kAdcCounts / 2, 20.0F);  // over-current is at 18 A, both ways
  EXPECT_LT(kCurrent_a_per_count, 0.1F);
  expect_over_voltage_measurable(kBus_v_per_count * kAdcCounts);
  EXPECT_GT(kBatteryADivider * kAdcReference_v, 15.0F);
  EXPECT_GT(kBatteryBothDivider * kAdcReference_v, 30.0F);
}

TEST(Stm32f072Memory, TheLoaderAndTheApplicationMeanTheSamePlaces) {
  using namespace stm32f072;
  const contract::ImageChipInfo* chip = contract::find_image_chip("stm32f072");
  ASSERT_NE(chip, nullptr);
  EXPECT_EQ(chip->application_at, kApplicationStart);
  EXPECT_EQ(chip->application_max, kApplicationBytes);
  EXPECT_EQ(chip->ram_at, kRamStart);
  EXPECT_EQ(chip->ram_bytes, kRamBytes);
  EXPECT_EQ(kApplicationStart + kApplicationBytes, kParametersStart);
  EXPECT_EQ(kParametersStart + 2 * kPageBytes, kFlashStart + kFlashBytes);
  EXPECT_EQ(kMailboxBytes, sizeof(Mailbox));
  EXPECT_EQ(kMailboxStart % 8, 0U);  // the stack begins there
}

TEST(Stm32f072Pins, MeasuringRangesHoldWhatTheNodesJudge) {
  using namespace stm32f072;
  EXPECT_GT(kCurrent_a_per_count * kAdcCounts / 2, 20.0F);  // over-current is at 18 A, both ways
  expect_over_voltage_measurable(kBus_v_per_count * kAdcCounts);
}

TEST(Stm32f072Pins, NoPinHasTwoJobsOnOneBoard) {
  using namespace stm32f072;
  const std::vector<Pin> everywhere{kCanRx, kCanTx, kStrap0, kStrap1, kService, kLed};
  const std::vector<std::vector<Pin>> boards{
      {kI2cScl, kI2cSda, kSpiSck, kSpiMiso, kSpiMosi, kSpiSelect},
      {kBridgeEnable, kBridgePhase, kBridgeAwake, kBridgeFault, kEncoderA, kEncoderB, kEdgeA, kEdgeB, kEdgeOpen, kMotorCurrent,
       kBusVoltage},
      {kBumperFront, kBumperRear, kBumperLeft, kBumperRight, kSwitch0, kSwitch1, kSwitch2, kSwitch3, kOutput0, kOutput1, kOutput2, kOutput3,
       kOutput4, kOutput5, kOutput6, kOutput7, kBatteryA, kBatteryBoth},
      {kUartRxd, kUartTxd, kUartRts, kUartCts}};
  const std::vector<Pin> debugger{{'A', 13}, {'A', 14}};
  for (const std::vector<Pin>& board : boards) {
    std::set<std::pair<char, int>> used;
    for (const std::vector<Pin>& pins : {debugger, everywhere, board})
      for (const Pin& pin : pins) EXPECT_TRUE(used.emplace(pin.port, pin.bit).second) << 'P' << pin.port << int{pin.bit};
  }
}

// A sector of flash whose power can be cut in any operation: a cut write leaves its first half, a cut erase anything.
class CutSector {
 public:
  static constexpr std::size_t kBytes = 0x1000;
  CutSector() { bytes_.fill(std::byte{0xFF}); }

  bool erase() {
    ++erases_;
    if (cut()) {
      for (std::size_t i = 0; i < bytes_.size(); i += 2) bytes_[i] = std::byte{0xFF};
      return false;
    }
    if (off_) return false;
    bytes_.fill(std::byte{0xFF});
    return true;
  }
  bool write(std::size_t offset, const std::array<std::uint32_t, 64>& words) {
    EXPECT_EQ(offset % 256, 0U);
    EXPECT_LE(offset + 256, kBytes);
    const bool half = cut();
    if (off_ && !half) return false;
    const auto from = std::as_bytes(std::span(words));
    for (std::size_t i = 0; i < (half ? 128U : 256U); ++i) {
      EXPECT_EQ(bytes_[offset + i], std::byte{0xFF}) << "written twice without an erase";
      bytes_[offset + i] = from[i];
    }
    return !half;
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  void cut_in(int operations) { cut_in_ = operations; }
  void power_on() {
    off_ = false;
    cut_in_ = 0;
  }
  [[nodiscard]] int erases() const { return erases_; }
  [[nodiscard]] bool was_cut() const { return off_; }

 private:
  bool cut() {
    if (off_ || cut_in_ == 0 || --cut_in_ != 0) return false;
    off_ = true;
    return true;
  }
  std::array<std::byte, kBytes> bytes_{};
  int cut_in_ = 0, erases_ = 0;
  bool off_ = false;
};
using Pages = lpc11c24::ParameterPages<CutSector>;
static_assert(FlashPages<Pages>);

constexpr std::size_t kRecords = 40;  // more than any node has, two write pieces
bool save(Pages& pages, std::uint32_t mark) {
  ParameterStore<Pages> store(pages, 1);
  return store.save(kRecords, [mark](std::size_t i) {
    return StoredValue{static_cast<std::uint16_t>(0x2000 + i), 1, 4, mark * 1000 + static_cast<std::uint32_t>(i)};
  });
}
// The mark of all records; 0 without a good copy.
std::uint32_t load(Pages& pages) {
  ParameterStore<Pages> store(pages, 1);
  std::uint32_t mark = 0, count = 0;
  const StoreState state = store.load([&](const StoredValue& value) {
    EXPECT_TRUE(count == 0 || value.raw / 1000 == mark);
    mark = value.raw / 1000;
    ++count;
  });
  if (state != StoreState::good) return 0;
  EXPECT_EQ(count, kRecords);
  return mark;
}

TEST(ParameterPages, KeepTheNewestCopyAndEraseSeldom) {
  auto pages = std::make_unique<Pages>();
  EXPECT_EQ(load(*pages), 0U);
  for (std::uint32_t mark = 1; mark <= 100; ++mark) {
    ASSERT_TRUE(save(*pages, mark));
    ASSERT_EQ(load(*pages), mark);
    auto after_reset = std::make_unique<Pages>();
    after_reset->sector() = pages->sector();
    ASSERT_EQ(load(*after_reset), mark);
    if (mark % 3 == 0) pages = std::move(after_reset);
  }
  EXPECT_LE(pages->sector().erases(), 100 / 6 + 1);
}

TEST(ParameterPages, ACutOfThePowerLosesNothingButInTheRareErase) {
  int cuts = 0, in_erase = 0;
  for (std::uint32_t saves = 0; saves < 20; ++saves) {
    for (int operation = 1; operation <= 8; ++operation) {
      Pages pages;
      for (std::uint32_t mark = 1; mark <= saves; ++mark) ASSERT_TRUE(save(pages, mark));
      const int erases_before = pages.sector().erases();
      pages.sector().cut_in(operation);
      const bool saved = save(pages, saves + 1);
      const bool cut = pages.sector().was_cut();
      const bool erased = pages.sector().erases() > erases_before;
      ASSERT_TRUE(saved || cut);
      Pages after;
      after.sector() = pages.sector();
      after.sector().power_on();
      const std::uint32_t mark = load(after);
      if (cut) ++cuts;
      if (cut && erased) {
        ++in_erase;  // the erase itself, or writing back what it took: the one gap that README.md names
      } else {
        ASSERT_TRUE(mark == saves + 1 || (cut && mark == saves)) << saves << " saves, cut in operation " << operation << ": " << mark;
      }
      // The next save always works.
      ASSERT_TRUE(save(after, 999));
      ASSERT_EQ(load(after), 999U);
    }
  }
  EXPECT_GT(cuts, 40);
  EXPECT_GT(in_erase, 0);
  EXPECT_LT(in_erase, cuts / 4);
}

TEST(ParameterPages, RefuseWhatDoesNotFit) {
  Pages pages;
  std::array<std::byte, 1024> bytes{};
  EXPECT_FALSE(pages.erase(2));
  EXPECT_FALSE(pages.erase(-1));
  EXPECT_FALSE(pages.write(2, 0, std::span(bytes).first(256)));
  EXPECT_FALSE(pages.write(0, 128, std::span(bytes).first(256)));
  EXPECT_FALSE(pages.write(0, 0, std::span(bytes).first(100)));
  EXPECT_FALSE(pages.write(0, 256, std::span(bytes).first(512)));
  EXPECT_TRUE(pages.read(2).empty());
  EXPECT_EQ(load(pages), 0U);
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
