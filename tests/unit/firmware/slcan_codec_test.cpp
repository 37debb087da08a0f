#include "control/contract/slcan_codec.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace hoist::contract {
namespace {

struct Seen {
  SlcanKind kind;
  CanFrame frame;
  int stamp_ms;
  std::string text;
  friend bool operator==(const Seen&, const Seen&) = default;
};

std::vector<Seen> decode(const std::vector<std::string>& pieces, SlcanCounters* counters = nullptr) {
  std::vector<Seen> seen;
  SlcanDecoder decoder;
  for (const std::string& piece : pieces)
    decoder.feed(std::span<const char>(piece), [&](const SlcanLine& line) {
      seen.push_back({line.kind, line.frame, line.stamp_ms ? *line.stamp_ms : -1, std::string(line.text)});
    });
  if (counters) *counters = decoder.counters();
  return seen;
}
SlcanLine parse(const std::string& text) { return slcan_parse(text); }

std::string encode(const CanFrame& frame, std::optional<std::uint16_t> stamp = std::nullopt) {
  char out[40];
  return std::string(out, slcan_encode(frame, out, stamp));
}

TEST(SlcanEncode, WritesTheLinesOfTheProtocol) {
  EXPECT_EQ(encode(CanFrame{0x80, 0, 0, {}}), "t0800\r");
  EXPECT_EQ(encode(CanFrame{0x201, 6, 0, {0x0F, 0, 0xA0, 0x86, 1, 0}}), "t20160F00A0860100\r");
  EXPECT_EQ(encode(CanFrame{0x1ABCDEF, 2, CanFrame::kExtended, {0x12, 0xFE}}), "T01ABCDEF212FE\r");
  EXPECT_EQ(encode(CanFrame{0x123, 4, CanFrame::kRemote, {}}), "r1234\r");
  EXPECT_EQ(encode(CanFrame{0x123, 1, 0, {0xAB}}, 59999), "t1231ABEA5F\r");
}

TEST(SlcanEncode, RefusesWhatCannotBeOnABus) {
  EXPECT_EQ(encode(CanFrame{0x800, 0, 0, {}}), "");
  EXPECT_EQ(encode(CanFrame{0x20000000, 0, CanFrame::kExtended, {}}), "");
  EXPECT_EQ(encode(CanFrame{0x10, 9, 0, {}}), "");
  EXPECT_EQ(encode(CanFrame{0x10, 0, CanFrame::kError, {}}), "");
  EXPECT_EQ(encode(CanFrame{0x10, 0, 0, {}}, 60000), "");
  char small[8];
  EXPECT_EQ(slcan_encode(CanFrame{0x123, 2, 0, {1, 2}}, small), 0U);  // needs ten
}

TEST(SlcanDecode, ReadsBackEveryFrameThatItWrites) {
  std::mt19937 random(7);
  for (int i = 0; i < 5000; ++i) {
    CanFrame frame;
    frame.flags = static_cast<std::uint8_t>(random() & 3U);
    frame.id = random() & ((frame.flags & CanFrame::kExtended) != 0 ? 0x1FFFFFFFU : 0x7FFU);
    frame.dlc = static_cast<std::uint8_t>(random() % 9U);
    if ((frame.flags & CanFrame::kRemote) == 0)
      for (std::size_t b = 0; b < frame.dlc; ++b) frame.data[b] = static_cast<std::uint8_t>(random());
    const bool stamped = (random() & 1U) != 0;
    const std::uint16_t stamp = static_cast<std::uint16_t>(random() % 60000U);
    const std::string line = stamped ? encode(frame, stamp) : encode(frame);
    const auto seen = decode({line});
    ASSERT_EQ(seen.size(), 1U) << line;
    EXPECT_EQ(seen[0].kind, SlcanKind::frame) << line;
    EXPECT_EQ(seen[0].frame, frame) << line;
    EXPECT_EQ(seen[0].stamp_ms, stamped ? stamp : -1) << line;
  }
}

TEST(SlcanDecode, RefusesEveryLengthButTheRightOne) {
  // The short line that the kernel's driver completes with old bytes.
  EXPECT_EQ(parse("t123412").kind, SlcanKind::refused);
  const std::string whole =
      "t1238"
      "1122334455667788"
      "0001";
  for (std::size_t length = 1; length <= whole.size(); ++length) {
    const bool right = length == 5 + 16 || length == 5 + 16 + 4;
    EXPECT_EQ(parse(whole.substr(0, length)).kind, right ? SlcanKind::frame : SlcanKind::refused) << length;
  }
  EXPECT_EQ(parse(whole + "0").kind, SlcanKind::refused);
  EXPECT_EQ(parse("r12300001").kind, SlcanKind::frame);  // a stamp
  EXPECT_EQ(parse("r123000").kind, SlcanKind::refused);
}

TEST(SlcanDecode, RefusesWhatIsNoFrame) {
  for (const char* line : {"t",
                           "t12",
                           "t123",
                           "t1239",
                           "t123A",
                           "t12G0",
                           "t1231G1",
                           "t12311",
                           "t8000",
                           "tFFF0",
                           "t123 0",
                           "T1234567",
                           "T200000000",
                           "TFFFFFFFF0",
                           "t-120",
                           "t1231 1",
                           "t1230EA60",
                           "t1230FFFF",
                           "t12300x01",
                           "r1239",
                           "sa00012",
                           "t1231\x01"
                           "2"})
    EXPECT_NE(parse(line).kind, SlcanKind::frame) << line;
  EXPECT_EQ(parse("t7FF0").kind, SlcanKind::frame);
  EXPECT_EQ(parse("T1FFFFFFF0").kind, SlcanKind::frame);
  EXPECT_EQ(parse("t1230EA5F").kind, SlcanKind::frame);
  EXPECT_EQ(parse("t1231af").frame.data[0], 0xAF);  // small letters are hexadecimal too
  EXPECT_EQ(parse("\n").kind, SlcanKind::refused);
  EXPECT_EQ(parse(std::string("O\0", 2)).kind, SlcanKind::refused);
  EXPECT_EQ(parse("\x80").kind, SlcanKind::refused);
}

TEST(SlcanDecode, TellsAnswersFromFrames) {
  const auto seen = decode({"\rz\rZ\r\aV1010\rsb256007\re1a\rs0011C\r"});
  std::vector<SlcanKind> kinds;
  for (const Seen& s : seen) kinds.push_back(s.kind);
  EXPECT_EQ(kinds, (std::vector{SlcanKind::ack, SlcanKind::ack, SlcanKind::ack, SlcanKind::bel, SlcanKind::command, SlcanKind::state,
                                SlcanKind::error, SlcanKind::command}));
  const SlcanLine state = parse("sp128007");
  EXPECT_EQ(state.state, 'p');
  EXPECT_EQ(state.rx_errors, 128);
  EXPECT_EQ(state.tx_errors, 7);
  EXPECT_EQ(parse("sp12800x").kind, SlcanKind::refused);
}

TEST(SlcanDecode, BellEndsALineThatItCutsOff) {
  SlcanCounters counters;
  const auto seen = decode({"t1231\at1230\r"}, &counters);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].kind, SlcanKind::refused);
  EXPECT_EQ(seen[1].kind, SlcanKind::bel);
  EXPECT_EQ(seen[2].kind, SlcanKind::frame);
  // A complete frame without its CR is refused too.
  EXPECT_EQ(decode({"t1230\a"})[0].kind, SlcanKind::refused);
  EXPECT_EQ(counters.bells, 1U);
}

TEST(SlcanDecode, DropsAnOverlongLineWholeAndGoesOn) {
  SlcanCounters counters;
  const std::string frame = "t12380102030405060708";
  const auto seen = decode({std::string(33, '0') + "\r" + frame + frame + "\r" + frame + "\r"}, &counters);
  ASSERT_EQ(seen.size(), 3U);
  EXPECT_EQ(seen[0].kind, SlcanKind::refused);
  EXPECT_EQ(seen[1].kind, SlcanKind::refused);
  EXPECT_EQ(seen[2].kind, SlcanKind::frame);
  EXPECT_EQ(counters.overlong_lines, 2U);
  EXPECT_EQ(counters.refused_lines, 0U);
  EXPECT_EQ(counters.frames, 1U);
}

TEST(SlcanDecode, TheCutOfTheStreamDoesNotMatter) {
  const std::string stream =
      "\rC\rS5\rO\rt20160F00A0860100\rz\r\at1231\rT01ABCDEF212FEEA5F\rsb256007\r" + std::string(40, 'x') + "\rt0800\r\a\a";
  const auto whole = decode({stream});
  ASSERT_GT(whole.size(), 10U);
  for (std::size_t first = 0; first <= stream.size(); ++first)
    for (std::size_t second = first; second <= stream.size(); second += 7)
      ASSERT_EQ(decode({stream.substr(0, first), stream.substr(first, second - first), stream.substr(second)}), whole)
          << first << ' ' << second;
  std::vector<std::string> single;
  for (const char c : stream) single.push_back(std::string(1, c));
  EXPECT_EQ(decode(single), whole);
}

TEST(SlcanDecode, RandomBytesNeverGiveAnImpossibleFrame) {
  std::mt19937 random(11);
  static constexpr char kLikely[] = "tTrRzZsSeOC0123456789ABCDEFabcdef\r\r\a";
  SlcanDecoder decoder;
  std::uint64_t frames = 0, lines = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string piece;
    if (random() % 4U == 0) piece += "\rt20160F00A0860100\r";  // something to tear apart
    for (std::size_t n = random() % 40U; n > 0; --n)
      piece += (random() % 8U) == 0 ? static_cast<char>(random()) : kLikely[random() % (sizeof kLikely - 1)];
    if (!piece.empty() && random() % 2U == 0) piece.erase(random() % piece.size(), 1);
    decoder.feed(std::span<const char>(piece), [&](const SlcanLine& line) {
      ++lines;
      ASSERT_LE(line.text.size(), kSlcanLineMax);
      if (line.kind != SlcanKind::frame) return;
      ++frames;
      ASSERT_LE(line.frame.dlc, 8);
      ASSERT_LE(line.frame.id, (line.frame.flags & CanFrame::kExtended) != 0 ? 0x1FFFFFFFU : 0x7FFU);
      // What was accepted says the same when written again.
      ASSERT_EQ(slcan_parse(encode(line.frame).substr(0, encode(line.frame).size() - 1)).frame, line.frame);
    });
  }
  EXPECT_GT(lines, 1000U);
  EXPECT_GT(frames, 0U);
  EXPECT_EQ(decoder.counters().frames, frames);
}

}  // namespace
}  // namespace hoist::contract
