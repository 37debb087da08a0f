// Parameters in flash: alone, with a power cut at every byte that is written and at every erase, and behind 1010h and 1011h of a node.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <random>
#include <vector>

#include "firmware/lib/parameter_store.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

// Flash whose supply fails after a number of steps. A step is one byte written, or one of the eight parts of an erase, which leaves the
// rest of the page as it was. After the cut nothing is written any more.
struct CutFlash {
  static constexpr std::size_t kPageBytes = 1024;
  std::array<std::array<std::byte, kPageBytes>, 2> pages{};
  std::optional<std::size_t> steps_left{};
  std::size_t steps = 0;
  std::optional<std::size_t> wrong_bit{};  // of a page: what is written turns it over

  CutFlash() {
    for (auto& page : pages) page.fill(std::byte{0xFF});
  }
  bool step() {
    if (steps_left && *steps_left == 0) return false;
    if (steps_left) --*steps_left;
    ++steps;
    return true;
  }
  bool erase(int page) {
    auto& bytes = pages[static_cast<std::size_t>(page)];
    for (std::size_t part = 0; part < 8; ++part) {
      if (!step()) return false;
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(part * kPageBytes / 8), kPageBytes / 8, std::byte{0xFF});
    }
    return true;
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    EXPECT_EQ(offset % 256, 0U);
    EXPECT_EQ(bytes.size() % 256, 0U);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (!step()) return false;
      pages[static_cast<std::size_t>(page)][offset + i] &= bytes[i];
      if (wrong_bit && *wrong_bit / 8 == offset + i) pages[static_cast<std::size_t>(page)][offset + i] ^= std::byte(1U << *wrong_bit % 8);
    }
    return true;
  }
  std::span<const std::byte> read(int page) const { return pages[static_cast<std::size_t>(page)]; }
};

using Values = std::vector<StoredValue>;

StoreState load(CutFlash& flash, Values& values, std::uint8_t kind = 1) {
  values.clear();
  return ParameterStore(flash, kind).load([&](const StoredValue& value) { values.push_back(value); });
}
bool save(CutFlash& flash, const Values& values, std::uint8_t kind = 1) {
  return ParameterStore(flash, kind).save(values.size(), [&](std::size_t i) { return values[i]; });
}
Values some(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  Values values(count);
  for (auto& v : values)
    v = {static_cast<std::uint16_t>(random()), static_cast<std::uint8_t>(random()), 4, static_cast<std::uint32_t>(random())};
  return values;
}

TEST(ParameterStore, KeepsWhatWasSavedLast) {
  CutFlash flash;
  Values read;
  EXPECT_EQ(load(flash, read), StoreState::empty);
  EXPECT_TRUE(read.empty());
  for (std::uint32_t i = 0; i < 10; ++i) {
    const Values values = some(3 * i, i);
    ASSERT_TRUE(save(flash, values));
    EXPECT_EQ(load(flash, read), StoreState::good);
    EXPECT_EQ(read, values);
  }
}

TEST(ParameterStore, TheFormatIsWhatIsWrittenDown) {
  CutFlash flash;
  ASSERT_TRUE(save(flash, {{0x2200, 5, 4, 0x40200000}}, 1));
  const std::array<std::uint8_t, 20> expected = {'H',  'P',  'R', 'M', 1, 0, 0,    0,  // magic, first copy
                                                 1,    0,    1,   0,                   // kind, one record
                                                 0x00, 0x22, 5,   4,   0, 0, 0x20, 0x40};
  EXPECT_EQ(std::memcmp(flash.pages[0].data(), expected.data(), expected.size()), 0);
  contract::Crc32 crc;
  crc.add(expected);
  std::uint32_t stored;
  std::memcpy(&stored, &flash.pages[0][20], 4);
  EXPECT_EQ(stored, crc.value());
}

TEST(ParameterStore, MoreThanAPageHoldsIsRefusedBeforeAnythingIsErased) {
  CutFlash flash;
  ASSERT_TRUE(save(flash, some(126, 1)));  // 12 + 126 * 8 + 4 = 1024
  flash.steps = 0;
  EXPECT_FALSE(save(flash, some(127, 2)));
  EXPECT_EQ(flash.steps, 0U);
  Values read;
  EXPECT_EQ(load(flash, read), StoreState::good);
  EXPECT_EQ(read, some(126, 1));
}

TEST(ParameterStore, ASequenceNumberThatWrapsIsStillNewer) {
  CutFlash flash;
  ASSERT_TRUE(save(flash, some(2, 1)));
  // As after four thousand million saves.
  for (std::size_t i = 4; i < 8; ++i) flash.pages[0][i] = std::byte{0xFF};
  contract::Crc32 crc;
  for (std::size_t i = 0; i < 28; ++i) {
    const auto byte = std::to_integer<std::uint8_t>(flash.pages[0][i]);
    crc.add(std::span(&byte, 1));
  }
  const std::uint32_t value = crc.value();
  std::memcpy(&flash.pages[0][28], &value, 4);
  Values read;
  ASSERT_EQ(load(flash, read), StoreState::good);
  ASSERT_TRUE(save(flash, some(2, 2)));
  EXPECT_EQ(load(flash, read), StoreState::good);
  EXPECT_EQ(read, some(2, 2));
}

TEST(ParameterStore, AnotherKindsParametersAreNone) {
  CutFlash flash;
  ASSERT_TRUE(save(flash, some(4, 1), 1));
  Values read;
  EXPECT_EQ(load(flash, read, 0), StoreState::lost);
  EXPECT_TRUE(read.empty());
}

// The property: for a power cut anywhere in a save, the next start finds either the complete old or the complete new values, and the next
// save works.
TEST(ParameterStore, APowerCutAnywhereLeavesTheOldOrTheNewCopyWhole) {
  const Values first = some(20, 1), second = some(31, 2), third = some(5, 3);
  std::size_t steps = 0;
  {
    CutFlash flash;
    ASSERT_TRUE(save(flash, first));
    ASSERT_TRUE(save(flash, second));
    flash.steps = 0;
    ASSERT_TRUE(save(flash, third));
    steps = flash.steps;
  }
  ASSERT_GT(steps, 256U);
  int kept_old = 0, kept_new = 0;
  for (std::size_t cut = 0; cut <= steps; ++cut) {
    CutFlash flash;
    ASSERT_TRUE(save(flash, first));
    ASSERT_TRUE(save(flash, second));
    flash.steps_left = cut;
    const bool told_done = save(flash, third);
    flash.steps_left.reset();
    Values read;
    ASSERT_EQ(load(flash, read), StoreState::good) << cut;
    ASSERT_TRUE(read == second || read == third) << cut;
    ASSERT_TRUE(!told_done || read == third) << cut;
    read == third ? ++kept_new : ++kept_old;
    ASSERT_TRUE(save(flash, first)) << cut;
    ASSERT_EQ(load(flash, read), StoreState::good);
    ASSERT_EQ(read, first) << cut;
  }
  EXPECT_GT(kept_old, 40);
  EXPECT_GE(kept_new, 1);
}

TEST(ParameterStore, ACutInTheVeryFirstSaveIsTold) {
  CutFlash flash;
  flash.steps_left = 20;
  EXPECT_FALSE(save(flash, some(10, 1)));
  flash.steps_left.reset();
  Values read;
  EXPECT_EQ(load(flash, read), StoreState::lost);
  EXPECT_TRUE(read.empty());
}

// Worn flash: each write is told done, and one bit of one is not as written.
TEST(ParameterStore, ACopyThatReadsBackWrongIsNotSaved) {
  CutFlash flash;
  ASSERT_TRUE(save(flash, some(20, 1)));
  for (std::size_t bit = 0; bit < store_bytes(20) * 8; ++bit) {
    flash.wrong_bit = bit;
    ASSERT_FALSE(save(flash, some(20, 2))) << bit;
    Values read;
    ASSERT_EQ(load(flash, read), StoreState::good);
    ASSERT_EQ(read, some(20, 1)) << "the old copy still counts";
  }
}

// A first copy that was damaged later is not the same as none.
TEST(ParameterStore, ADamagedPageBesideABlankOneIsTold) {
  for (const std::size_t page : {0U, 1U}) {
    CutFlash flash;
    flash.pages[page][0] = std::byte{0};
    Values read;
    EXPECT_EQ(load(flash, read), StoreState::lost) << page;
  }
}

TEST(ParameterStore, EverySingleWrongBitIsFound) {
  const Values old = some(4, 1), now = some(6, 2);
  CutFlash good;
  ASSERT_TRUE(save(good, old));
  ASSERT_TRUE(save(good, now));
  const std::size_t bytes = store_bytes(now.size());
  for (std::size_t bit = 0; bit < 8 * bytes; ++bit) {
    CutFlash flash = good;
    flash.pages[1][bit / 8] ^= std::byte{1} << (bit % 8);
    Values read;
    ASSERT_EQ(load(flash, read), StoreState::good) << bit;
    ASSERT_EQ(read, old) << bit;
    // Both copies invalid: neither is used.
    flash.pages[0][bit % (8 * store_bytes(old.size())) / 8] ^= std::byte{0x10};
    ASSERT_EQ(load(flash, read), StoreState::lost) << bit;
    ASSERT_TRUE(read.empty());
  }
}

TEST(ParameterStore, NoiseIsNeverBelieved) {
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    CutFlash flash;
    for (auto& page : flash.pages)
      for (auto& byte : page) byte = static_cast<std::byte>(random());
    if (i % 2 == 0) {  // a head that looks right, with any number of records
      const std::array<std::uint8_t, 12> head = {
          'H', 'P', 'R', 'M', 1, 0, 0, 0, 1, 0, static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random())};
      std::memcpy(flash.pages[0].data(), head.data(), head.size());
    }
    Values read;
    ASSERT_EQ(load(flash, read), StoreState::lost);
    ASSERT_TRUE(read.empty());
  }
}

// ---- behind 1010h and 1011h

constexpr std::uint32_t kSaveWord = 0x65766173, kLoadWord = 0x64616F6C;

class StoredDrive : public ::testing::Test {
 protected:
  void SetUp() override { tick(node_, 1); }
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
    const CanFrame answer = ask(node_, board_, canopen::sdo(0x601, canopen::sdo_download_command(bytes), index, sub, value));
    return answer.data[0] == 0x60 ? 0 : contract::read_le(&answer.data[4], 4);
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    return contract::read_le(&ask(node_, board_, canopen::sdo(0x601, 0x40, index, sub, 0)).data[4], 4);
  }
  void restart() {
    node_.power_on();
    board_.sent.clear();
    tick(node_, 2);
  }
  TestBoard board_;
  DriveNode<TestBoard> node_{board_, contract::Node::drive_left};
};

TEST_F(StoredDrive, SavesParametersAndNotCommands) {
  EXPECT_EQ(read(0x1010, 1), 1U);  // saves on command
  EXPECT_EQ(write(0x6085, 0, 4, 250), 0U);
  EXPECT_EQ(write(0x1017, 0, 2, 50), 0U);
  EXPECT_EQ(write(0x60FF, 0, 4, 1000), 0U);
  restart();
  EXPECT_EQ(read(0x6085, 0), 300U);  // not saved: lost
  EXPECT_EQ(write(0x6085, 0, 4, 250), 0U);
  EXPECT_EQ(write(0x1017, 0, 2, 50), 0U);
  EXPECT_EQ(write(0x60FF, 0, 4, 1000), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  restart();
  EXPECT_EQ(read(0x6085, 0), 250U);
  EXPECT_EQ(read(0x1017, 0), 50U);
  EXPECT_EQ(read(0x60FF, 0), 0U);
  EXPECT_EQ(read(0x1010, 1), 1U);
  EXPECT_TRUE(board_.with_id(0x081).empty());
}

// Its master could not find a node without heartbeat.
TEST_F(StoredDrive, AHeartbeatThatIsOffLastsUntilTheNextStart) {
  EXPECT_EQ(write(0x1017, 0, 2, 0), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  EXPECT_EQ(read(0x1017, 0), 0U);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 1));
  tick(node_, 2);
  EXPECT_EQ(read(0x1017, 0), 100U);
  EXPECT_EQ(write(0x1017, 0, 2, 0), 0U);
  restart();
  EXPECT_EQ(read(0x1017, 0), 100U);
  EXPECT_TRUE(node_.stack().parameters_ok());
}

TEST_F(StoredDrive, DefaultsComeBackWithTheNextStart) {
  EXPECT_EQ(write(0x6085, 0, 4, 250), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  EXPECT_EQ(write(0x1011, 1, 4, kLoadWord), 0U);
  EXPECT_EQ(read(0x6085, 0), 250U);
  restart();
  EXPECT_EQ(read(0x6085, 0), 300U);
  EXPECT_TRUE(node_.stack().parameters_ok());
}

TEST_F(StoredDrive, AWrongWordSavesNothing) {
  EXPECT_EQ(write(0x6085, 0, 4, 250), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kLoadWord), 0x08000020U);
  EXPECT_EQ(write(0x1010, 1, 4, 1), 0x08000020U);
  EXPECT_EQ(write(0x1011, 1, 4, kSaveWord), 0x08000020U);
  restart();
  EXPECT_EQ(read(0x6085, 0), 300U);
}

TEST_F(StoredDrive, NothingIsSavedWhileTheDriveWorks) {
  make_operational(node_, board_);
  tick(node_, 500);  // its self-test is over
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0x08000022U);
  EXPECT_EQ(write(0x1011, 1, 4, kLoadWord), 0x08000022U);
  // Out of operation, but still braking on the ramp: the flash would stop the servo.
  using State = contract::canopen::drive::State;
  const auto word = [&](int low) {
    node_.on_frame(frame_of(0x201, {low, 0, 0, 0, 0, 0}));
    tick(node_, 5);
  };
  for (const State braking : {State::quick_stop_active, State::fault_reaction}) {
    node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 1));
    for (const int low : {0x06, 0x07, 0x0F}) word(low);
    for (int i = 0; i < 20; ++i) word(0x0F);
    ASSERT_EQ(node_.state(), State::operation_enabled);
    if (braking == State::fault_reaction) {
      EXPECT_EQ(write(0x2230, 2, 4, std::bit_cast<std::uint32_t>(80.0F)), 0U);  // the winding counts as 90 degrees warm after power-on
      tick(node_, 2);
      ASSERT_EQ(node_.state(), braking);
    }
    node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 1));
    tick(node_, 2);
    ASSERT_EQ(node_.state(), braking);
    EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0x08000022U);
    tick(node_, 1000);
    EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  }
}

TEST_F(StoredDrive, LostParametersAreToldUntilTheyAreSavedAgain) {
  EXPECT_EQ(write(0x6085, 0, 4, 250), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  ASSERT_TRUE(board_.flash().write(0, 0, std::array<std::byte, 256>{}));  // both copies overwritten with zeros
  ASSERT_TRUE(board_.flash().write(1, 0, std::array<std::byte, 256>{}));
  restart();
  EXPECT_FALSE(node_.stack().parameters_ok());
  EXPECT_EQ(read(0x6085, 0), 300U);
  EXPECT_EQ(read(0x1003, 1), 0x00216310U);
  node_.power_on();
  board_.sent.clear();
  tick(node_, 2);
  EXPECT_EQ(board_.with_id(0x081), std::vector{frame_of(0x081, {0x10, 0x63, 0x21, 0, 0, 0, 0, 0})});
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  EXPECT_TRUE(node_.stack().parameters_ok());
  restart();
  EXPECT_TRUE(node_.stack().parameters_ok());
  EXPECT_EQ(read(0x1001, 0), 0U);
}

TEST_F(StoredDrive, ValuesThatTodaysProgramDoesNotAllowAreDefaults) {
  const Values stored = {{0x6085, 0, 4, 9999}, {0x1017, 0, 2, 70}, {0x7777, 1, 4, 5}, {0x6041, 0, 2, 0x27}};
  ASSERT_TRUE(ParameterStore(board_.flash(), static_cast<std::uint8_t>(contract::NodeKind::drive)).save(stored.size(), [&](std::size_t i) {
    return stored[i];
  }));
  restart();
  EXPECT_EQ(read(0x6085, 0), 300U);
  EXPECT_EQ(read(0x1017, 0), 70U);
  EXPECT_NE(read(0x6041, 0) & 0x6FU, 0x27U);  // a state is no parameter
  EXPECT_FALSE(node_.stack().parameters_ok());
}

// A reset of the communication restores only its own objects; what it leaves as it is may still be what is lost.
TEST_F(StoredDrive, AResetOfTheCommunicationHidesNoLostParameters) {
  const Values stored = {{0x6085, 0, 4, 9999}, {0x1017, 0, 2, 70}};
  ASSERT_TRUE(ParameterStore(board_.flash(), static_cast<std::uint8_t>(contract::NodeKind::drive)).save(stored.size(), [&](std::size_t i) {
    return stored[i];
  }));
  restart();
  ASSERT_FALSE(node_.stack().parameters_ok());
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 1));
  tick(node_, 2);
  EXPECT_EQ(read(0x1017, 0), 70U);
  EXPECT_FALSE(node_.stack().parameters_ok());
}

// Identifiers and mounting saved at one place do not apply at another. A drive would follow the other one's commands.
TEST_F(StoredDrive, ABoardSavedAtAnotherPlaceDoesNotWorkAsThatOne) {
  ASSERT_EQ(write(0x6085, 0, 4, 250), 0U);
  ASSERT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  board_.sent.clear();
  DriveNode<TestBoard> right{board_, contract::Node::drive_right};
  make_operational(right, board_);
  tick(right, 40);
  EXPECT_FALSE(right.stack().parameters_ok());
  EXPECT_EQ(right.state(), contract::canopen::drive::State::fault);
  for (const int low : {0x06, 0x07, 0x0F}) {
    right.on_frame(frame_of(0x201, {low, 0, 0, 0, 0, 0}));
    tick(right, 5);
  }
  EXPECT_NE(right.state(), contract::canopen::drive::State::operation_enabled);
  EXPECT_FALSE(board_.bridge_on);
  right.on_frame(canopen::sync());
  tick(right, 2);
  EXPECT_TRUE(board_.with_id(0x181).empty());
  EXPECT_FALSE(board_.with_id(0x182).empty());
  // Saving the values at the new place makes them its own.
  right.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 2));
  tick(right, 2);
  EXPECT_EQ(ask(right, board_, canopen::sdo(0x602, canopen::sdo_download_command(4), 0x1010, 1, kSaveWord)).data[0], 0x60);
  DriveNode<TestBoard> again{board_, contract::Node::drive_right};
  tick(again, 2);
  EXPECT_TRUE(again.stack().parameters_ok());
}

// A copy of a program that did not save the place.
TEST_F(StoredDrive, ACopyWithoutAPlaceIsBelieved) {
  const Values stored = {{0x6085, 0, 4, 250}};
  ASSERT_TRUE(ParameterStore(board_.flash(), static_cast<std::uint8_t>(contract::NodeKind::drive)).save(stored.size(), [&](std::size_t i) {
    return stored[i];
  }));
  restart();
  EXPECT_EQ(read(0x6085, 0), 250U);
  EXPECT_TRUE(node_.stack().parameters_ok());
}

TEST_F(StoredDrive, APdosIdIsKeptAndComesBackWithACommunicationReset) {
  EXPECT_EQ(write(0x1801, 1, 4, 0x40000281), 0U);
  EXPECT_EQ(write(0x1801, 1, 4, 0x40000381), 0U);
  EXPECT_EQ(write(0x1010, 1, 4, kSaveWord), 0U);
  EXPECT_EQ(write(0x1801, 1, 4, 0x40000282), 0U);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 1));
  tick(node_, 2);
  EXPECT_EQ(read(0x1801, 1), 0x40000381U);
}

TEST(Stored, EveryKindsParametersFitAndComeBack) {
  EXPECT_GT(kStoredRows<contract::NodeKind::drive>.size(), 20U);
  TestBoard board;
  TiltNode<TestBoard> node(board, contract::Node::tilt_left);
  tick(node, 1);
  const auto write = [&](std::uint16_t index, std::uint8_t sub, std::uint32_t value) {
    return ask(node, board, canopen::sdo(0x611, canopen::sdo_download_command(4), index, sub, value)).data[0];
  };
  EXPECT_EQ(write(0x1801, 1, 0x40000291), 0x60);
  EXPECT_EQ(write(0x1010, 1, kSaveWord), 0x60);
  node.power_on();
  make_operational(node, board);
  node.on_frame(canopen::sync());
  EXPECT_EQ(board.with_id(0x291).size(), 1U);
}

}  // namespace
}  // namespace hoist::firmware
