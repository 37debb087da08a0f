// Recordings in candump's format: written, read strictly, replayed, decoded.
#include "control/bus/candump_log.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <random>
#include <sstream>

#include "control/bus/capture.hpp"
#include "control/bus/decode.hpp"
#include "control/bus/replay.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/run/heap_watch.hpp"

namespace hoist::bus {
namespace {
using contract::CanFrame;

LogEntry entry(std::uint64_t time_us, CanFrame frame, Direction direction = Direction::unknown) {
  LogEntry made;
  made.time_us = time_us;
  made.frame = frame;
  made.interface = {'c', 'a', 'n', '0'};
  made.direction = direction;
  return made;
}
std::string text_of(const LogEntry& made) {
  std::array<char, kLogLineMax> line{};
  return {line.data(), format_log_line(made, line)};
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text = {}) {
    path = ::testing::TempDir() + "hoist-log-" + std::to_string(::getpid()) + "-" + std::to_string(made_++);
    std::ofstream(path, std::ios::binary) << text;
  }
  ~TemporaryFile() { std::remove(path.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string text() const {
    std::ostringstream all;
    all << std::ifstream(path, std::ios::binary).rdbuf();
    return all.str();
  }
  std::string path;

 private:
  static inline int made_ = 0;
};

TEST(CandumpLog, WritesWhatCandumpWrites) {
  EXPECT_EQ(text_of(entry(1436509052249713, {0x044, 5, 0, {0x2A, 0x36, 0x6C, 0x2B, 0xBA}})), "(1436509052.249713) can0 044#2A366C2BBA\n");
  EXPECT_EQ(text_of(entry(7, {0x080, 0, 0, {}})), "(0000000000.000007) can0 080#\n");
  EXPECT_EQ(text_of(entry(0, {0x12345678, 1, CanFrame::kExtended, {0xFF}}, Direction::sent)), "(0000000000.000000) can0 12345678#FF T\n");
  EXPECT_EQ(text_of(entry(0, {0x181, 3, CanFrame::kRemote, {}}, Direction::received)), "(0000000000.000000) can0 181#R3 R\n");
  EXPECT_EQ(text_of(entry(0, {0x40, 8, CanFrame::kError, {}})), "(0000000000.000000) can0 20000040#0000000000000000\n");
  EXPECT_EQ(text_of(entry(0, {0x800, 0, 0, {}})), "") << "an id that does not exist";
  EXPECT_EQ(text_of(entry(0, {0x1, 9, 0, {}})), "");
}

TEST(CandumpLog, WhatIsWrittenIsReadBack) {
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    LogEntry made = entry(random() * 1000003ULL, {}, static_cast<Direction>(random() % 3));
    const unsigned kind = random() % 4;
    made.frame.flags = kind == 0 ? CanFrame::kExtended : kind == 1 ? CanFrame::kError : std::uint8_t{0};
    made.frame.id = random() & (kind < 2 ? 0x1FFFFFFFU : 0x7FFU);
    made.frame.dlc = static_cast<std::uint8_t>(random() % 9);
    if (kind == 2) made.frame.flags = CanFrame::kRemote;
    if (kind != 2)
      for (std::size_t b = 0; b < made.frame.dlc; ++b) made.frame.data[b] = static_cast<std::uint8_t>(random());
    std::string line = text_of(made);
    ASSERT_FALSE(line.empty());
    line.pop_back();
    LogEntry read;
    ASSERT_EQ(parse_log_line(line, read), nullptr) << line;
    ASSERT_EQ(read, made) << line;
    // A shortened line is refused, except where whole bytes or the direction are missing.
    const std::string cut = line.substr(0, random() % line.size());
    if (parse_log_line(cut, read) == nullptr) {
      EXPECT_TRUE(read.frame.dlc < made.frame.dlc || read.direction != made.direction || made.frame.flags == CanFrame::kRemote) << cut;
    }
  }
}

TEST(CandumpLog, RefusesEveryLineThatIsNotQuiteOne) {
  LogEntry read;
  for (const char* bad : {"",
                          " ",
                          "(1.000000)",
                          "(1.000000) can0",
                          "(1.000000) can0 ",
                          "(1.000000) can0 181",
                          "1.000000 can0 181#00",
                          "(1.00000) can0 181#00",
                          "(1.0000000) can0 181#00",
                          "(1) can0 181#00",
                          "(-1.000000) can0 181#00",
                          "(999999999999.000000) can0 181#00",
                          "(1.000000)can0 181#00",
                          "(1.000000) can0 81#00",
                          "(1.000000) can0 1810#00",
                          "(1.000000) can0 800#00",
                          "(1.000000) can0 1G1#00",
                          "(1.000000) can0 181#0",
                          "(1.000000) can0 181#0G",
                          "(1.000000) can0 181#000102030405060708",
                          "(1.000000) can0 181##000",
                          "(1.000000) can0 181#R9",
                          "(1.000000) can0 181#R10",
                          "(1.000000) can0 181#00 X",
                          "(1.000000) can0 181#00 R ",
                          "(1.000000) can0 181#00  R",
                          "(1.000000) can0 40000000#00",
                          "(1.000000) a-name-too-long-x 181#00",
                          "(1.000000) can0 181#00 extra",
                          "(1.000000) can0 20000040#R"})
    EXPECT_NE(parse_log_line(bad, read), nullptr) << bad;
  const std::string endless(5000, '0');
  EXPECT_NE(parse_log_line("(1.000000) can0 181#" + endless, read), nullptr);
}

TEST(CandumpLog, ARefusalNamesFileAndLine) {
  std::vector<LogEntry> entries;
  const TemporaryFile good("(1.000000) can0 181#00\n\n(1.000001) can0 182#01 R\r\n(1.000002) can0 080#");
  EXPECT_EQ(read_log(good.path, entries), "");
  EXPECT_EQ(entries.size(), 3U);
  const TemporaryFile bad("(1.000000) can0 181#00\n(1.000001) can0 182#0\n");
  EXPECT_EQ(read_log(bad.path, entries), bad.path + ":2: the data are not 0 to 8 whole bytes");
  EXPECT_TRUE(entries.empty()) << "a refused recording leaves nothing behind";
  const TemporaryFile nul(std::string("(1.000000) can0 181#00\0(1.000000) can0 182#00\n", 46));
  EXPECT_EQ(read_log(nul.path, entries), nul.path + ":1: the line holds a character that is no text");
  const TemporaryFile endless("(1.000000) can0 181#00\n" + std::string(100000, '0'));
  EXPECT_EQ(read_log(endless.path, entries), endless.path + ":2: the line is too long");
  const TemporaryFile empty("\n");
  EXPECT_NE(read_log(empty.path, entries), "");
  EXPECT_NE(read_log(::testing::TempDir() + "hoist-no-such-file", entries), "");
}

// A port that returns given frames and accepts a limited number.
class FakePort final : public CanPort {
 public:
  std::size_t receive(std::span<CanFrame> out, std::uint64_t) noexcept override {
    const std::size_t count = std::min(out.size(), waiting.size());
    std::copy_n(waiting.begin(), count, out.begin());
    waiting.clear();
    return count;
  }
  std::size_t send(std::span<const CanFrame> frames, std::uint64_t) noexcept override { return std::min(frames.size(), takes); }
  [[nodiscard]] bool up() const noexcept override { return true; }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  std::vector<CanFrame> waiting;
  std::size_t takes = 100;

 private:
  PortCounters counters_;
};

TEST(Capture, RecordsWhatPassedAndNothingElse) {
  const TemporaryFile file("(0000000001.000000) can0 700#00\n");
  std::string error;
  auto capture = Capture::open(file.path, "can0", 1'700'000'000'000'000'000, error);
  ASSERT_NE(capture, nullptr) << error;
  Capture& tap = *capture;
  auto inner = std::make_unique<FakePort>();
  FakePort& fake = *inner;
  CapturePort port(std::move(inner), std::move(capture));
  fake.waiting = {CanFrame{0x181, 1, 0, {0xAB}}};
  fake.takes = 1;
  std::array<CanFrame, 4> frames{};
  EXPECT_EQ(port.receive(frames, 2'000'000), 1U);
  const std::array out{CanFrame{0x201, 1, 0, {1}}, CanFrame{0x202, 1, 0, {2}}};
  EXPECT_EQ(port.send(out, 3'000'000), 1U);
  tap.flush();
  EXPECT_EQ(file.text(), "(0000000001.000000) can0 700#00\n(1700000000.002000) can0 181#AB R\n(1700000000.003000) can0 201#01 T\n")
      << "appends, and a frame that was not taken was not on the bus";
  EXPECT_EQ(tap.written(), 2U);
  EXPECT_EQ(tap.dropped(), 0U);
}

TEST(Capture, ADiskThatIsFullStopsTheRecordingNotTheCaller) {
  std::string error;
  auto capture = Capture::open("/dev/full", "can0", 0, error);
  ASSERT_NE(capture, nullptr) << error;
  for (int i = 0; i < 100; ++i) capture->put({0x181, 1, 0, {1}}, Direction::received, 1);
  capture->flush();
  EXPECT_EQ(capture->failure(), ENOSPC);
  EXPECT_EQ(capture->dropped(), 100U);
  EXPECT_EQ(capture->written(), 0U);
}

TEST(Capture, WhatFindsNoRoomIsCounted) {
  const TemporaryFile file;
  std::string error;
  auto capture = Capture::open(file.path, "can0", 0, error);
  ASSERT_NE(capture, nullptr) << error;
  constexpr std::uint64_t kPut = 20 * Capture::kRoom;
  for (std::uint64_t i = 0; i < kPut; ++i) capture->put({0x181, 8, 0, {1, 2, 3, 4, 5, 6, 7, 8}}, Direction::received, i * 1000);
  capture->flush();
  EXPECT_EQ(capture->written() + capture->dropped(), kPut) << "every frame is either in the file or counted";
  const std::string text = file.text();
  EXPECT_EQ(static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n')), capture->written());
  std::vector<LogEntry> entries;
  EXPECT_EQ(read_log(file.path, entries), "");
}

TEST(Capture, NothingIsAllocatedOnTheWay) {
  const TemporaryFile file;
  std::string error;
  auto capture = Capture::open(file.path, "can0", 0, error);
  ASSERT_NE(capture, nullptr) << error;
  auto inner = std::make_unique<FakePort>();
  Capture& tap = *capture;
  CapturePort port(std::move(inner), std::move(capture));
  const std::array out{CanFrame{0x201, 1, 0, {1}}, CanFrame{0x202, 1, 0, {2}}};
  std::array<CanFrame, 8> in{};
  tap.flush();  // the writing thread has begun
  const std::uint64_t before = run::heap_requests();
  for (std::uint64_t i = 0; i < 1000; ++i) {
    port.receive(in, i);
    port.send(out, i);
  }
  tap.flush();
  EXPECT_EQ(run::heap_requests() - before, 0U);
  EXPECT_EQ(tap.written(), 2000U);
}

TEST(Capture, AFolderThatIsNotThereIsRefused) {
  std::string error;
  EXPECT_EQ(Capture::open("/nowhere/at/all.log", "can0", 0, error), nullptr);
  EXPECT_NE(error.find("/nowhere/at/all.log"), std::string::npos);
}

TEST(Replay, KeepsThePaceAndLeavesOutWhatTheRecordedComputerSent) {
  ReplayPort port({entry(1'000'000, {0x181, 1, 0, {1}}), entry(1'000'000, {0x201, 1, 0, {9}}, Direction::sent),
                   entry(1'010'000, {0x182, 1, 0, {2}}, Direction::received), entry(900'000, {0x191, 1, 0, {3}}),
                   entry(900'001, {0x40, 8, CanFrame::kError, {}}), entry(1'000'001, {0x192, 1, 0, {4}})});
  std::array<CanFrame, 8> frames{};
  std::uint64_t now_ns = 5'000'000'000;
  EXPECT_TRUE(port.up());
  ASSERT_EQ(port.receive(frames, now_ns), 1U);
  EXPECT_EQ(frames[0].id, 0x181U);
  EXPECT_EQ(port.receive(frames, now_ns + 9'999'999), 0U);
  ASSERT_EQ(port.receive(frames, now_ns + 10'000'000), 2U) << "a clock that was set back costs no time";
  EXPECT_EQ(frames[0].id, 0x182U);
  EXPECT_EQ(frames[1].id, 0x191U);
  EXPECT_TRUE(port.up());
  ASSERT_EQ(port.receive(frames, now_ns + 200'000'000), 1U);
  EXPECT_FALSE(port.up());
  EXPECT_STREQ(port.problem(), "the recording is over");
  const std::array out{CanFrame{0x201, 1, 0, {1}}};
  EXPECT_EQ(port.send(out, now_ns), 0U);
  EXPECT_EQ(port.counters().send_refused, 1U);
}

TEST(Replay, IsOpenedByNameAndRefusesABadFile) {
  const TemporaryFile good("(1.000000) can0 181#00\n"), bad("(1.000000) can0 181#0\n");
  std::string error;
  const auto port = open_port("replay:" + good.path, error);
  ASSERT_NE(port, nullptr) << error;
  std::array<CanFrame, 8> frames{};
  EXPECT_EQ(port->receive(frames, 1), 1U);
  EXPECT_EQ(open_port("replay:" + bad.path, error), nullptr);
  EXPECT_NE(error.find(":1: "), std::string::npos);
  EXPECT_EQ(open_port("replay:", error), nullptr);
}

TEST(Decode, NamesAndScalesEveryPdo) {
  const DecodedFrame tilt = decode_frame({0x191, 6, 0, {0xE8, 0x03, 0x18, 0xFC, 0x03, 0x2A}});
  EXPECT_EQ(tilt.name, "tilt_left_tx1");
  ASSERT_EQ(tilt.fields.size(), 4U);
  EXPECT_EQ(tilt.fields[0].name, "slope_long");
  EXPECT_DOUBLE_EQ(tilt.fields[0].value, 1.0);
  EXPECT_EQ(tilt.fields[0].unit, "deg");
  EXPECT_DOUBLE_EQ(tilt.fields[1].value, -1.0);
  EXPECT_DOUBLE_EQ(tilt.fields[3].value, 42.0);
  for (const contract::PdoInfo& pdo : contract::kPdos)
    for (const contract::NodeInfo& node : contract::kNodes) {
      if (node.kind != pdo.kind) continue;
      CanFrame frame{static_cast<std::uint32_t>(pdo.cob_base) + node.id, static_cast<std::uint8_t>(contract::pdo_bytes(pdo.pdo)), 0, {}};
      const DecodedFrame whole = decode_frame(frame);
      EXPECT_TRUE(whole.problem.empty());
      EXPECT_FALSE(whole.fields.empty()) << whole.name;
      --frame.dlc;
      const DecodedFrame cut = decode_frame(frame);
      EXPECT_EQ(cut.name, whole.name);
      EXPECT_FALSE(cut.problem.empty());
      EXPECT_TRUE(cut.fields.empty()) << "values out of a frame that is too short";
    }
}

TEST(Decode, SpeaksOfServicesInWords) {
  namespace canopen = contract::canopen;
  const DecodedFrame heartbeat = decode_frame(canopen::heartbeat(0x11, canopen::NmtState::operational));
  EXPECT_EQ(heartbeat.name, "tilt_left_heartbeat");
  EXPECT_EQ(heartbeat.fields[0].meaning, "operational");
  const DecodedFrame nmt = decode_frame(canopen::nmt(canopen::NmtCommand::start, 0));
  EXPECT_EQ(nmt.name, "nmt");
  EXPECT_EQ(nmt.fields[0].meaning, "start");
  EXPECT_EQ(nmt.fields[1].meaning, "all");
  EXPECT_EQ(decode_frame(canopen::sync()).name, "sync");
  const DecodedFrame request = decode_frame(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x6064, 0, 0));
  EXPECT_EQ(request.name, "drive_left_sdo_request");
  EXPECT_EQ(request.fields[1].meaning, "position");
  const DecodedFrame emergency = decode_frame({0x082, 8, 0, {0x10, 0x23, 0x02, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF}});
  EXPECT_EQ(emergency.name, "drive_right_emergency");
  EXPECT_EQ(emergency.fields[0].meaning, "The motor draws too much current");
  EXPECT_DOUBLE_EQ(emergency.fields[2].value, 1099511627775.0);
  EXPECT_EQ(emergency.fields[1].meaning, "current");
  const DecodedFrame segment = decode_frame({0x581, 8, 0, {0x00, 0x64, 0x60, 0x00, 1, 2, 3, 4}});
  EXPECT_EQ(segment.fields[1].meaning, "") << "data of a segment that look like an index";
  EXPECT_EQ(decode_frame({0x300, 0, 0, {}}).name, "") << "nobody sends that";
  EXPECT_EQ(decode_frame({0x181, 8, CanFrame::kExtended, {}}).name, "") << "a long id is another id";
}

// CiA 402, statusword and controlword as the standard's tables have them.
TEST(Decode, StateAndStatusWordsInWords) {
  const auto words = [](std::uint32_t id, std::initializer_list<int> bytes, std::size_t field) {
    contract::CanFrame frame{id, static_cast<std::uint8_t>(bytes.size()), 0, {}};
    std::transform(bytes.begin(), bytes.end(), frame.data.begin(), [](int b) { return static_cast<std::uint8_t>(b); });
    const DecodedFrame decoded = decode_frame(frame);
    return field < decoded.fields.size() ? decoded.fields[field].meaning : decoded.problem;
  };
  const auto status = [&](int word) { return words(0x181, {word & 0xFF, word >> 8, 0, 0, 0, 0, 0, 0}, 0); };
  EXPECT_EQ(status(0x0000), "not ready");
  EXPECT_EQ(status(0x1250), "switch-on disabled, supply, remote, at rest");
  EXPECT_EQ(status(0x0231), "ready to switch on, supply, remote");
  EXPECT_EQ(status(0x0233), "switched on, supply, remote");
  EXPECT_EQ(status(0x06B7), "operation enabled, supply, warning: current limit reduced, remote, target reached");
  EXPECT_EQ(status(0x0A17), "quick stop active, supply, remote, current limited");
  EXPECT_EQ(status(0x021F), "fault reaction, supply, remote");
  EXPECT_EQ(status(0x0208), "fault, remote");
  const auto control = [&](int word) { return words(0x202, {word & 0xFF, word >> 8, 0, 0, 0, 0}, 0); };
  EXPECT_EQ(control(0x00), "disable voltage");
  EXPECT_EQ(control(0x02), "quick stop");
  EXPECT_EQ(control(0x06), "shutdown");
  EXPECT_EQ(control(0x07), "switch on");
  EXPECT_EQ(control(0x0F), "enable operation");
  EXPECT_EQ(control(0x80), "fault reset");
  EXPECT_EQ(control(0x10F), "enable operation, halt");
  EXPECT_EQ(words(0x281, {0, 0, 0, 0, 0x20, 0x32, 0, 0}, 1), "The supply voltage is too low");
  EXPECT_EQ(words(0x281, {0, 0, 0, 0, 0, 0, 0, 0}, 1), "none");
  EXPECT_EQ(words(0x191, {0, 0, 0, 0, 0x03, 1}, 2), "valid, converged");
  EXPECT_EQ(words(0x191, {0, 0, 0, 0, 0x30, 1}, 2), "not valid, self-test failed, sensor missing");
  EXPECT_EQ(words(0x188, {0x05, 0x01}, 0), "front, left");
  EXPECT_EQ(words(0x188, {0x05, 0x01}, 1), "emergency stop open");
  EXPECT_EQ(words(0x188, {0x00, 0x00}, 0), "none pressed");
  // The same names in SDO requests, and the reason of an abort.
  EXPECT_EQ(words(0x581, {0x4B, 0x41, 0x60, 0, 0x08, 0x02, 0, 0}, 3), "fault, remote");
  EXPECT_EQ(words(0x581, {0x4F, 0x51, 0x22, 0, 0x42, 0, 0, 0}, 3), "current sensor, watchdog");
  EXPECT_EQ(words(0x588, {0x4F, 0x01, 0x10, 0, 0x11, 0, 0, 0}, 3), "error, communication");
  EXPECT_NE(words(0x581, {0x80, 0x17, 0x10, 0, 0x30, 0, 0x09, 0x06}, 3), "");
}

}  // namespace
}  // namespace hoist::bus
