// WebSocket frames: what must be read, what must be refused with which code, whatever the portions.
#include <gtest/gtest.h>

#include <random>

#include "server/ws/frame.hpp"

namespace hoist::server {
namespace {

std::string masked(unsigned first, std::string_view payload, bool long_form = false) {
  std::string frame;
  frame.push_back(static_cast<char>(first));
  if (payload.size() < 126 && !long_form) {
    frame.push_back(static_cast<char>(0x80U | payload.size()));
  } else {
    frame.push_back(static_cast<char>(0x80U | 126U));
    frame.push_back(static_cast<char>(payload.size() >> 8));
    frame.push_back(static_cast<char>(payload.size() & 0xFF));
  }
  const std::string key = "\x11\x22\x33\x44";
  frame += key;
  for (std::size_t i = 0; i < payload.size(); ++i) frame.push_back(static_cast<char>(payload[i] ^ key[i % 4]));
  return frame;
}

TEST(Frame, WholeMessages) {
  FrameReader reader;
  std::vector<Incoming> out;
  ASSERT_TRUE(reader.feed(masked(0x81, "hello") + masked(0x89, "p") + masked(0x8A, "") +
                              masked(0x88,
                                     "\x03\xe8"
                                     "bye"),
                          out));
  ASSERT_EQ(out.size(), 4U);
  EXPECT_EQ(out[0].payload, "hello");
  EXPECT_EQ(out[1].kind, Incoming::Kind::ping);
  EXPECT_EQ(out[2].kind, Incoming::Kind::pong);
  EXPECT_EQ(out[3].kind, Incoming::Kind::close);
}

TEST(Frame, BinaryOnlyWhereTheProtocolHasIt) {
  const std::string not_utf8 = "\x01\xff\xfe";
  std::vector<Incoming> out;
  FrameReader text_only;
  EXPECT_FALSE(text_only.feed(masked(0x82, not_utf8), out));
  EXPECT_EQ(text_only.error(), CloseCode::not_text);
  FrameReader reader(true);
  ASSERT_TRUE(reader.feed(masked(0x02, not_utf8) + masked(0x80, not_utf8) + masked(0x81, "text"), out));
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].kind, Incoming::Kind::binary);
  EXPECT_EQ(out[0].payload, not_utf8 + not_utf8);
  EXPECT_EQ(out[1].kind, Incoming::Kind::text);
  // A text stays bound to UTF-8, also after a binary message; a message is one or the other.
  EXPECT_FALSE(reader.feed(masked(0x81, not_utf8), out));
  EXPECT_EQ(reader.error(), CloseCode::bad_utf8);
  FrameReader mixed(true);
  EXPECT_FALSE(mixed.feed(masked(0x02, "a") + masked(0x82, "b"), out));
}

TEST(Frame, SameResultForAnyPortions) {
  std::string stream = masked(0x01, "one ") + masked(0x89, "in between") + masked(0x00, "message ") + masked(0x80, "in parts") +
                       masked(0x81, std::string(4096, 'x')) + masked(0x81, "");
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    FrameReader reader;
    std::vector<Incoming> out;
    for (std::size_t at = 0; at < stream.size();) {
      const std::size_t part = std::min<std::size_t>(stream.size() - at, 1 + random() % (round == 0 ? 1 : 700));
      ASSERT_TRUE(reader.feed(std::string_view(stream).substr(at, part), out));
      at += part;
    }
    ASSERT_EQ(out.size(), 4U);
    EXPECT_EQ(out[0].payload, "in between");
    EXPECT_EQ(out[1].payload, "one message in parts");
    EXPECT_EQ(out[2].payload.size(), 4096U);
    EXPECT_EQ(out[3].payload, "");
  }
}

struct Violation {
  const char* what;
  std::string bytes;
  CloseCode code;
};
TEST(Frame, Violations) {
  std::string unmasked = "\x81\x01x";
  const std::vector<Violation> all{
      {"not masked", unmasked, CloseCode::protocol},
      {"reserved bit 1", masked(0xC1, "x"), CloseCode::protocol},
      {"reserved bit 3", masked(0x91, "x"), CloseCode::protocol},
      {"reserved opcode 3", masked(0x83, "x"), CloseCode::protocol},
      {"reserved opcode 11", masked(0x8B, "x"), CloseCode::protocol},
      {"binary", masked(0x82, "x"), CloseCode::not_text},
      {"fragmented ping", masked(0x09, "x"), CloseCode::protocol},
      {"ping of 126", masked(0x89, std::string(126, 'x')), CloseCode::protocol},
      {"continuation of nothing", masked(0x80, "x"), CloseCode::protocol},
      {"text inside a message", masked(0x01, "x") + masked(0x81, "y"), CloseCode::protocol},
      {"not the shortest length", masked(0x81, "x", true), CloseCode::protocol},
      {"4097 bytes", masked(0x81, std::string(4097, 'x')), CloseCode::too_big},
      {"4097 bytes in parts", masked(0x01, std::string(4000, 'x')) + masked(0x80, std::string(97, 'x')), CloseCode::too_big},
      {"bad UTF-8", masked(0x81, "\xc3\x28"), CloseCode::bad_utf8},
      {"surrogate", masked(0x81, "\xed\xa0\x80"), CloseCode::bad_utf8},
      {"overlong", masked(0x81, "\xc0\xaf"), CloseCode::bad_utf8},
      {"cut short", masked(0x81, "\xe2\x82"), CloseCode::bad_utf8},
      {"close of one byte", masked(0x88, "\x03"), CloseCode::protocol},
      {"close 1005", masked(0x88, "\x03\xed"), CloseCode::protocol},
      {"close 999", masked(0x88, "\x03\xe7"), CloseCode::protocol},
      {"close 5000", masked(0x88, "\x13\x88"), CloseCode::protocol},
      {"close with bad UTF-8", masked(0x88, "\x03\xe8\xff"), CloseCode::bad_utf8}};
  for (const Violation& v : all) {
    FrameReader reader;
    std::vector<Incoming> out;
    EXPECT_FALSE(reader.feed(v.bytes, out)) << v.what;
    EXPECT_EQ(reader.error(), v.code) << v.what;
    EXPECT_FALSE(reader.feed(masked(0x81, "more"), out)) << "after " << v.what << " nothing is read";
  }
}

TEST(Frame, HugeLengthIsRefusedBeforeItsBytes) {
  FrameReader reader;
  std::vector<Incoming> out;
  EXPECT_FALSE(reader.feed(std::string("\x81\xff\x00\x00\x00\x7f\xff\xff\xff\xff\x11\x22\x33\x44", 14), out));
  EXPECT_EQ(reader.error(), CloseCode::too_big);
}

TEST(Frame, BuiltFramesHaveTheRightLength) {
  EXPECT_EQ(make_frame(Opcode::text, std::string(125, 'x'))->size(), 127U);
  EXPECT_EQ(make_frame(Opcode::text, std::string(126, 'x'))->size(), 130U);
  EXPECT_EQ(make_frame(Opcode::binary, std::string(65536, 'x'))->size(), 65546U);
  EXPECT_EQ(*make_close_frame(CloseCode::policy, "no"), std::string("\x88\x04\x03\xf0no"));
}

TEST(Frame, RandomBytesNeverCrash) {
  std::mt19937 random(11);
  for (int round = 0; round < 3000; ++round) {
    FrameReader reader;
    std::vector<Incoming> out;
    std::string bytes(random() % 300, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    if (!bytes.empty()) bytes[0] = static_cast<char>(0x80U | (random() % 11));
    if (reader.feed(bytes, out)) {
      for (const Incoming& message : out) EXPECT_LE(message.payload.size(), kMessageLimit_bytes);
    }
  }
}

}  // namespace
}  // namespace hoist::server
