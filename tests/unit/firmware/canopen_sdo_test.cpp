// The SDO server alone, against a small dictionary that records its calls: a value, a text and a domain. Frames are written out byte by
// byte (CiA 301, 7.2.4.3).
#include "firmware/lib/sdo_server.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {
namespace {

constexpr std::uint32_t kAsk = 0x611, kAnswer = 0x591;
constexpr std::uint16_t kValue = 0x2000, kText = 0x1008, kDomain = 0x1F50;
constexpr std::size_t kDomainMax = 100;

struct SmallDictionary {
  std::uint32_t value = 0x11223344;
  int writes = 0;
  std::string text = "an engineer's name";  // 18 bytes: two full segments and one of four
  std::vector<std::uint8_t> domain;
  std::uint32_t told = 0;
  int begun = 0, ended = 0, cancelled = 0;
  SdoAbort refuse_begin = SdoAbort::none, refuse_end = SdoAbort::none;

  SdoAbort sdo_read(std::uint16_t index, std::uint8_t sub, SdoSource& source) {
    if (sub != 0) return SdoAbort::no_sub;
    if (index == kText) {
      source.text = text;
      return SdoAbort::none;
    }
    if (index != kValue) return index == kDomain ? SdoAbort::write_only : SdoAbort::no_object;
    source.raw = value;
    source.raw_bytes = 4;
    return SdoAbort::none;
  }
  SdoAbort sdo_target(std::uint16_t index, std::uint8_t, SdoTarget& target) {
    if (index == kText) return SdoAbort::read_only;
    if (index == kDomain) return SdoAbort::none;
    if (index != kValue) return SdoAbort::no_object;
    target.bytes = 4;
    return SdoAbort::none;
  }
  SdoAbort sdo_write(std::uint16_t, std::uint8_t, std::uint32_t raw) {
    if (raw == 0xBAD) return SdoAbort::range;
    value = raw;
    ++writes;
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_begin(std::uint16_t, std::uint8_t, std::uint32_t bytes) {
    if (refuse_begin != SdoAbort::none) return refuse_begin;
    ++begun;
    told = bytes;
    domain.clear();
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_data(std::span<const std::uint8_t> bytes) {
    if (domain.size() + bytes.size() > kDomainMax) return SdoAbort::too_long;
    domain.insert(domain.end(), bytes.begin(), bytes.end());
    return SdoAbort::none;
  }
  SdoAbort sdo_domain_end() {
    if (refuse_end == SdoAbort::none) ++ended;
    return refuse_end;
  }
  void sdo_domain_cancel() { ++cancelled; }
};

class Sdo : public ::testing::Test {
 protected:
  // The one answer; an id that does not exist when there was none.
  CanFrame ask(const CanFrame& request) {
    server_.on_request(request, dictionary_);
    if (!server_.answer_waiting()) return CanFrame{0xFFFF, 0, 0, {}};
    server_.answer_sent();
    return server_.answer();
  }
  CanFrame ask(std::initializer_list<int> bytes) { return ask(frame_of(kAsk, bytes)); }
  static CanFrame aborted(std::uint16_t index, std::uint8_t sub, std::uint32_t code) {
    return canopen::sdo(kAnswer, 0x80, index, sub, code);
  }
  void silence(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) server_.tick_1ms(dictionary_);
  }
  SmallDictionary dictionary_;
  SdoServer server_{0x11};
};

TEST_F(Sdo, ALongTextComesInSegments) {
  EXPECT_EQ(ask({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x41, 0x08, 0x10, 0, 18, 0, 0, 0}));
  EXPECT_TRUE(server_.transfer_open());
  EXPECT_EQ(ask({0x60, 0, 0, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x00, 'a', 'n', ' ', 'e', 'n', 'g', 'i'}));
  EXPECT_EQ(ask({0x70, 0, 0, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x10, 'n', 'e', 'e', 'r', '\'', 's', ' '}));
  EXPECT_EQ(ask({0x60, 0, 0, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x07, 'n', 'a', 'm', 'e', 0, 0, 0}));
  EXPECT_FALSE(server_.transfer_open());
  EXPECT_EQ(ask({0x70, 0, 0, 0, 0, 0, 0, 0}), aborted(0, 0, 0x05040001));  // no more data
}

TEST_F(Sdo, TextsOfEveryLengthArriveWhole) {
  for (std::size_t length = 0; length <= 30; ++length) {
    dictionary_.text.assign(length, 'x');
    EXPECT_EQ(contract::read_le(&ask({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}).data[4], 4), length);
    std::size_t got = 0;
    int segments = 0;
    for (bool toggle = false, last = false; !last; toggle = !toggle) {
      const CanFrame answer = ask({toggle ? 0x70 : 0x60, 0, 0, 0, 0, 0, 0, 0});
      ASSERT_EQ(answer.data[0] & 0xF0, toggle ? 0x10 : 0x00);
      got += 7U - ((answer.data[0] >> 1) & 7U);
      last = (answer.data[0] & 1U) != 0;
      ASSERT_LE(++segments, 5);
    }
    EXPECT_EQ(got, length);
  }
}

TEST_F(Sdo, AValueMayComeInSegments) {
  EXPECT_EQ(ask({0x21, 0x00, 0x20, 0, 4, 0, 0, 0}), frame_of(kAnswer, {0x60, 0x00, 0x20, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask({0x0A, 0xAA, 0xBB, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x20, 0, 0, 0, 0, 0, 0, 0}));  // two bytes, more to come
  EXPECT_EQ(dictionary_.writes, 0);
  EXPECT_EQ(ask({0x1B, 0xCC, 0xDD, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x30, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(dictionary_.value, 0xDDCCBBAAU);
  EXPECT_EQ(dictionary_.writes, 1);
  // The same without a length.
  EXPECT_EQ(ask({0x20, 0x00, 0x20, 0, 0, 0, 0, 0}).data[0], 0x60);
  EXPECT_EQ(ask({0x07, 1, 2, 3, 4, 0, 0, 0}).data[0], 0x20);
  EXPECT_EQ(dictionary_.value, 0x04030201U);
}

TEST_F(Sdo, WrongLengthsAreRefusedAndStoreNothing) {
  EXPECT_EQ(ask({0x21, 0x00, 0x20, 0, 5, 0, 0, 0}), aborted(kValue, 0, 0x06070012));
  EXPECT_EQ(ask({0x21, 0x00, 0x20, 0, 3, 0, 0, 0}), aborted(kValue, 0, 0x06070013));
  EXPECT_EQ(ask({0x2B, 0x00, 0x20, 0, 1, 2, 0, 0}), aborted(kValue, 0, 0x06070013));
  ask({0x20, 0x00, 0x20, 0, 0, 0, 0, 0});
  EXPECT_EQ(ask({0x05, 1, 2, 3, 4, 5, 0, 0}), aborted(kValue, 0, 0x06070012));
  ask({0x20, 0x00, 0x20, 0, 0, 0, 0, 0});
  EXPECT_EQ(ask({0x09, 1, 2, 3, 0, 0, 0, 0}), aborted(kValue, 0, 0x06070013));
  // A domain that is shorter or longer than announced.
  ask({0x21, 0x50, 0x1F, 1, 8, 0, 0, 0});
  ask({0x00, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(ask({0x1A, 1, 2, 0, 0, 0, 0, 0}), aborted(kDomain, 1, 0x06070012));
  ask({0x21, 0x50, 0x1F, 1, 8, 0, 0, 0});
  EXPECT_EQ(ask({0x01, 1, 2, 3, 4, 5, 6, 7}), aborted(kDomain, 1, 0x06070013));
  EXPECT_EQ(dictionary_.writes, 0);
  EXPECT_EQ(dictionary_.ended, 0);
  EXPECT_EQ(dictionary_.cancelled, 2);
  EXPECT_FALSE(server_.transfer_open());
}

TEST_F(Sdo, AValueOutOfRangeIsRefusedAtItsEnd) {
  ask({0x21, 0x00, 0x20, 0, 4, 0, 0, 0});
  EXPECT_EQ(ask({0x07, 0xAD, 0x0B, 0, 0, 0, 0, 0}), aborted(kValue, 0, 0x06090030));
  EXPECT_EQ(dictionary_.value, 0x11223344U);
  EXPECT_EQ(server_.aborts(), 1U);
}

TEST_F(Sdo, ADomainIsPassedOnAsItComes) {
  std::vector<std::uint8_t> program(kDomainMax);
  for (std::size_t i = 0; i < program.size(); ++i) program[i] = static_cast<std::uint8_t>(3 * i);
  EXPECT_EQ(ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0}).data[0], 0x60);
  EXPECT_EQ(dictionary_.told, 100U);
  bool toggle = false;
  for (std::size_t at = 0; at < program.size(); at += 7, toggle = !toggle) {
    const std::size_t bytes = std::min<std::size_t>(7, program.size() - at);
    CanFrame segment{kAsk, 8, 0, {}};
    segment.data[0] = static_cast<std::uint8_t>((toggle ? 0x10U : 0U) | ((7 - bytes) << 1) | (at + bytes == program.size() ? 1U : 0U));
    std::copy_n(program.begin() + static_cast<std::ptrdiff_t>(at), bytes, segment.data.begin() + 1);
    ASSERT_EQ(ask(segment), frame_of(kAnswer, {toggle ? 0x30 : 0x20, 0, 0, 0, 0, 0, 0, 0}));
    ASSERT_EQ(dictionary_.domain.size(), at + bytes);
  }
  EXPECT_EQ(dictionary_.domain, program);
  EXPECT_EQ(dictionary_.ended, 1);
  EXPECT_EQ(dictionary_.cancelled, 0);
  // A short one may come expedited.
  EXPECT_EQ(ask({0x27, 0x50, 0x1F, 1, 7, 8, 9, 0}).data[0], 0x60);
  EXPECT_EQ(dictionary_.domain, (std::vector<std::uint8_t>{7, 8, 9}));
  EXPECT_EQ(dictionary_.ended, 2);
}

TEST_F(Sdo, ADomainsOwnRefusalsEndTheTransfer) {
  dictionary_.refuse_begin = SdoAbort::device_state;
  EXPECT_EQ(ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0}), aborted(kDomain, 1, 0x08000022));
  EXPECT_EQ(dictionary_.cancelled, 0);  // never begun
  dictionary_.refuse_begin = SdoAbort::none;
  ask({0x20, 0x50, 0x1F, 1, 0, 0, 0, 0});  // no length given: the dictionary's own limit applies
  CanFrame answer;
  int sent = 0;
  for (bool toggle = false; sent < 100; toggle = !toggle, ++sent) {
    answer = ask({toggle ? 0x10 : 0x00, 1, 2, 3, 4, 5, 6, 7});
    if (answer.data[0] == 0x80) break;
  }
  EXPECT_EQ(sent, 14);
  EXPECT_EQ(answer, aborted(kDomain, 1, 0x06070012));
  EXPECT_EQ(dictionary_.cancelled, 1);
  dictionary_.refuse_end = SdoAbort::transfer;
  ask({0x21, 0x50, 0x1F, 1, 2, 0, 0, 0});
  EXPECT_EQ(ask({0x0B, 1, 2, 0, 0, 0, 0, 0}), aborted(kDomain, 1, 0x08000020));
  EXPECT_EQ(dictionary_.ended, 0);
  EXPECT_EQ(dictionary_.cancelled, 2);
}

TEST_F(Sdo, AWrongToggleEndsTheTransfer) {
  ask({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
  EXPECT_EQ(ask({0x70, 0, 0, 0, 0, 0, 0, 0}), aborted(kText, 0, 0x05030000));
  ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0});
  ask({0x00, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(ask({0x00, 1, 2, 3, 4, 5, 6, 7}), aborted(kDomain, 1, 0x05030000));
  EXPECT_EQ(dictionary_.cancelled, 1);
  EXPECT_FALSE(server_.transfer_open());
}

TEST_F(Sdo, AClientThatFallsSilentIsToldAndForgotten) {
  ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0});
  silence(999);
  EXPECT_FALSE(server_.answer_waiting());
  ask({0x00, 1, 2, 3, 4, 5, 6, 7});  // in time
  silence(999);
  EXPECT_FALSE(server_.answer_waiting());
  silence(1);
  ASSERT_TRUE(server_.answer_waiting());
  EXPECT_EQ(server_.answer(), aborted(kDomain, 1, 0x05040000));
  EXPECT_EQ(dictionary_.cancelled, 1);
  server_.answer_sent();
  silence(5000);
  EXPECT_FALSE(server_.answer_waiting());  // once
}

TEST_F(Sdo, TheClientsAbortIsNotAnswered) {
  ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0});
  EXPECT_EQ(ask({0x80, 0x50, 0x1F, 1, 0, 0, 4, 5}).id, 0xFFFFU);
  EXPECT_EQ(dictionary_.cancelled, 1);
  EXPECT_FALSE(server_.transfer_open());
  EXPECT_EQ(ask({0x00, 1, 2, 3, 4, 5, 6, 7}), aborted(0, 0, 0x05040001));
}

TEST_F(Sdo, ANewRequestTakesThePlaceOfTheOldTransfer) {
  ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0});
  ask({0x00, 1, 2, 3, 4, 5, 6, 7});
  EXPECT_EQ(ask({0x40, 0x00, 0x20, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x43, 0x00, 0x20, 0, 0x44, 0x33, 0x22, 0x11}));
  EXPECT_EQ(dictionary_.cancelled, 1);
  EXPECT_EQ(ask({0x10, 1, 2, 3, 4, 5, 6, 7}).data[0], 0x80);
  EXPECT_EQ(dictionary_.ended, 0);
}

TEST_F(Sdo, ASegmentOfTheOtherDirectionEndsTheTransfer) {
  ask({0x21, 0x50, 0x1F, 1, 100, 0, 0, 0});
  EXPECT_EQ(ask({0x60, 0, 0, 0, 0, 0, 0, 0}), aborted(kDomain, 1, 0x05040001));
  ask({0x40, 0x08, 0x10, 0, 0, 0, 0, 0});
  EXPECT_EQ(ask({0x00, 1, 2, 3, 4, 5, 6, 7}), aborted(kText, 0, 0x05040001));
  EXPECT_EQ(dictionary_.cancelled, 1);
}

// Arbitrary frames: one answer at most, none to an abort, every accepted begin followed by exactly one end or cancel, no more bytes than
// the dictionary allows, and afterwards a normal client is served.
TEST_F(Sdo, NoiseDoesNoHarm) {
  std::mt19937 random(20261121);
  std::uint32_t answers = 0;
  for (int i = 0; i < 200000; ++i) {
    CanFrame frame{kAsk, static_cast<std::uint8_t>(random() % 16 == 0 ? random() % 9 : 8), 0, {}};
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    // Most noise would fail at its index; use existing objects.
    if (random() % 2 == 0) contract::write_le(&frame.data[1], 2, std::array{kValue, kText, kDomain}[random() % 3]);
    if (random() % 2 == 0) frame.data[3] = 0;
    if (random() % 2 == 0)
      frame.data[0] = std::array<std::uint8_t, 10>{0x21, 0x20, 0x40, 0x60, 0x70, 0x00, 0x10, 0x0F, 0x1F, 0x23}[random() % 10];
    const bool is_abort = frame.dlc == 8 && frame.data[0] == 0x80;
    const CanFrame answer = ask(frame);
    ASSERT_EQ(answer.id == 0xFFFF, is_abort) << i;
    answers += answer.id == kAnswer ? 1U : 0U;
    ASSERT_LE(dictionary_.domain.size(), kDomainMax);
    ASSERT_EQ(dictionary_.begun, dictionary_.ended + dictionary_.cancelled +
                                     (server_.transfer_open() && dictionary_.begun > dictionary_.ended + dictionary_.cancelled ? 1 : 0));
    if (random() % 64 == 0) silence(static_cast<int>(random() % 1200));
    server_.answer_sent();
  }
  EXPECT_GT(dictionary_.ended, 100);
  EXPECT_GT(dictionary_.cancelled, 100);
  EXPECT_GT(answers, 190000U);
  EXPECT_EQ(contract::read_le(&ask({0x40, 0x08, 0x10, 0, 0, 0, 0, 0}).data[4], 4), dictionary_.text.size());
  EXPECT_EQ(ask({0x60, 0, 0, 0, 0, 0, 0, 0}), frame_of(kAnswer, {0x00, 'a', 'n', ' ', 'e', 'n', 'g', 'i'}));
}

}  // namespace
}  // namespace hoist::firmware
