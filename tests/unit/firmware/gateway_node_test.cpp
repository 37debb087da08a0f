#include "firmware/nodes/gateway/gateway_node.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

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
  EXPECT_EQ(say("\r\r\r"), "");  // empty lines only clear the input line
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
  EXPECT_EQ(say("C\r"), "\r");  // waiting frames are dropped
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

TEST_F(GatewayTest, H5_AFrameThatTheBusDidNotTakeInTimeIsNeverSent) {
  open();
  board_.room = false;
  EXPECT_EQ(say("t20160F00A0860100\r"), "z\r");
  tick(node_, 30);
  EXPECT_EQ(say("t0800\r"), "z\r");
  tick(node_, 25);  // the first is 55 ms old, the second 25
  board_.room = true;
  node_.poll();
  ASSERT_EQ(board_.sent.size(), 1U);
  EXPECT_EQ(board_.sent[0].id, 0x080U);
  EXPECT_EQ(node_.counters().stale, 1U);
  EXPECT_EQ(say("F\r"), "F02\r");
}

// Frames taken by the controller wait in its own queue, as on both boards. Without acknowledge it is never bus-off and keeps them.
struct QueueBoard : TestBoard {
  std::vector<CanFrame> queue;
  bool send(const CanFrame& frame) {
    if (queue.size() == 16) return false;
    queue.push_back(frame);
    return true;
  }
  bool all_sent() const { return queue.empty(); }
  void drop_unsent() { queue.clear(); }
};
TEST(GatewayQueue, H5_NeitherDoesWhatTheControllerHasTakenWaitLonger) {
  QueueBoard board;
  GatewayNode<QueueBoard> node(board);
  board.from_host = "S5\rO\r";
  node.tick_1ms();
  board.from_host = "t20160F00A0860100\r";
  for (int i = 0; i < 45; ++i) node.tick_1ms();
  EXPECT_EQ(board.queue.size(), 1U);
  for (int i = 0; i < 10; ++i) node.tick_1ms();
  EXPECT_TRUE(board.queue.empty());
  EXPECT_EQ(node.counters().stale, 1U);
  // A controller that can send keeps each one.
  for (int i = 0; i < 100; ++i) {
    board.from_host = "t0800\r";
    node.tick_1ms();
    if (i % 10 == 9) board.queue.clear();
  }
  EXPECT_EQ(node.counters().stale, 1U);
}

TEST_F(GatewayTest, H5_BusOffDropsWhatWaitedRefusesMoreAndComesBackByItself) {
  open();
  board_.room = false;
  EXPECT_EQ(say("t20160F00A0860100\r"), "z\r");
  board_.health = {CanHealth::State::bus_off, 255, 40, 0};
  tick(node_, 1);
  board_.room = true;
  EXPECT_EQ(say("t20160F00A0860100\r"), "\a");
  EXPECT_TRUE(board_.sent.empty());
  EXPECT_EQ(say("F\r"), "F82\r");
  tick(node_, 195);
  EXPECT_EQ(board_.can_restarts, 0);
  tick(node_, 10);
  EXPECT_EQ(board_.can_restarts, 1);
  tick(node_, 1000);  // still blocked: retried, but not in every millisecond
  EXPECT_EQ(board_.can_restarts, 6);
  board_.health = {};
  EXPECT_EQ(say("t0800\r"), "z\r");
  ASSERT_EQ(board_.sent.size(), 1U);
  EXPECT_EQ(node_.counters().bus_off, 1U);
  tick(node_, 1000);
  EXPECT_EQ(board_.can_restarts, 6);
}

TEST_F(GatewayTest, WithoutBeingAskedItTellsNoStates) {
  open();
  board_.to_host.clear();
  board_.health = {CanHealth::State::bus_off, 255, 0, 7};
  tick(node_, 500);
  EXPECT_EQ(board_.to_host, "");
}

TEST_F(GatewayTest, TellsEachStateOnceWithItsCounters) {
  ASSERT_EQ(say("E1\rO\r"), "\r\r");
  EXPECT_EQ(say("E0\r"), "\a");  // only while closed
  board_.to_host.clear();
  const auto becomes = [&](CanHealth::State state, std::uint8_t tx, std::uint8_t rx) {
    board_.health.state = state;
    board_.health.tx_errors = tx;
    board_.health.rx_errors = rx;
    tick(node_, 1000);
  };
  becomes(CanHealth::State::active, 5, 0);
  becomes(CanHealth::State::warning, 96, 3);
  becomes(CanHealth::State::warning, 97, 3);
  becomes(CanHealth::State::passive, 128, 120);
  becomes(CanHealth::State::bus_off, 255, 0);
  becomes(CanHealth::State::active, 0, 0);
  EXPECT_EQ(board_.to_host, "sw003096\rsp120128\rsb000255\rsa000000\r");
  for (const char* text : {"sw003096", "sb000255"}) EXPECT_EQ(contract::slcan_parse(text).kind, contract::SlcanKind::state);
}

TEST_F(GatewayTest, ATroubleThatIsThereWhenItOpensIsTold) {
  board_.health = {CanHealth::State::passive, 0, 130, 0};
  ASSERT_EQ(say("E1\r"), "\r");
  tick(node_, 200);
  EXPECT_EQ(say("O\r"), "\rsp130000\r");
}

TEST_F(GatewayTest, AStateThatFluttersCannotFloodTheLine) {
  ASSERT_EQ(say("E1\rO\r"), "\r\r");
  board_.to_host.clear();
  for (int i = 0; i < 1000; ++i) {
    board_.health.state = i % 2 == 0 ? CanHealth::State::passive : CanHealth::State::warning;
    board_.health.lost += 3;
    tick(node_, 1);
  }
  EXPECT_LE(std::count(board_.to_host.begin(), board_.to_host.end(), 's'), 11);
  const auto errors = std::count(board_.to_host.begin(), board_.to_host.end(), 'e');
  EXPECT_LE(errors, 11);
  EXPECT_GE(errors, 9);
}

TEST_F(GatewayTest, LostFramesAreToldInBothDirections) {
  ASSERT_EQ(say("E1\rO\r"), "\r\r");
  board_.to_host.clear();
  board_.health.lost = 4;
  tick(node_, 200);
  EXPECT_EQ(board_.to_host, "e1o\r");
  EXPECT_EQ(say("F\r"), "F09\r");
  board_.room = false;
  std::string lines;
  for (std::size_t i = 0; i <= kGatewayTxMax; ++i) lines += "t1230\r";
  EXPECT_EQ(say(lines).substr(2 * kGatewayTxMax), "\ae1O\r");
  board_.health.lost = 5;
  board_.to_host.clear();
  tick(node_, 200);  // the queue's frames go stale as well
  EXPECT_TRUE(board_.to_host.find("e2oO\r") != std::string::npos || board_.to_host.find("e1o\r") != std::string::npos);
  EXPECT_EQ(contract::slcan_parse("e2oO").kind, contract::SlcanKind::error);
}

TEST_F(GatewayTest, NewsNeverTakeTheRoomOfFrames) {
  ASSERT_EQ(say("E1\rO\r"), "\r\r");
  board_.uart_room = 0;
  board_.to_host.clear();
  const CanFrame frame = frame_of(0x193, {1, 2, 3, 4, 5, 6});
  for (int i = 0; i < 40; ++i) node_.on_frame(frame);
  board_.health = {CanHealth::State::passive, 0, 130, 9};
  tick(node_, 1000);
  board_.uart_room = 40 * 18;  // exactly the frames
  node_.poll();
  EXPECT_EQ(board_.to_host.size(), 40U * 18U);
  EXPECT_EQ(board_.to_host.find_first_of("se"), std::string::npos);
  EXPECT_EQ(node_.counters().lost_to_uart, 0U);
}

TEST_F(GatewayTest, AnyTextAndAnyHealthKeepItAlive) {
  std::mt19937 random(4);
  for (int i = 0; i < 60000; ++i) {
    static constexpr std::string_view kLetters = "OLCSEXZPAFVvNMmtTrRz0123456789ABF\r\r\r\a";
    if (random() % 3U == 0) board_.from_host += kLetters[random() % kLetters.size()];
    if (random() % 20U == 0) board_.from_host += "\rt2016000000000000\r";
    if (random() % 50U == 0) board_.health.state = static_cast<CanHealth::State>(random() % 4U);
    if (random() % 50U == 0) board_.health.lost += random() % 1000U;
    board_.room = random() % 4U != 0;
    board_.uart_room = random() % 2U == 0 ? 0 : random() % 64U;
    if (random() % 2U == 0) node_.on_frame(frame_of(0x193, {1, 2}));
    const std::size_t before = board_.sent.size();
    node_.tick_1ms();
    ASSERT_TRUE(board_.health.state != CanHealth::State::bus_off || board_.sent.size() == before);
    if (board_.to_host.size() > 10000) board_.to_host.clear();
    if (board_.sent.size() > 1000) board_.sent.clear();
  }
  EXPECT_GT(node_.counters().to_bus, 0U);
}

TEST_F(GatewayTest, PowerOnCloses) {
  open();
  node_.power_on();
  EXPECT_FALSE(node_.open());
  EXPECT_EQ(say("t0800\r"), "\a");
}

}  // namespace
}  // namespace hoist::firmware
