// Our SDO client against our SDO server over a line that loses frames, and against servers that misbehave. Virtual time, in milliseconds.
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "control/bus/sdo_client.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::bus {
namespace {

using contract::CanFrame;
using firmware::frame_of;
using Outcome = SdoClient::Outcome;
namespace canopen = contract::canopen;

constexpr std::uint64_t kMs = 1'000'000;

// A node with a text, a value and a domain of at most 300 bytes.
struct Shelf {
  std::string text = "segmented, because it is longer than four bytes";
  std::uint32_t value = 7;
  std::vector<std::uint8_t> arriving, domain;
  int completed = 0;
  firmware::SdoServer server{5};

  SdoClient::SdoAbort sdo_read(std::uint16_t index, std::uint8_t, firmware::SdoSource& source) {
    if (index == 0x1008)
      source.text = text;
    else if (index == 0x2000)
      source.raw = value, source.raw_bytes = 4;
    else
      return SdoClient::SdoAbort::no_object;
    return SdoClient::SdoAbort::none;
  }
  SdoClient::SdoAbort sdo_target(std::uint16_t index, std::uint8_t, firmware::SdoTarget& target) {
    if (index == 0x1008) return SdoClient::SdoAbort::read_only;
    if (index == 0x2000) target.bytes = 4;
    return index == 0x2000 || index == 0x1F50 ? SdoClient::SdoAbort::none : SdoClient::SdoAbort::no_object;
  }
  SdoClient::SdoAbort sdo_write(std::uint16_t, std::uint8_t, std::uint32_t raw) {
    value = raw;
    return SdoClient::SdoAbort::none;
  }
  SdoClient::SdoAbort sdo_domain_begin(std::uint16_t, std::uint8_t, std::uint32_t) {
    arriving.clear();
    return SdoClient::SdoAbort::none;
  }
  SdoClient::SdoAbort sdo_domain_data(std::span<const std::uint8_t> bytes) {
    if (arriving.size() + bytes.size() > 300) return SdoClient::SdoAbort::too_long;
    arriving.insert(arriving.end(), bytes.begin(), bytes.end());
    return SdoClient::SdoAbort::none;
  }
  SdoClient::SdoAbort sdo_domain_end() {
    domain = arriving;
    ++completed;
    return SdoClient::SdoAbort::none;
  }
  void sdo_domain_cancel() { arriving.clear(); }
};

// Client and server, one step per millisecond; an answer takes one.
struct Line {
  SdoClient client;
  Shelf shelf;
  std::uint64_t now_ns = 0;
  std::vector<CanFrame> asked;
  std::vector<std::uint64_t> asked_ns;
  std::function<bool(const CanFrame&)> loses = [](const CanFrame&) { return false; };

  void step() {
    now_ns += kMs;
    shelf.server.tick_1ms(shelf);
    if (shelf.server.answer_waiting()) {
      const CanFrame answer = shelf.server.answer();
      shelf.server.answer_sent();
      if (!loses(answer)) client.on_frame(answer);
    }
    if (const auto frame = client.step(now_ns)) {
      asked.push_back(*frame);
      asked_ns.push_back(now_ns);
      if (!loses(*frame)) shelf.server.on_request(*frame, shelf);
    }
  }
  Outcome run(int steps_max = 10000) {
    for (int i = 0; i < steps_max && client.outcome() == Outcome::busy; ++i) step();
    return client.outcome();
  }
  std::string text() const { return {client.uploaded().begin(), client.uploaded().end()}; }
};

TEST(SdoClient, UploadsAndDownloadsBothWays) {
  Line line;
  ASSERT_TRUE(line.client.upload(5, 0x2000, 0));
  EXPECT_EQ(line.run(), Outcome::done);
  EXPECT_EQ(line.client.value(), 7U);
  EXPECT_EQ(line.asked[0], frame_of(0x605, {0x40, 0x00, 0x20, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(line.client.upload(5, 0x1008, 0));
  EXPECT_EQ(line.run(), Outcome::done);
  EXPECT_EQ(line.text(), line.shelf.text);
  const std::array<std::uint8_t, 4> bytes = {1, 2, 3, 4};
  ASSERT_TRUE(line.client.download(5, 0x2000, 0, bytes));
  EXPECT_EQ(line.run(), Outcome::done);
  EXPECT_EQ(line.shelf.value, 0x04030201U);
  line.shelf.value = 0;
  ASSERT_TRUE(line.client.download(5, 0x2000, 0, bytes, true));
  EXPECT_EQ(line.run(), Outcome::done);
  EXPECT_EQ(line.shelf.value, 0x04030201U);
  for (std::size_t size = 5; size <= 300; size += 5) {
    std::vector<std::uint8_t> program(size, static_cast<std::uint8_t>(size));
    ASSERT_TRUE(line.client.download(5, 0x1F50, 1, program));
    ASSERT_EQ(line.run(), Outcome::done);
    ASSERT_EQ(line.shelf.domain, program);
    ASSERT_EQ(line.client.confirmed(), size);
  }
}

TEST(SdoClient, NeverAsksFasterThanItsPace) {
  Line line;
  std::vector<std::uint8_t> program(200);
  ASSERT_TRUE(line.client.download(5, 0x1F50, 1, program));
  EXPECT_EQ(line.run(), Outcome::done);
  ASSERT_GT(line.asked_ns.size(), 20U);
  for (std::size_t i = 1; i < line.asked_ns.size(); ++i) ASSERT_GE(line.asked_ns[i] - line.asked_ns[i - 1], 4'300'000U);
  // Also from one transfer to the next.
  const std::uint64_t last_ns = line.asked_ns.back();
  ASSERT_TRUE(line.client.upload(5, 0x2000, 0));
  EXPECT_EQ(line.run(), Outcome::done);
  EXPECT_GE(line.asked_ns.back() - last_ns, 4'300'000U);
}

TEST(SdoClient, TellsWhyTheNodeRefused) {
  Line line;
  ASSERT_TRUE(line.client.upload(5, 0x3000, 0));
  EXPECT_EQ(line.run(), Outcome::aborted);
  EXPECT_EQ(line.client.abort_code(), 0x06020000U);
  EXPECT_STREQ(sdo_abort_text(line.client.abort_code()), "there is no such object");
  const std::vector<std::uint8_t> long_program(301);
  ASSERT_TRUE(line.client.download(5, 0x1F50, 1, long_program));
  EXPECT_EQ(line.run(), Outcome::aborted);
  EXPECT_EQ(line.client.abort_code(), 0x06070012U);
  EXPECT_EQ(line.shelf.completed, 0);
}

TEST(SdoClient, RefusesWhatCannotBeAsked) {
  SdoClient client;
  EXPECT_FALSE(client.upload(0, 0x1000, 0));
  EXPECT_FALSE(client.upload(128, 0x1000, 0));
  EXPECT_FALSE(client.download(5, 0x1000, 0, {}));
  EXPECT_EQ(client.outcome(), Outcome::idle);
  EXPECT_FALSE(client.step(0).has_value());
}

TEST(SdoClient, AsksThreeTimesAndNoMore) {
  Line line;
  line.loses = [](const CanFrame&) { return true; };
  ASSERT_TRUE(line.client.upload(5, 0x2000, 0));
  EXPECT_EQ(line.run(), Outcome::timed_out);
  EXPECT_EQ(line.asked.size(), 3U);
  EXPECT_NEAR(static_cast<double>(line.now_ns) / kMs, 301, 2);
  for (int i = 0; i < 1000; ++i) line.step();
  EXPECT_EQ(line.asked.size(), 3U);
}

TEST(SdoClient, ALostSegmentBeginsTheTransferAnew) {
  for (int lost = 0; lost < 12; ++lost) {
    for (const bool upload : {true, false}) {
      Line line;
      int count = 0;
      line.loses = [&](const CanFrame&) { return count++ == lost; };
      const std::vector<std::uint8_t> program(40, 9);
      ASSERT_TRUE(upload ? line.client.upload(5, 0x1008, 0) : line.client.download(5, 0x1F50, 1, program));
      ASSERT_EQ(line.run(), Outcome::done) << lost;
      if (upload)
        ASSERT_EQ(line.text(), line.shelf.text);
      else
        ASSERT_EQ(line.shelf.domain, program);
      ASSERT_LE(line.shelf.completed, 2);
    }
  }
}

TEST(SdoClient, EndsInTimeAndToldTheTruthOverABadLine) {
  std::mt19937 random(7);
  int done = 0;
  for (int i = 0; i < 300; ++i) {
    Line line;
    line.loses = [&](const CanFrame&) { return random() % 25 == 0; };
    std::vector<std::uint8_t> program(1 + random() % 200);
    for (auto& byte : program) byte = static_cast<std::uint8_t>(random());
    ASSERT_TRUE(line.client.download(5, 0x1F50, 1, program, true));
    const Outcome outcome = line.run(5000);
    ASSERT_NE(outcome, Outcome::busy);
    if (outcome == Outcome::done) {
      ASSERT_EQ(line.shelf.domain, program);
      ++done;
    }
  }
  EXPECT_GT(done, 150);
}

// Invalid answers of a server: the client aborts the transfer and returns no value.
TEST(SdoClient, NonsenseEndsTheTransfer) {
  const auto outcome_of = [](std::initializer_list<std::initializer_list<int>> answers, bool upload = true) {
    SdoClient client;
    static const std::vector<std::uint8_t> kProgram(20);
    EXPECT_TRUE(upload ? client.upload(5, 0x1008, 0) : client.download(5, 0x1008, 0, kProgram));
    std::uint64_t now_ns = 0;
    for (const auto& answer : answers) {
      now_ns += 5 * kMs;
      EXPECT_TRUE(client.step(now_ns).has_value());
      client.on_frame(frame_of(0x585, answer));
    }
    const Outcome outcome = client.outcome();
    const auto last = client.step(now_ns + 5 * kMs);
    if (outcome == Outcome::confused) {
      EXPECT_TRUE(last && last->data[0] == 0x80);
    }
    EXPECT_FALSE(outcome != Outcome::busy && client.step(now_ns + 10 * kMs));
    return outcome;
  };
  EXPECT_EQ(outcome_of({{0x41, 0x08, 0x10, 0, 3, 0, 0, 0}, {0x10, 1, 2, 3, 4, 5, 6, 7}}), Outcome::confused);  // toggle
  EXPECT_EQ(outcome_of({{0x41, 0x08, 0x10, 0, 3, 0, 0, 0}, {0x00, 1, 2, 3, 4, 5, 6, 7}}), Outcome::confused);  // more than announced
  EXPECT_EQ(outcome_of({{0x41, 0x08, 0x10, 0, 9, 0, 0, 0}, {0x01, 1, 2, 3, 4, 5, 6, 7}}), Outcome::confused);  // less than announced
  EXPECT_EQ(outcome_of({{0x41, 0x08, 0x10, 0, 0, 0, 1, 0}}), Outcome::confused);                               // 64 KiB
  EXPECT_EQ(outcome_of({{0x60, 0x08, 0x10, 0, 0, 0, 0, 0}}), Outcome::confused);                               // answer to a download
  EXPECT_EQ(outcome_of({{0x43, 0x08, 0x10, 0, 0}}), Outcome::confused);                                        // short
  EXPECT_EQ(outcome_of({{0x60, 0x08, 0x10, 0, 0, 0, 0, 0}, {0x30, 0, 0, 0, 0, 0, 0, 0}}, false), Outcome::confused);
  EXPECT_EQ(outcome_of({{0x43, 0x08, 0x10, 0, 0, 0, 0, 0}}, false), Outcome::confused);
  // For another object: late, and ignored.
  EXPECT_EQ(outcome_of({{0x43, 0x09, 0x10, 0, 1, 2, 3, 4}}), Outcome::busy);
  EXPECT_EQ(outcome_of({{0x80, 0x09, 0x10, 0, 0, 0, 2, 6}}), Outcome::busy);
}

TEST(SdoClient, NoiseEndsInTimeWithoutHarm) {
  std::mt19937 random(11);
  for (int i = 0; i < 3000; ++i) {
    SdoClient client;
    const std::vector<std::uint8_t> program(100);
    ASSERT_TRUE(i % 2 == 0 ? client.upload(5, 0x1008, 0) : client.download(5, 0x1008, 0, program));
    for (std::uint64_t now_ns = 0; now_ns < 3000 * kMs && client.outcome() == Outcome::busy; now_ns += 5 * kMs) {
      (void)client.step(now_ns);
      CanFrame noise{0x585, static_cast<std::uint8_t>(random() % 64 == 0 ? random() % 8 : 8), 0, {}};
      for (auto& byte : noise.data) byte = static_cast<std::uint8_t>(random());
      if (random() % 2 == 0) contract::write_le(&noise.data[1], 3, 0x001008);
      if (random() % 2 == 0) noise.data[0] = static_cast<std::uint8_t>(random() % 0x80);
      client.on_frame(noise);
      ASSERT_LE(client.uploaded().size(), SdoClient::kUploadMax);
      ASSERT_LE(client.confirmed(), program.size());
    }
    ASSERT_NE(client.outcome(), Outcome::busy);
  }
}

TEST(SdoClient, ReadsAWholeDrive) {
  firmware::TestBoard board;
  firmware::DriveNode<firmware::TestBoard> node(board, contract::Node::drive_left);
  firmware::tick(node, 1);
  SdoClient client;
  std::uint64_t now_ns = 0;
  int read = 0;
  for (const contract::ObjectInfo& o : contract::kObjects) {
    if (!contract::object_applies(o, contract::NodeKind::drive)) continue;
    ASSERT_TRUE(client.upload(1, o.index, o.sub));
    for (int i = 0; i < 100 && client.outcome() == Outcome::busy; ++i) {
      now_ns += kMs;
      board.sent.clear();
      if (const auto frame = client.step(now_ns)) node.on_frame(*frame);
      for (const CanFrame& frame : board.sent) client.on_frame(frame);
    }
    if (o.index == 0x1003 && o.sub > 0) {
      EXPECT_EQ(client.outcome(), Outcome::aborted);
      continue;
    }
    ASSERT_EQ(client.outcome(), Outcome::done) << o.name;
    EXPECT_EQ(client.uploaded().size(), contract::object_bytes(o.type)) << o.name;
    ++read;
  }
  EXPECT_GT(read, 50);
}

}  // namespace
}  // namespace hoist::bus
