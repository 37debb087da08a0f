#include "firmware/nodes/gateway/gateway_node.hpp"

#include <gtest/gtest.h>

#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

class GatewayTest : public ::testing::Test {
 protected:
  std::string say(const std::string& text) {
    board_.to_host.clear();
    board_.from_host += text;
    node_.tick_1ms();
    return board_.to_host;
  }
  void open() { ASSERT_EQ(say("C\rS5\rO\r"), "\r\r\r"); }
  TestBoard board_;
  GatewayNode<TestBoard> node_{board_};
};

TEST_F(GatewayTest, OpensAndCarriesFramesBothWays) {
  open();
  EXPECT_EQ(say("t20160F00A0860100\r"), "z\r");
  ASSERT_EQ(board_.sent.size(), 1U);
  EXPECT_EQ(board_.sent[0], frame_of(0x201, {0x0F, 0, 0xA0, 0x86, 1, 0}));
  EXPECT_EQ(say("T01ABCDEF0\r"), "Z\r");
  board_.to_host.clear();
  node_.on_frame(frame_of(0x193, {1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(board_.to_host, "t1936010203040506\r");
}

TEST_F(GatewayTest, ClosedItSendsAndReportsNothing) {
  EXPECT_EQ(say("t0800\r"), "\a");
  node_.on_frame(frame_of(0x193, {1}));
  EXPECT_EQ(board_.to_host, "\a");
  EXPECT_TRUE(board_.sent.empty());
}

TEST_F(GatewayTest, TheSecondOpenIsRefusedButStaysOpen) {
  open();
  EXPECT_EQ(say("O\r"), "\a");
  EXPECT_EQ(say("t0800\r"), "z\r");
  EXPECT_EQ(board_.sent.size(), 1U);
}

TEST_F(GatewayTest, ListenOnlyRefusesToSend) {
  EXPECT_EQ(say("L\rt0800\r"), "\r\a");
  board_.to_host.clear();
  node_.on_frame(frame_of(0x080, {}));
  EXPECT_EQ(board_.to_host, "t0800\r");
  EXPECT_TRUE(board_.sent.empty());
}

TEST_F(GatewayTest, AnswersQuestionsAndRefusesTheRest) {
  EXPECT_EQ(say("V\rv\rN\rF\r"), "V1010\rv0001\rNSIM1\rF00\r");
  EXPECT_EQ(say("S4\rS\rS55\rq\rM12345678\rm00000000\rU1\rW0\rs0011\rzz\rz\rt123412\r\x80\r"), std::string(13, '\a'));
  EXPECT_EQ(say("M00000000\rmFFFFFFFF\rX1\rZ0\r"), "\r\r\r\r");
  EXPECT_EQ(say("\r\r\r"), "");  // empty lines clear the line, nothing else
  open();
  EXPECT_EQ(say("S5\r"), "\a");  // only while closed
  EXPECT_EQ(say("Z1\r"), "\a");
  EXPECT_EQ(node_.counters().refused, 15U);
  board_.is_simulated = false;
  EXPECT_EQ(say("N\r"), "N0001\r");
}

TEST_F(GatewayTest, SendsByIdWhenTheControllerIsBusy) {
  open();
  board_.room = false;
  EXPECT_EQ(say("t60180000000000000000\rt70180000000000000000\rt2016000000000000\rt0800\rt60181111111111111111\r"), "z\rz\rz\rz\rz\r");
  board_.room = true;
  node_.poll();
  ASSERT_EQ(board_.sent.size(), 5U);
  EXPECT_EQ(board_.sent[0].id, 0x080U);
  EXPECT_EQ(board_.sent[1].id, 0x201U);
  EXPECT_EQ(board_.sent[2].id, 0x601U);
  EXPECT_EQ(board_.sent[2].data[0], 0);
  EXPECT_EQ(board_.sent[3].id, 0x601U);
  EXPECT_EQ(board_.sent[3].data[0], 0x11);
  EXPECT_EQ(board_.sent[4].id, 0x701U);
}

TEST_F(GatewayTest, AFullQueueRefusesAndSetsItsFlag) {
  open();
  board_.room = false;
  std::string lines, answers;
  for (std::size_t i = 0; i < kGatewayTxMax; ++i) lines += "t1230\r", answers += "z\r";
  EXPECT_EQ(say(lines + "t0800\r"), answers + "\a");
  EXPECT_EQ(say("F\r"), "F02\r");
  EXPECT_EQ(say("F\r"), "F00\r");
  EXPECT_EQ(say("C\r"), "\r");  // what waited is gone
  board_.room = true;
  node_.poll();
  EXPECT_TRUE(board_.sent.empty());
}

TEST_F(GatewayTest, ASlowSerialLineLosesWholeFramesAndCountsThem) {
  open();
  board_.to_host.clear();
  board_.uart_room = 0;
  const CanFrame frame = frame_of(0x193, {1, 2, 3, 4, 5, 6});
  for (int i = 0; i < 100; ++i) node_.on_frame(frame);
  board_.uart_room = 1U << 20;
  const std::string answer = say("F\r");
  const std::size_t kept = (kGatewayUartMax - kGatewayReplyRoom) / 18;
  std::string expected;
  for (std::size_t i = 0; i < kept; ++i) expected += "t1936010203040506\r";
  EXPECT_EQ(answer, expected + "F09\r");
  EXPECT_EQ(node_.counters().lost_to_uart, 100 - kept);
  EXPECT_EQ(node_.counters().to_uart, kept);
}

TEST_F(GatewayTest, StampsCountMillisecondsModuloOneMinute) {
  ASSERT_EQ(say("Z1\rO\r"), "\r\r");
  const auto stamp = [&] {
    board_.to_host.clear();
    node_.on_frame(frame_of(0x080, {}));
    return board_.to_host;
  };
  EXPECT_EQ(stamp(), "t08000001\r");
  for (int i = 0; i < 59998; ++i) node_.tick_1ms();
  EXPECT_EQ(stamp(), "t0800EA5F\r");
  node_.tick_1ms();
  EXPECT_EQ(stamp(), "t08000000\r");
}

TEST_F(GatewayTest, PollingOnRequest) {
  ASSERT_EQ(say("X0\rO\r"), "\r\r");
  EXPECT_EQ(say("t0800\r"), "\r");
  for (int i = 0; i < 3; ++i) node_.on_frame(frame_of(0x191, {i}));
  EXPECT_EQ(say("P\r"), "t191100\r");
  EXPECT_EQ(say("A\r"), "t191101\rt191102\rA\r");
  EXPECT_EQ(say("P\r"), "\r");
  EXPECT_EQ(say("X1\rP\r"), "\r\a");
}

TEST_F(GatewayTest, PowerOnCloses) {
  open();
  node_.power_on();
  EXPECT_FALSE(node_.open());
  EXPECT_EQ(say("t0800\r"), "\a");
}

}  // namespace
}  // namespace hoist::firmware
