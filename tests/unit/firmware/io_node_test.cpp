#include "firmware/nodes/io/io_node.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

class IoTest : public ::testing::Test {
 protected:
  void SetUp() override { make_operational(node_, board_); }
  std::vector<CanFrame> bumper_frames(int milliseconds) {
    board_.sent.clear();
    tick(node_, milliseconds);
    return board_.with_id(0x188);
  }
  TestBoard board_;
  IoNode<TestBoard> node_{board_, contract::Node::io};
};

TEST_F(IoTest, SendsBothPeriodically) {
  EXPECT_EQ(bumper_frames(200).size(), 20U);
  EXPECT_EQ(board_.with_id(0x288).size(), 2U);
  // 12.50 V = 1250 = 0x04E2, 12.25 V = 1225 = 0x04C9.
  EXPECT_EQ(board_.with_id(0x288)[0], frame_of(0x288, {0xE2, 0x04, 0xC9, 0x04, 0, 0, 0, 0}));
  EXPECT_EQ(board_.with_id(0x188)[0], frame_of(0x188, {0, 0}));
}

TEST_F(IoTest, ABumperIsSentWithinTenMilliseconds) {
  tick(node_, 55);  // 5 ms after the last frame
  board_.bumper_bits = 1;
  EXPECT_TRUE(bumper_frames(4).empty());
  EXPECT_EQ(bumper_frames(1), std::vector{frame_of(0x188, {1, 0})});
  board_.switch_bits = 0x80;
  EXPECT_TRUE(bumper_frames(9).empty());  // the inhibit time
  EXPECT_EQ(bumper_frames(1), std::vector{frame_of(0x188, {1, 0x80})});
}

TEST_F(IoTest, AShortTouchIsNotLost) {
  tick(node_, 41);  // 1 ms after a periodic frame: the inhibit time runs
  board_.bumper_bits = 4;
  tick(node_, 1);
  board_.bumper_bits = 0;
  const auto frames = bumper_frames(30);
  ASSERT_GE(frames.size(), 2U);
  EXPECT_EQ(frames[0], frame_of(0x188, {4, 0}));
  EXPECT_EQ(frames[1], frame_of(0x188, {0, 0}));
}

TEST_F(IoTest, AChatteringBumperCannotFloodTheBus) {
  board_.sent.clear();
  for (int i = 0; i < 1000; ++i) {
    board_.bumper_bits = static_cast<std::uint8_t>(i % 2);
    tick(node_, 1);
  }
  EXPECT_LE(board_.with_id(0x188).size(), 100U);
  EXPECT_GE(board_.with_id(0x188).size(), 99U);
}

TEST_F(IoTest, AFullControllerDelaysButDoesNotLoseATouch) {
  tick(node_, 55);
  board_.room = false;
  board_.bumper_bits = 2;
  tick(node_, 5);
  board_.bumper_bits = 0;
  tick(node_, 5);
  board_.room = true;
  EXPECT_EQ(bumper_frames(1), std::vector{frame_of(0x188, {2, 0})});
  EXPECT_GT(node_.stack().counters().tx_refused, 0U);
}

TEST_F(IoTest, ImpossibleVoltagesReadAsEmpty) {
  board_.batteries_v[0] = std::numeric_limits<float>::quiet_NaN();
  board_.batteries_v[1] = -3;
  board_.sent.clear();
  tick(node_, 100);
  EXPECT_EQ(board_.with_id(0x288), std::vector{frame_of(0x288, {0, 0, 0, 0, 0, 0, 0, 0})});
}

TEST_F(IoTest, OutputsFollowTheComputerAndGoOffWithoutIt) {
  EXPECT_EQ(board_.output_bits, 0);
  for (int i = 0; i < 10; ++i) {
    node_.on_frame(frame_of(0x208, {0xA5}));
    tick(node_, 50);
    EXPECT_EQ(board_.output_bits, 0xA5);
  }
  tick(node_, 60);  // 110 ms after the last: one may be lost, the next comes at 100
  EXPECT_EQ(board_.output_bits, 0xA5);
  tick(node_, 11);  // 120 ms
  EXPECT_EQ(board_.output_bits, 0);
  EXPECT_EQ(board_.with_id(0x088).size(), 1U);
  EXPECT_EQ(contract::read_le(&board_.with_id(0x088)[0].data[0], 2), 0x8250U);
  node_.on_frame(frame_of(0x208, {0x01}));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 1);
}

TEST_F(IoTest, ErrorValuesDecideWhatHappensToEachOutput) {
  const auto write = [&](std::uint16_t index, std::uint32_t value) {
    return ask(node_, board_, canopen::sdo(0x608, canopen::sdo_download_command(1), index, 1, value)).data[0];
  };
  EXPECT_EQ(write(0x6206, 0x0F), 0x60);  // the upper four stay as they are
  EXPECT_EQ(write(0x6207, 0x02), 0x60);  // of the lower four, only output 1 is on
  node_.on_frame(frame_of(0x208, {0x55}));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x55);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x52);
  node_.on_frame(frame_of(0x208, {0xFF}));  // no receiver
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x52);
  node_.power_on();
  EXPECT_EQ(board_.output_bits, 0);
}

TEST_F(IoTest, AnSdoSwitchesNothingOn) {
  EXPECT_EQ(ask(node_, board_, canopen::sdo(0x608, canopen::sdo_download_command(1), 0x6200, 1, 0xFF)).data[0], 0x80);
  tick(node_, 5);
  EXPECT_EQ(board_.output_bits, 0);
}

TEST_F(IoTest, AFrameOfTheWrongLengthSwitchesNothing) {
  node_.on_frame(frame_of(0x208, {0xFF, 0xFF}));
  node_.on_frame(frame_of(0x208, {}));
  tick(node_, 5);
  EXPECT_EQ(board_.output_bits, 0);
  EXPECT_EQ(node_.stack().counters().wrong_length, 2U);
}

TEST_F(IoTest, SilentUnlessOperational) {
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  board_.bumper_bits = 1;
  EXPECT_TRUE(bumper_frames(50).empty());
  node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  EXPECT_EQ(bumper_frames(20).at(0), frame_of(0x188, {1, 0}));
}

}  // namespace
}  // namespace hoist::firmware
