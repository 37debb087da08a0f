#include "firmware/nodes/io/io_node.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <ostream>
#include <utility>
#include <vector>

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

TEST_F(IoTest, ATouchOutsideOfOperationIsNoStopOfTheNextStart) {
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  board_.bumper_bits = 4;
  tick(node_, 1);
  board_.bumper_bits = 0;
  tick(node_, 1);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  for (const CanFrame& frame : bumper_frames(30)) EXPECT_EQ(frame, frame_of(0x188, {0, 0}));
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

// The outputs that follow 6200h; the others are buzzer and lights.
constexpr std::uint8_t kFree = 0x87;
constexpr std::uint8_t kLights = canopen::kRedLight | canopen::kYellowLight | canopen::kCyanLight;

TEST_F(IoTest, OutputsFollowTheComputerAndGoOffWithoutIt) {
  EXPECT_EQ(board_.output_bits, 0);
  for (int i = 0; i < 10; ++i) {
    node_.on_frame(frame_of(0x208, {0xA5, 0}));
    tick(node_, 50);
    EXPECT_EQ(board_.output_bits, 0xA5 & kFree) << "buzzer and lights are the node's own";
  }
  tick(node_, 60);  // 110 ms after the last: one may be lost, the next comes at 100
  EXPECT_EQ(board_.output_bits, 0xA5 & kFree);
  tick(node_, 11);  // 120 ms
  EXPECT_EQ(board_.output_bits & kFree, 0);
  EXPECT_EQ(board_.with_id(0x088).size(), 1U);
  EXPECT_EQ(contract::read_le(&board_.with_id(0x088)[0].data[0], 2), 0x8250U);
  node_.on_frame(frame_of(0x208, {0x01, 0}));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 1);
}

TEST_F(IoTest, ErrorValuesDecideWhatHappensToEachOutput) {
  const auto write = [&](std::uint16_t index, std::uint32_t value) {
    return ask(node_, board_, canopen::sdo(0x608, canopen::sdo_download_command(1), index, 1, value)).data[0];
  };
  EXPECT_EQ(write(0x6206, 0x0F), 0x60);  // the upper four stay as they are
  EXPECT_EQ(write(0x6207, 0x02), 0x60);  // of the lower four, only output 1 is on
  node_.on_frame(frame_of(0x208, {0xD5, 0}));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x85);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x82);
  node_.on_frame(frame_of(0x208, {0xFF, 0}));  // no receiver
  tick(node_, 1);
  EXPECT_EQ(board_.output_bits, 0x82);
  node_.power_on();
  EXPECT_EQ(board_.output_bits, 0);
}

TEST_F(IoTest, AnSdoSwitchesNothingOn) {
  for (const int index : {0x6200, 0x2400})
    EXPECT_EQ(ask(node_, board_, canopen::sdo(0x608, canopen::sdo_download_command(1), static_cast<std::uint16_t>(index), 1, 0x0F)).data[0],
              0x80);
  tick(node_, 5);
  EXPECT_EQ(board_.output_bits, 0);
}

TEST_F(IoTest, AFrameOfTheWrongLengthSwitchesNothing) {
  node_.on_frame(frame_of(0x208, {0xFF}));
  node_.on_frame(frame_of(0x208, {0xFF, 0x0F, 0xFF}));
  node_.on_frame(frame_of(0x208, {}));
  tick(node_, 5);
  EXPECT_EQ(board_.output_bits, 0);
  EXPECT_EQ(node_.stack().counters().wrong_length, 3U);
  node_.on_frame(frame_of(0x208, {0xFF, 0x10}));  // no such alarm
  tick(node_, 5);
  EXPECT_EQ(board_.output_bits, 0);
}

// ----- alarm signals (IEC 60601-1-8; SOURCES 2.5) -----

struct Edge {
  int at_ms;
  bool on;
  bool operator==(const Edge&) const = default;
};
std::ostream& operator<<(std::ostream& out, const Edge& edge) { return out << edge.at_ms << (edge.on ? " on" : " off"); }

class AlarmTest : public IoTest {
 protected:
  // Tells the node this alarm for so long, as the computer does, and notes when these outputs change.
  std::vector<Edge> play(int byte, int milliseconds, unsigned outputs) {
    std::vector<Edge> edges;
    bool on = false;
    for (int ms = 0; ms < milliseconds; ++ms) {
      if (ms % 50 == 0) node_.on_frame(frame_of(0x208, {0, byte}));
      tick(node_, 1);
      const bool now = (board_.output_bits & outputs) != 0;
      if (now != on) edges.push_back({ms, now});
      on = now;
    }
    return edges;
  }
  // The outputs that were on at any time meanwhile.
  unsigned seen_for(int milliseconds) {
    unsigned seen = 0;
    for (int ms = 0; ms < milliseconds; ++ms) {
      tick(node_, 1);
      seen |= board_.output_bits;
    }
    return seen;
  }
};
constexpr int kHighBoth = 0x0F, kMediumBoth = 0x0A, kLowBoth = 0x05, kHighLight = 0x0C;

TEST_F(AlarmTest, HighIsTenPulsesInTwoGroupsOfThreeAndTwo) {
  // Pulses of 120 ms, 80 ms apart, 280 after the third, 600 between the groups, 3.5 s between the bursts.
  std::vector<Edge> expected;
  int at = 0;
  for (const int gap : {80, 80, 280, 80, 600, 80, 80, 280, 80, 3500, 80}) {
    expected.push_back({at, true});
    expected.push_back({at + 120, false});
    at += 120 + gap;
  }
  EXPECT_EQ(play(kHighBoth, at, canopen::kBuzzer), expected);
}

TEST_F(AlarmTest, MediumIsThreePulsesAndLowIsOne) {
  const std::vector<Edge> medium{{0, true},   {180, false}, {360, true},  {540, false},
                                 {720, true}, {900, false}, {7900, true}, {8080, false}};
  EXPECT_EQ(play(kMediumBoth, 8200, canopen::kBuzzer), medium);
  const std::vector<Edge> low{{0, true}, {180, false}, {16180, true}, {16360, false}};
  EXPECT_EQ(play(kLowBoth, 16500, canopen::kBuzzer), low);
}

TEST_F(AlarmTest, TheLightsFlashByPriority) {
  const std::vector<Edge> red{{0, true}, {250, false}, {500, true}, {750, false}, {1000, true}};
  EXPECT_EQ(play(kHighBoth, 1200, canopen::kRedLight), red);
  const std::vector<Edge> yellow{{0, true}, {1000, false}, {2000, true}, {3000, false}};
  EXPECT_EQ(play(kMediumBoth, 3500, canopen::kYellowLight), yellow);
  EXPECT_EQ(play(kLowBoth, 3500, canopen::kCyanLight), (std::vector<Edge>{{0, true}})) << "steady";
  for (const auto& [byte, light] :
       {std::pair{kHighBoth, canopen::kRedLight}, {kMediumBoth, canopen::kYellowLight}, {kLowBoth, canopen::kCyanLight}})
    EXPECT_TRUE(play(byte, 2500, kLights & ~static_cast<unsigned>(light)).size() <= 1) << "one light alone, once the other is off";
}

TEST_F(AlarmTest, APausedAlarmIsSilentAndLit) {
  EXPECT_FALSE(play(kHighLight, 1000, canopen::kRedLight).empty());
  EXPECT_TRUE(play(kHighLight, 9000, canopen::kBuzzer).empty());
  const std::vector<Edge> after = play(kHighBoth, 300, canopen::kBuzzer);
  ASSERT_FALSE(after.empty());
  EXPECT_EQ(after.front(), (Edge{0, true})) << "sounds from its beginning";
}

TEST_F(AlarmTest, NoAlarmNothing) {
  EXPECT_TRUE(play(0, 20000, canopen::kBuzzer | kLights).empty());
  play(kHighBoth, 60, canopen::kBuzzer);
  EXPECT_TRUE(play(0, 5000, canopen::kBuzzer | kLights).empty()) << "it ends at once";
}

// H23: a control computer that is gone is heard, however it goes.
TEST_F(AlarmTest, H23_ALostComputerIsHeardUntilItSpeaksAgain) {
  play(0, 1000, canopen::kBuzzer);
  tick(node_, 120);
  int sounding = 0, lit = 0;
  for (int ms = 0; ms < 60'000; ++ms) {
    tick(node_, 1);
    sounding += (board_.output_bits & canopen::kBuzzer) != 0 ? 1 : 0;
    lit += (board_.output_bits & canopen::kRedLight) != 0 ? 1 : 0;
  }
  EXPECT_NEAR(sounding, 60'000 * 1200 / 6340, 1200) << "ten pulses of 120 ms in each 6.34 s";
  EXPECT_NEAR(lit, 30'000, 250);
  EXPECT_TRUE(play(0, 5000, canopen::kBuzzer | kLights).empty());
}

TEST_F(AlarmTest, H23_ALostHeartbeatIsHeardAlsoOutsideOfOperation) {
  node_.on_frame(canopen::heartbeat(0x7F, NmtState::operational));
  play(kMediumBoth, 200, canopen::kBuzzer);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::pre_operational, 0));
  tick(node_, 20);
  EXPECT_EQ(board_.output_bits, 0) << "taken out of operation by the computer: nothing is known any more";
  tick(node_, 250);
  EXPECT_NE(board_.output_bits & kLights, 0);
  EXPECT_EQ(seen_for(7000), unsigned{canopen::kBuzzer | canopen::kRedLight});
  // A computer that starts sets the state of the node and falls silent again: only its word about the alarm ends this one.
  for (const canopen::NmtCommand next : {canopen::NmtCommand::stop, canopen::NmtCommand::pre_operational, canopen::NmtCommand::start}) {
    node_.on_frame(canopen::nmt(next, 0));
    EXPECT_EQ(seen_for(7000), unsigned{canopen::kBuzzer | canopen::kRedLight}) << "after NMT command " << static_cast<int>(next);
  }
  EXPECT_TRUE(play(0, 5000, canopen::kBuzzer | kLights).empty()) << "its word";
}

TEST_F(AlarmTest, AComputerThatHasNeverSpokenIsNotMissed) {
  node_.on_frame(canopen::heartbeat(0x7F, NmtState::operational));  // there, but it has told nothing yet
  EXPECT_EQ(seen_for(10'000), 0U);
  node_.on_frame(canopen::nmt(canopen::NmtCommand::start, 0));  // its lost heartbeat had ended operation
  play(kHighBoth, 100, canopen::kBuzzer);
  EXPECT_NE(seen_for(1000), 0U) << "lost";
  node_.on_frame(canopen::nmt(canopen::NmtCommand::reset_node, 0));
  EXPECT_EQ(seen_for(10'000), 0U) << "a reset forgets: so a service tool silences it";
}

TEST_F(AlarmTest, ABurstThatWasBrokenOffBeginsAnew) {
  play(kHighBoth, 500, canopen::kBuzzer);  // in its third pulse
  play(0, 50, canopen::kBuzzer);
  const std::vector<Edge> edges = play(kHighBoth, 900, canopen::kBuzzer);
  const std::vector<Edge> expected{{0, true}, {120, false}, {200, true}, {320, false}, {400, true}, {520, false}, {800, true}};
  EXPECT_EQ(edges, expected);
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
