// The common part of all nodes, seen from the bus. Frames are written out by hand, so that an error of the table or of the packing shows.
#include "firmware/lib/canopen_node.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "firmware/lib/convert.hpp"
#include "firmware/lib/serial_number.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/io/io_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

constexpr std::uint32_t kAskLeft = 0x601, kAnswerLeft = 0x581;

CanFrame aborted(std::uint32_t id, std::uint16_t index, std::uint8_t sub, std::uint32_t code) {
  return frame_of(id, {0x80, index & 0xFF, index >> 8, sub, static_cast<int>(code & 0xFF), static_cast<int>((code >> 8) & 0xFF),
                       static_cast<int>((code >> 16) & 0xFF), static_cast<int>(code >> 24)});
}
std::uint32_t bits_of(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, 4);
  return bits;
}

class DriveSdo : public ::testing::Test {
 protected:
  void SetUp() override {
    tick(node_, 1);
    board_.sent.clear();
  }
  CanFrame ask_left(std::initializer_list<int> bytes) { return ask(node_, board_, frame_of(kAskLeft, bytes)); }
  CanFrame write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
    return ask(node_, board_, canopen::sdo(kAskLeft, canopen::sdo_download_command(bytes), index, sub, value));
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    const CanFrame answer = ask(node_, board_, canopen::sdo(kAskLeft, 0x40, index, sub, 0));
    EXPECT_EQ(answer.data[0] & 0xE0, 0x40) << std::hex << index;
    return contract::read_le(&answer.data[4], 4);
  }
  TestBoard board_;
  DriveNode<TestBoard> node_{board_, contract::Node::drive_left};
};

TEST_F(DriveSdo, UploadsOneTwoAndFourBytes) {
  EXPECT_EQ(ask_left({0x40, 0x61, 0x60, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x4F, 0x61, 0x60, 0, 3, 0, 0, 0}));
  EXPECT_EQ(ask_left({0x40, 0x17, 0x10, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x4B, 0x17, 0x10, 0, 100, 0, 0, 0}));
  EXPECT_EQ(ask_left({0x40, 0x00, 0x10, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x43, 0x00, 0x10, 0, 0x92, 0x01, 0x02, 0x00}));
  EXPECT_EQ(ask_left({0x40, 0x85, 0x60, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x43, 0x85, 0x60, 0, 0x2C, 0x01, 0, 0}));
}

TEST_F(DriveSdo, DownloadsStoreAndAnswer) {
  EXPECT_EQ(ask_left({0x2B, 0x17, 0x10, 0, 50, 0, 0, 0}), frame_of(kAnswerLeft, {0x60, 0x17, 0x10, 0, 0, 0, 0, 0}));
  EXPECT_EQ(read(0x1017, 0), 50U);
  EXPECT_EQ(write(0x2200, 5, 4, bits_of(2.5F)).data[0], 0x60);
  EXPECT_EQ(read(0x2200, 5), bits_of(2.5F));
  // Size not given (bit 0 clear): the object's own.
  EXPECT_EQ(ask_left({0x22, 0x85, 0x60, 0, 100, 0, 0, 0}).data[0], 0x60);
  EXPECT_EQ(read(0x6085, 0), 100U);
}

TEST_F(DriveSdo, EveryObjectOfTheTableAnswersAndNoOtherDoes) {
  int answered = 0;
  for (const contract::ObjectInfo& o : contract::kObjects) {
    const bool ours = contract::object_applies(o, contract::NodeKind::drive);
    const CanFrame answer = ask(node_, board_, canopen::sdo(kAskLeft, 0x40, o.index, o.sub, 0));
    ASSERT_EQ(answer.id, kAnswerLeft);
    if (ours && o.index == 0x1003 && o.sub > 0) {
      EXPECT_EQ(answer, aborted(kAnswerLeft, o.index, o.sub, 0x08000024)) << "no error yet";
      ++answered;
    } else if (ours) {
      EXPECT_EQ(answer.data[0], canopen::sdo_upload_reply_command(contract::object_bytes(o.type))) << o.name;
      ++answered;
    } else if (contract::find_object(contract::NodeKind::drive, o.index, o.sub) == nullptr) {
      EXPECT_EQ(answer.data[0], 0x80) << o.name;
    }
  }
  EXPECT_EQ(static_cast<std::size_t>(answered), kObjectRows<contract::NodeKind::drive>.size());
}

TEST_F(DriveSdo, AbortsWithTheReason) {
  EXPECT_EQ(ask_left({0x40, 0x34, 0x12, 0, 0, 0, 0, 0}), aborted(kAnswerLeft, 0x1234, 0, 0x06020000));
  EXPECT_EQ(ask_left({0x40, 0x00, 0x22, 9, 0, 0, 0, 0}), aborted(kAnswerLeft, 0x2200, 9, 0x06090011));
  EXPECT_EQ(ask_left({0x40, 0x17, 0x10, 1, 0, 0, 0, 0}), aborted(kAnswerLeft, 0x1017, 1, 0x06090011));
  EXPECT_EQ(ask_left({0x2B, 0x41, 0x60, 0, 0, 0, 0, 0}), aborted(kAnswerLeft, 0x6041, 0, 0x06010002));
  EXPECT_EQ(ask_left({0x2F, 0x17, 0x10, 0, 50, 0, 0, 0}), aborted(kAnswerLeft, 0x1017, 0, 0x06070013));
  EXPECT_EQ(ask_left({0x23, 0x17, 0x10, 0, 50, 0, 0, 0}), aborted(kAnswerLeft, 0x1017, 0, 0x06070012));
  EXPECT_EQ(ask_left({0x2B, 0x17, 0x10, 0, 9, 0, 0, 0}), aborted(kAnswerLeft, 0x1017, 0, 0x06090030));
  EXPECT_EQ(read(0x1017, 0), 100U);  // none of that was stored
  EXPECT_EQ(node_.stack().counters().sdo_aborts, 7U);
}

TEST_F(DriveSdo, ArraysTellHowManyTheyAre) {
  EXPECT_EQ(ask_left({0x40, 0x00, 0x22, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x4F, 0x00, 0x22, 0, 5, 0, 0, 0}));
  EXPECT_EQ(ask_left({0x40, 0x18, 0x10, 0, 0, 0, 0, 0}), frame_of(kAnswerLeft, {0x4F, 0x18, 0x10, 0, 4, 0, 0, 0}));
  EXPECT_EQ(ask_left({0x2F, 0x00, 0x22, 0, 1, 0, 0, 0}), aborted(kAnswerLeft, 0x2200, 0, 0x06010002));
}

TEST_F(DriveSdo, RefusesWhatItDoesNotSpeak) {
  // Block transfer, unknown commands, a reserved bit: one abort each.
  for (const int command : {0xA0, 0xC0, 0xE0, 0xFF, 0x41, 0x33})
    EXPECT_EQ(ask_left({command, 0x17, 0x10, 0, 0, 0, 0, 0}), aborted(kAnswerLeft, 0x1017, 0, 0x05040001)) << command;
  // Segments without a transfer; their bytes name no object.
  for (const int command : {0x00, 0x01, 0x60, 0x70})
    EXPECT_EQ(ask_left({command, 0x17, 0x10, 0, 0, 0, 0, 0}), aborted(kAnswerLeft, 0, 0, 0x05040001)) << command;
  // Short requests.
  EXPECT_EQ(ask_left({0x40, 0x17, 0x10, 0}), aborted(kAnswerLeft, 0x1017, 0, 0x05040001));
  EXPECT_EQ(ask_left({0x40}), aborted(kAnswerLeft, 0, 0, 0x05040001));
  EXPECT_EQ(node_.stack().counters().wrong_length, 2U);
  // An abort is never answered.
  board_.sent.clear();
  node_.on_frame(aborted(kAskLeft, 0x1017, 0, 0x05040000));
  EXPECT_TRUE(board_.sent.empty());
}

TEST_F(DriveSdo, FloatsMustBeNumbersInRange) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(), -0.001F, 5.001F, 1e30F})
    EXPECT_EQ(write(0x2200, 1, 4, bits_of(bad)), aborted(kAnswerLeft, 0x2200, 1, 0x06090030)) << bad;
  EXPECT_EQ(write(0x2200, 1, 4, bits_of(5.0F)).data[0], 0x60);
  EXPECT_EQ(write(0x2200, 1, 4, bits_of(0.0F)).data[0], 0x60);
}

TEST_F(DriveSdo, SignedRangesAreSigned) {
  EXPECT_EQ(write(0x60FF, 0, 4, static_cast<std::uint32_t>(-400000)).data[0], 0x60);
  EXPECT_EQ(write(0x60FF, 0, 4, static_cast<std::uint32_t>(-400001)).data[0], 0x80);
  EXPECT_EQ(write(0x60FF, 0, 4, 400001).data[0], 0x80);
}

TEST_F(DriveSdo, VetoesOfTheDrive) {
  EXPECT_EQ(write(0x605A, 0, 2, 6).data[0], 0x60);
  EXPECT_EQ(write(0x605A, 0, 2, 3), aborted(kAnswerLeft, 0x605A, 0, 0x06090030));  // allowed by the table, not built
  EXPECT_EQ(write(0x1016, 1, 4, 0x007F00FA).data[0], 0x60);
  EXPECT_EQ(write(0x1016, 1, 4, 0), aborted(kAnswerLeft, 0x1016, 1, 0x06090030));           // not watching
  EXPECT_EQ(write(0x1016, 1, 4, 0x007F1388), aborted(kAnswerLeft, 0x1016, 1, 0x06090030));  // 5 s
  EXPECT_EQ(write(0x1016, 1, 4, 0x007E00FA), aborted(kAnswerLeft, 0x1016, 1, 0x06090030));  // another node
  node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 1));
  EXPECT_EQ(write(0x6040, 0, 2, 6), aborted(kAnswerLeft, 0x6040, 0, 0x08000022));
  EXPECT_EQ(write(0x60FF, 0, 4, 1), aborted(kAnswerLeft, 0x60FF, 0, 0x08000022));
}

TEST_F(DriveSdo, TheAnswerIsKeptWhenTheControllerIsFull) {
  board_.room = false;
  node_.on_frame(canopen::sdo(kAskLeft, 0x40, 0x1017, 0, 0));
  tick(node_, 3);
  board_.room = true;
  tick(node_, 3);
  EXPECT_EQ(board_.with_id(kAnswerLeft).size(), 1U);
}

TEST_F(DriveSdo, OtherNodesRequestsAndForeignFramesAreIgnored) {
  board_.sent.clear();
  node_.on_frame(canopen::sdo(0x602, 0x40, 0x1017, 0, 0));
  CanFrame extended = canopen::sdo(kAskLeft, 0x40, 0x1017, 0, 0);
  extended.flags = CanFrame::kExtended;
  node_.on_frame(extended);
  CanFrame remote = extended;
  remote.flags = CanFrame::kRemote;
  node_.on_frame(remote);
  EXPECT_TRUE(board_.sent.empty());
}

TEST(CanopenIdentity, SaysWhoItIsAndThatItIsSimulated) {
  TestBoard board;
  TiltNode<TestBoard> tilt(board, contract::Node::tilt_right);
  tick(tilt, 1);
  const auto read = [&](std::uint16_t index, std::uint8_t sub) {
    return contract::read_le(&ask(tilt, board, canopen::sdo(0x612, 0x40, index, sub, 0)).data[4], 4);
  };
  EXPECT_EQ(read(0x1000, 0), 0x0002019AU);
  EXPECT_EQ(read(0x1014, 0), 0x092U);
  EXPECT_EQ(read(0x1018, 2), 0x80000001U);
  TestBoard real;
  real.is_simulated = false;
  IoNode<TestBoard> io(real, contract::Node::io);
  tick(io, 1);
  EXPECT_EQ(ask(io, real, canopen::sdo(0x608, 0x40, 0x1018, 2, 0)), frame_of(0x588, {0x43, 0x18, 0x10, 2, 3, 0, 0, 0}));
  // CiA 401: digital inputs, digital outputs and analogue inputs.
  EXPECT_EQ(ask(io, real, canopen::sdo(0x608, 0x40, 0x1000, 0, 0)), frame_of(0x588, {0x43, 0x00, 0x10, 0, 0x91, 0x01, 0x07, 0}));
  EXPECT_EQ(ask(io, real, canopen::sdo(0x608, 0x40, 0x1018, 4, 0)), frame_of(0x588, {0x43, 0x18, 0x10, 4, 0, 0, 0, 0})) << "unknown";
}

struct NumberedBoard : TestBoard {
  static constexpr std::string_view kHardwareName = "LPC11C24";
  std::uint32_t serial_number() const { return 0x12345678; }
};
TEST(CanopenIdentity, ABoardWithANumberOfItsOwnTellsIt) {
  NumberedBoard board;
  IoNode<NumberedBoard> io(board, contract::Node::io);
  tick(io, 1);
  const CanFrame number = canopen::sdo(0x608, 0x40, 0x1018, 4, 0), told = frame_of(0x588, {0x43, 0x18, 0x10, 4, 0x78, 0x56, 0x34, 0x12});
  EXPECT_EQ(ask(io, board, number), told);
  io.on_frame(canopen::nmt(canopen::NmtCommand::reset_communication, 0));
  tick(io, 2);
  EXPECT_EQ(ask(io, board, number), told) << "after a reset of the communication, too";
  EXPECT_EQ(ask(io, board, canopen::sdo(0x608, 0x40, 0x1009, 0, 0)).data[4], 8U) << "eight letters";
}

// CRC-32 of the bytes 1 to 16, as python3 -c "import zlib; print(hex(zlib.crc32(bytes(range(1, 17)))))" gives it.
TEST(SerialNumber, IsTheChecksumOfTheChipsId) {
  constexpr std::array<std::uint32_t, 4> kId{0x04030201, 0x08070605, 0x0C0B0A09, 0x100F0E0D};
  EXPECT_EQ(serial_of(kId), 0x094C80F1U);
}

TEST(CanopenHeartbeat, ZeroSwitchesItOffAndAFloodIsRefused) {
  TestBoard board;
  IoNode<TestBoard> node(board, contract::Node::io);
  tick(node, 1);
  const auto write = [&](std::uint32_t ms) {
    return ask(node, board, canopen::sdo(0x608, canopen::sdo_download_command(2), 0x1017, 0, ms));
  };
  EXPECT_EQ(write(0).data[0], 0x60);
  board.sent.clear();
  tick(node, 70000);  // longer than a counter of 16 bit
  EXPECT_TRUE(board.with_id(0x708).empty());
  for (const std::uint32_t flood : {1U, 9U, 1001U}) EXPECT_EQ(contract::read_le(&write(flood).data[4], 4), 0x06090030U) << flood;
  EXPECT_EQ(write(10).data[0], 0x60);
  board.sent.clear();
  tick(node, 100);
  EXPECT_EQ(board.with_id(0x708).size(), 10U);
}

TEST(CanopenNmt, BootsUpThenBeatsAndFollowsCommands) {
  TestBoard board;
  IoNode<TestBoard> node(board, contract::Node::io);
  board.room = false;
  tick(node, 5);  // the boot-up message must not get lost
  board.room = true;
  tick(node, 1);
  EXPECT_EQ(board.sent, std::vector{frame_of(0x708, {0})});
  board.sent.clear();
  tick(node, 99);
  EXPECT_TRUE(board.sent.empty());
  tick(node, 1);
  EXPECT_EQ(board.sent, std::vector{frame_of(0x708, {127})});

  const auto state_after = [&](const CanFrame& command) {
    node.on_frame(command);
    board.sent.clear();
    tick(node, 100);
    const auto beats = board.with_id(0x708);
    return beats.empty() ? -1 : beats.back().data[0];
  };
  EXPECT_EQ(state_after(frame_of(0, {1, 8})), 5);
  EXPECT_EQ(state_after(frame_of(0, {2, 0})), 4);
  EXPECT_EQ(state_after(frame_of(0, {128, 8})), 127);
  EXPECT_EQ(state_after(frame_of(0, {1, 9})), 127);     // of another node
  EXPECT_EQ(state_after(frame_of(0, {77, 8})), 127);    // no such command
  EXPECT_EQ(state_after(frame_of(0, {1})), 127);        // too short
  EXPECT_EQ(state_after(frame_of(0, {1, 8, 0})), 127);  // too long
  EXPECT_EQ(node.stack().counters().unknown, 1U);
  EXPECT_EQ(node.stack().counters().wrong_length, 2U);
}

TEST(CanopenNmt, ResetsBootAgain) {
  TestBoard board;
  IoNode<TestBoard> node(board, contract::Node::io);
  make_operational(node, board);
  EXPECT_EQ(ask(node, board, canopen::sdo(0x608, 0x2B, 0x1017, 0, 50)).data[0], 0x60);
  for (const int command : {130, 129}) {
    node.on_frame(frame_of(0, {command, 8}));
    board.sent.clear();
    tick(node, 1);
    EXPECT_EQ(board.sent, std::vector{frame_of(0x708, {0})}) << command;
    EXPECT_EQ(ask(node, board, canopen::sdo(0x608, 0x40, 0x1017, 0, 0)), frame_of(0x588, {0x4B, 0x17, 0x10, 0, 100, 0, 0, 0}));
  }
}

TEST(CanopenNmt, ResetCommunicationKeepsTheApplicationsParameters) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  tick(node, 1);
  EXPECT_EQ(ask(node, board, canopen::sdo(kAskLeft, 0x23, 0x2200, 5, bits_of(2.0F))).data[0], 0x60);
  const auto limit = [&] { return contract::read_le(&ask(node, board, canopen::sdo(kAskLeft, 0x40, 0x2200, 5, 0)).data[4], 4); };
  node.on_frame(frame_of(0, {130, 1}));
  tick(node, 1);
  EXPECT_EQ(limit(), bits_of(2.0F));
  node.on_frame(frame_of(0, {129, 1}));
  tick(node, 1);
  EXPECT_EQ(limit(), bits_of(6.0F));
}

TEST(CanopenNmt, StoppedAnswersNothingButNmt) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  node.on_frame(frame_of(0, {2, 1}));
  node.on_frame(canopen::sdo(kAskLeft, 0x40, 0x1017, 0, 0));
  node.on_frame(canopen::sync());
  EXPECT_TRUE(board.sent.empty());
  // An open transfer ends silently, also without its client.
  node.on_frame(frame_of(0, {128, 1}));
  EXPECT_EQ(ask(node, board, canopen::sdo(kAskLeft, 0x40, 0x1008, 0, 0)).data[0], 0x41);
  node.on_frame(frame_of(0, {2, 1}));
  board.sent.clear();
  tick(node, 2000);
  EXPECT_TRUE(board.with_id(kAnswerLeft).empty());
}

TEST(CanopenPdo, SynchronousOnesFollowEveryNthSync) {
  TestBoard board;
  board.counts = -2;
  board.supply_voltage_v = 25.5F;
  DriveNode<TestBoard> node(board, contract::Node::drive_right);
  tick(node, 1);
  node.on_frame(canopen::sync());
  EXPECT_TRUE(board.with_id(0x182).empty());  // not operational yet
  make_operational(node, board);
  tick(node, 500);  // its self-test is over
  board.current_a = -3.0F;
  tick(node, 2);
  for (int sync = 1; sync <= 10; ++sync) {
    board.sent.clear();
    node.on_frame(canopen::sync());
    // Status: switch-on disabled, voltage, remote, speed zero. Position -2, current -3 A of 6 A = -500.
    EXPECT_EQ(board.with_id(0x182), std::vector{frame_of(0x182, {0x50, 0x12, 0xFE, 0xFF, 0xFF, 0xFF, 0x0C, 0xFE})}) << sync;
    // Speed 0, no error, 25.50 V = 2550 = 0x09F6.
    EXPECT_EQ(board.with_id(0x282), sync % 5 == 0 ? std::vector{frame_of(0x282, {0, 0, 0, 0, 0, 0, 0xF6, 0x09})} : std::vector<CanFrame>{})
        << sync;
  }
  board.sent.clear();
  node.on_frame(frame_of(0x080, {1}));  // a SYNC with a counter is none of ours
  EXPECT_TRUE(board.sent.empty());
}

TEST(CanopenEmcy, OneMessagePerChangeAndNotFasterThanTheInhibitTime) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  const CanFrame short_rpdo = frame_of(0x201, {6, 0}), good = frame_of(0x201, {6, 0, 0, 0, 0, 0});
  node.on_frame(short_rpdo);
  node.on_frame(short_rpdo);
  tick(node, 1);
  EXPECT_EQ(board.with_id(0x081), std::vector{frame_of(0x081, {0x10, 0x82, 0x11, 0, 0, 0, 0, 0})});
  board.sent.clear();
  node.on_frame(good);
  tick(node, 20);
  EXPECT_TRUE(board.with_id(0x081).empty());  // 100 ms are not over
  for (int i = 0; i < 8; ++i) {
    tick(node, 10);
    node.on_frame(good);
  }
  EXPECT_EQ(board.with_id(0x081), std::vector{frame_of(0x081, {0, 0, 0, 0, 0, 0, 0, 0})});
}

TEST(CanopenEmcy, AFloodIsBoundedAndCounted) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  for (int i = 0; i < 100; ++i) {
    node.on_frame(frame_of(0x201, {6, 0}));
    node.on_frame(frame_of(0x201, {6, 0, 0, 0, 0, 0}));
  }
  EXPECT_EQ(node.stack().counters().emcy_lost, 200U - kEmcyQueueMax);
}

// ---- the error memory 1003h

TEST(CanopenEmcy, ErrorsAreRememberedNewestFirstUntilForgotten) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  const auto read = [&](int sub) { return ask(node, board, frame_of(kAskLeft, {0x40, 0x03, 0x10, sub, 0, 0, 0, 0})); };
  EXPECT_EQ(read(0), frame_of(kAnswerLeft, {0x4F, 0x03, 0x10, 0, 0, 0, 0, 0}));
  EXPECT_EQ(read(1), aborted(kAnswerLeft, 0x1003, 1, 0x08000024));
  for (int i = 0; i < 3; ++i) {
    node.on_frame(frame_of(0x201, {6, 0}));              // too short: 8210h
    node.on_frame(frame_of(0x201, {6, 0, 0, 0, 0, 0}));  // good: the error's end is no error
  }
  tick(node, 46);  // and no more: 8250h
  EXPECT_EQ(read(0).data[4], 4);
  EXPECT_EQ(read(1), frame_of(kAnswerLeft, {0x43, 0x03, 0x10, 1, 0x50, 0x82, 0x11, 0}));
  for (const int sub : {2, 3, 4}) EXPECT_EQ(read(sub), frame_of(kAnswerLeft, {0x43, 0x03, 0x10, sub, 0x10, 0x82, 0x11, 0}));
  EXPECT_EQ(read(5), aborted(kAnswerLeft, 0x1003, 5, 0x06090011));
  EXPECT_EQ(ask(node, board, frame_of(kAskLeft, {0x2F, 0x03, 0x10, 0, 1, 0, 0, 0})), aborted(kAnswerLeft, 0x1003, 0, 0x06090030));
  EXPECT_EQ(read(0).data[4], 4);
  EXPECT_EQ(ask(node, board, frame_of(kAskLeft, {0x2F, 0x03, 0x10, 0, 0, 0, 0, 0})).data[0], 0x60);
  EXPECT_EQ(read(0).data[4], 0);
  EXPECT_EQ(read(1), aborted(kAnswerLeft, 0x1003, 1, 0x08000024));
}

// ---- the computer's heartbeat

TEST(CanopenHeartbeat, TheInputBoardMissesItsComputer) {
  TestBoard board;
  IoNode<TestBoard> node(board, contract::Node::io);
  make_operational(node, board);
  tick(node, 1000);
  EXPECT_TRUE(node.stack().operational());  // never received: not lost
  node.on_frame(frame_of(0x77F, {5}));
  tick(node, 249);
  EXPECT_TRUE(node.stack().operational());
  board.sent.clear();
  tick(node, 1);
  EXPECT_FALSE(node.stack().operational());
  EXPECT_EQ(board.with_id(0x088), std::vector{frame_of(0x088, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0})});
  // Only the control computer can be watched, with at most half a second.
  for (const std::uint32_t bad : {0U, 0x007F0000U, 0x007F0063U, 0x007F01F5U, 0x001100FAU})
    EXPECT_EQ(ask(node, board, canopen::sdo(0x608, 0x23, 0x1016, 1, bad)), aborted(0x588, 0x1016, 1, 0x06090030)) << std::hex << bad;
  EXPECT_EQ(ask(node, board, canopen::sdo(0x608, 0x23, 0x1016, 1, 0x007F012C)).data[0], 0x60);
}

// ---- texts

TEST(CanopenIdentity, SaysItsNamesInWords) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  tick(node, 1);
  const auto text = [&](int index) {
    std::string out;
    const CanFrame first = ask(node, board, frame_of(kAskLeft, {0x40, index, 0x10, 0, 0, 0, 0, 0}));
    EXPECT_EQ(first.data[0], 0x41);
    for (bool toggle = false, last = false; !last && out.size() < 100; toggle = !toggle) {
      const CanFrame answer = ask(node, board, frame_of(kAskLeft, {toggle ? 0x70 : 0x60, 0, 0, 0, 0, 0, 0, 0}));
      for (int i = 0; i < 7 - ((answer.data[0] >> 1) & 7); ++i) out += static_cast<char>(answer.data[static_cast<std::size_t>(i) + 1]);
      last = (answer.data[0] & 1) != 0;
    }
    EXPECT_EQ(out.size(), first.data[4]);
    return out;
  };
  EXPECT_EQ(text(0x08), "Hoist drive");
  EXPECT_EQ(text(0x09), "simulated");
  EXPECT_EQ(text(0x0A), HOIST_PROJECT_VERSION);
  EXPECT_EQ(ask(node, board, frame_of(kAskLeft, {0x2F, 0x08, 0x10, 0, 65, 0, 0, 0})), aborted(kAnswerLeft, 0x1008, 0, 0x06010002));
  EXPECT_EQ(ask(node, board, frame_of(kAskLeft, {0x40, 0x08, 0x10, 1, 0, 0, 0, 0})), aborted(kAnswerLeft, 0x1008, 1, 0x06090011));
}

// ---- communication records of the PDOs

class PdoRecords : public ::testing::Test {
 protected:
  void SetUp() override { tick(node_, 1); }
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
    const CanFrame answer = ask(node_, board_, canopen::sdo(0x608, canopen::sdo_download_command(bytes), index, sub, value));
    return answer.data[0] == 0x60 ? 0 : contract::read_le(&answer.data[4], 4);
  }
  std::uint32_t read(std::uint16_t index, std::uint8_t sub) {
    return contract::read_le(&ask(node_, board_, canopen::sdo(0x608, 0x40, index, sub, 0)).data[4], 4);
  }
  TestBoard board_;
  IoNode<TestBoard> node_{board_, contract::Node::io};
};

TEST_F(PdoRecords, DescribeWhatIsSent) {
  EXPECT_EQ(read(0x1800, 0), 5U);
  EXPECT_EQ(read(0x1800, 1), 0x40000188U);
  EXPECT_EQ(read(0x1400, 1), 0x208U);
  EXPECT_EQ(read(0x1800, 2), 255U);
  EXPECT_EQ(read(0x1800, 3), 100U);
  EXPECT_EQ(read(0x1800, 5), 10U);
  EXPECT_EQ(read(0x1A00, 0), 2U);
  EXPECT_EQ(read(0x1A00, 1), 0x60000108U);
  EXPECT_EQ(read(0x1A01, 4), 0x64010410U);
  EXPECT_EQ(read(0x1200, 1), 0x608U);
  EXPECT_EQ(read(0x1200, 2), 0x588U);
  EXPECT_EQ(write(0x1A00, 1, 4, 0x60000208), 0x06010002U);
}

TEST_F(PdoRecords, IdsAndTimesTakeEffectAtOnceAndOnlyBeforeTheStart) {
  EXPECT_EQ(write(0x1800, 1, 4, 0x400001A5), 0U);
  EXPECT_EQ(write(0x1800, 5, 2, 50), 0U);
  EXPECT_EQ(write(0x1801, 2, 1, 3), 0U);  // with every third SYNC
  make_operational(node_, board_);
  tick(node_, 100);
  EXPECT_EQ(board_.with_id(0x1A5).size(), 2U);
  EXPECT_TRUE(board_.with_id(0x188).empty());
  EXPECT_TRUE(board_.with_id(0x288).empty());
  for (int i = 0; i < 6; ++i) node_.on_frame(canopen::sync());
  EXPECT_EQ(board_.with_id(0x288).size(), 2U);
  EXPECT_EQ(write(0x1800, 1, 4, 0x40000188), 0x08000022U);
  EXPECT_EQ(write(0x1800, 2, 1, 1), 0x08000022U);
  EXPECT_EQ(write(0x1800, 5, 2, 20), 0x08000022U);
  EXPECT_EQ(read(0x1800, 1), 0x400001A5U);
  // Only the off switch works while operational.
  EXPECT_EQ(write(0x1800, 1, 4, 0xC00001A5), 0U);
  board_.sent.clear();
  tick(node_, 200);
  EXPECT_TRUE(board_.with_id(0x1A5).empty());
}

TEST_F(PdoRecords, TypeZeroWaitsForAnEventAndASync) {
  EXPECT_EQ(write(0x1800, 2, 1, 0), 0U);
  make_operational(node_, board_);
  node_.on_frame(canopen::sync());
  tick(node_, 50);
  EXPECT_TRUE(board_.with_id(0x188).empty());
  board_.bumper_bits = 1;
  tick(node_, 20);
  EXPECT_TRUE(board_.with_id(0x188).empty());
  node_.on_frame(canopen::sync());
  node_.on_frame(canopen::sync());
  EXPECT_EQ(board_.with_id(0x188).size(), 1U);
}

TEST_F(PdoRecords, AnEventTimerOfZeroSendsOnChangeOnly) {
  EXPECT_EQ(write(0x1800, 5, 2, 0), 0U);
  make_operational(node_, board_);
  tick(node_, 500);
  EXPECT_TRUE(board_.with_id(0x188).empty());
  board_.bumper_bits = 1;
  tick(node_, 1);
  EXPECT_EQ(board_.with_id(0x188).size(), 1U);
}

TEST_F(PdoRecords, IdsThatAreNoPdosOfThatDirectionAreRefused) {
  for (const std::uint32_t bad :
       {0x000U, 0x080U, 0x180U, 0x200U, 0x208U, 0x481U + 0x80U, 0x580U, 0x588U, 0x608U, 0x708U, 0x7FFU, 0x20000188U, 0x188U + 0x800U})
    for (const std::uint32_t no_remote : {0U, 0x40000000U}) EXPECT_EQ(write(0x1800, 1, 4, bad | no_remote), 0x06090030U) << std::hex << bad;
  EXPECT_EQ(write(0x1800, 1, 4, 0x400004FF), 0U);
  // A cleared bit 30 enables answers to remote frames, which no node gives (CiA 301); in received ids the bit has no meaning.
  for (const std::uint32_t remote : {0x4FFU, 0x188U, 0x80000188U})
    EXPECT_EQ(write(0x1800, 1, 4, remote), 0x06090030U) << std::hex << remote;
  for (const std::uint32_t id : {0x208U, 0x40000208U, 0x80000208U}) EXPECT_EQ(write(0x1400, 1, 4, id), 0U) << std::hex << id;
  EXPECT_EQ(write(0x1400, 1, 4, 0x202), 0x06090030U);
  for (const std::uint32_t bad : {241U, 252U, 253U}) EXPECT_EQ(write(0x1800, 2, 1, bad), 0x06090030U) << bad;
}

TEST(PdoRecordsOfADrive, H2ACommandKeepsItsId) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  tick(node, 1);
  const auto write = [&](std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
    return ask(node, board, canopen::sdo(kAskLeft, canopen::sdo_download_command(bytes), 0x1400, sub, value)).data[0];
  };
  EXPECT_EQ(write(1, 4, 0x191), 0x80);  // a tilt sensor's id, six bytes long like a command
  EXPECT_EQ(write(2, 1, 1), 0x80);      // commands do not wait for a SYNC
  EXPECT_EQ(write(1, 4, 0x301), 0x80);
  EXPECT_EQ(write(1, 4, 0x202), 0x80);  // the other wheel's
  make_operational(node, board);
  node.on_frame(frame_of(0x202, {6, 0, 0, 0, 0, 0}));
  EXPECT_FALSE(node.stack().rpdo_alive());
  node.on_frame(frame_of(0x201, {6, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(node.stack().rpdo_alive());
  EXPECT_EQ(write(1, 4, 0x80000201), 0x80);  // a command cannot be switched off while operational
  node.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  EXPECT_EQ(write(1, 4, 0x80000201), 0x60);
  make_operational(node, board);
  node.on_frame(frame_of(0x201, {6, 0, 0, 0, 0, 0}));
  EXPECT_FALSE(node.stack().rpdo_alive());
}

// ---- the controller's health

TEST(CanopenHealth, TheControllersCountersAndErrorsAreTold) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  board.health = {CanHealth::State::passive, 130, 7, 3};
  tick(node, 2);
  const auto read = [&](int sub) {
    return contract::read_le(&ask(node, board, frame_of(kAskLeft, {0x40, 0x00, 0x23, sub, 0, 0, 0, 0})).data[4], 4);
  };
  EXPECT_EQ(board.with_id(0x081), std::vector{frame_of(0x081, {0x10, 0x81, 0x11, 0, 0, 0, 0, 0})});  // frames were lost
  EXPECT_EQ(read(1), 2U);
  EXPECT_EQ(read(2), 130U);
  EXPECT_EQ(read(3), 7U);
  EXPECT_EQ(read(4), 3U);
  tick(node, 110);
  EXPECT_EQ(board.with_id(0x081), std::vector{frame_of(0x081, {0x20, 0x81, 0x11, 0, 0, 0, 0, 0})});
  EXPECT_TRUE(node.stack().operational());
  board.health.state = CanHealth::State::active;
  board.sent.clear();
  tick(node, 1200);
  EXPECT_EQ(board.with_id(0x081).size(), 2U);  // both errors are over
  EXPECT_EQ(board.with_id(0x081).back().data[2], 0);
}

TEST(CanopenHealth, BusOffLeavesOperationAndIsAskedBack) {
  TestBoard board;
  DriveNode<TestBoard> node(board, contract::Node::drive_left);
  make_operational(node, board);
  board.health.state = CanHealth::State::bus_off;
  board.room = false;
  tick(node, 199);
  EXPECT_FALSE(node.stack().operational());
  EXPECT_EQ(board.can_restarts, 0);
  tick(node, 2);
  EXPECT_EQ(board.can_restarts, 1);
  tick(node, 400);
  EXPECT_EQ(board.can_restarts, 3);  // again and again, with pauses
  board.health.state = CanHealth::State::active;
  board.room = true;
  tick(node, 400);
  const auto emergencies = board.with_id(0x081);
  EXPECT_TRUE(
      std::any_of(emergencies.begin(), emergencies.end(), [](const CanFrame& f) { return f.data[0] == 0x40 && f.data[1] == 0x81; }));
  EXPECT_EQ(node.stack().values().get<0x1001>(), 0);
  EXPECT_FALSE(node.stack().operational());  // until its master starts it
  EXPECT_EQ((node.stack().values().get<0x2300, 5>()), 1);
}

TEST(Convert, RoundsAndHoldsAtTheEnds) {
  EXPECT_EQ(to_integer<std::int16_t>(1.5F), 2);
  EXPECT_EQ(to_integer<std::int16_t>(-1.5F), -2);
  EXPECT_EQ(to_integer<std::int16_t>(0.49F), 0);
  EXPECT_EQ(to_integer<std::int16_t>(1e9F), 32767);
  EXPECT_EQ(to_integer<std::int16_t>(-1e9F), -32768);
  EXPECT_EQ(to_integer<std::uint16_t>(-3.0F), 0);
  EXPECT_EQ(to_integer<std::int32_t>(3e9F), std::numeric_limits<std::int32_t>::max());
  EXPECT_EQ(to_integer<std::int32_t>(std::numeric_limits<float>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace hoist::firmware
