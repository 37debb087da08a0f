// The SLCAN driver against a scripted adapter on the other end of a pty, in virtual time.
#include "control/bus/slcan.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "control/bus/socketcan.hpp"

namespace hoist::bus {
namespace {
using contract::CanFrame;

// The adapter's end, scripted by the test.
class Adapter {
 public:
  Adapter() {
    master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    ::grantpt(master_);
    ::unlockpt(master_);
    path = ::ptsname(master_);
  }
  ~Adapter() { unplug(); }
  void unplug() {
    if (master_ >= 0) ::close(master_);
    master_ = -1;
  }
  void say(const std::string& text) { ASSERT_EQ(::write(master_, text.data(), text.size()), static_cast<ssize_t>(text.size())); }
  std::string heard() {
    std::string all;
    std::array<char, 4096> buffer;
    pollfd wait{master_, POLLIN, 0};
    while (::poll(&wait, 1, 0) == 1 && (wait.revents & POLLIN) != 0) {
      const ssize_t got = ::read(master_, buffer.data(), buffer.size());
      if (got <= 0) break;
      all.append(buffer.data(), static_cast<std::size_t>(got));
    }
    return all;
  }
  std::string path;

 private:
  int master_ = -1;
};

CanFrame frame(std::uint32_t id, std::uint8_t first) { return CanFrame{id, 2, 0, {first, 0x5A}}; }

class SlcanPortTest : public ::testing::Test {
 protected:
  std::size_t receive() { return port->receive(frames, now_ns); }
  void bring_up() {
    receive();
    EXPECT_EQ(adapter.heard(), "\rC\rS5\rE1\rO\r");
    adapter.say("\r\r\r\a\r");
    receive();
    ASSERT_TRUE(port->up());
  }
  Adapter adapter;
  std::unique_ptr<SlcanPort> port = std::make_unique<SlcanPort>(adapter.path);
  std::array<CanFrame, 64> frames{};
  std::uint64_t now_ns = 1'000'000'000;
};

TEST_F(SlcanPortTest, SetsUpTheAdapterAndIsUpOnlyThen) {
  EXPECT_FALSE(port->up());
  receive();
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rE1\rO\r");
  EXPECT_FALSE(port->up());
  adapter.say("\r\a\a\r");  // nothing to close, rate already set: an adapter left open
  receive();
  EXPECT_FALSE(port->up());
  adapter.say("\r");
  receive();
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, ARefusedOpenIsTriedAgain) {
  receive();
  adapter.heard();
  adapter.say("\r\r\r\r\a");
  receive();
  EXPECT_FALSE(port->up());
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rO\r") << "every second time without what an adapter may not know";
  adapter.say("\r\r\r\a");
  receive();
  EXPECT_FALSE(port->up());
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rE1\rO\r");
}

TEST_F(SlcanPortTest, ASilentAdapterIsAskedAgain) {
  receive();
  adapter.heard();
  now_ns += SlcanPort::kSetupNs - 1;
  receive();
  EXPECT_EQ(adapter.heard(), "");
  now_ns += 1;
  receive();
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rO\r");
}

TEST_F(SlcanPortTest, AnAdapterThatAnswersOnlyWhatItKnowsIsUpToo) {
  receive();
  adapter.heard();
  adapter.say("\r\r\r");  // to C, S5 and O
  receive();
  EXPECT_FALSE(port->up()) << "more may come";
  now_ns += SlcanPort::kSetupNs;
  receive();
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, AnAdapterThatStumblesOverAnUnknownLineIsSetUpWithoutIt) {
  receive();
  adapter.heard();
  adapter.say("\r\r\a");  // as slcanpty: C, S5, a refusal, and everything behind it forgotten
  receive();
  EXPECT_FALSE(port->up());
  now_ns += SlcanPort::kSetupNs;
  receive();
  EXPECT_FALSE(port->up());
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rO\r");
  adapter.say("\r\r\r");
  receive();
  now_ns += SlcanPort::kSetupNs;
  receive();
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, CarriesFramesBothWays) {
  bring_up();
  const std::array out{frame(0x201, 0x12), frame(0x080, 0x00)};
  EXPECT_EQ(port->send(out, now_ns), 2U);
  EXPECT_EQ(adapter.heard(), "t2012125A\rt0802005A\r");
  adapter.say("z\rz\rt1812AB01\r");
  ASSERT_EQ(receive(), 1U);
  EXPECT_EQ(frames[0].id, 0x181U);
  EXPECT_EQ(frames[0].data[0], 0xAB);
  EXPECT_EQ(port->counters().send_refused, 0U);
}

TEST_F(SlcanPortTest, ALineCutAnywhereArrivesWholeOrNotAtAll) {
  bring_up();
  const std::string line = "t1814AB01CD02\r";
  for (std::size_t cut = 0; cut <= line.size(); ++cut) {
    if (cut > 0) adapter.say(line.substr(0, cut));
    std::size_t count = receive();
    if (cut < line.size()) adapter.say(line.substr(cut));
    count += receive();
    ASSERT_EQ(count, 1U) << "cut at " << cut;
  }
  // A line that lost a byte is refused, never completed with bytes of the previous line.
  const std::uint32_t refused = port->counters().refused;
  adapter.say("t1814AB01CD0\r");
  EXPECT_EQ(receive(), 0U);
  EXPECT_EQ(port->counters().refused, refused + 1);
}

TEST_F(SlcanPortTest, CountsARefusedFrame) {
  bring_up();
  const std::array out{frame(0x201, 1)};
  port->send(out, now_ns);
  adapter.say("\a");
  receive();
  EXPECT_EQ(port->counters().send_refused, 1U);
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, StopsSendingWhenTheWindowIsFullAndRecovers) {
  bring_up();
  std::array<CanFrame, SlcanPort::kWindow + 3> many;
  many.fill(frame(0x201, 1));
  EXPECT_EQ(port->send(many, now_ns), SlcanPort::kWindow);
  EXPECT_EQ(port->counters().send_refused, 3U);
  const std::array pair{frame(0x201, 1), frame(0x202, 1)};
  EXPECT_EQ(port->send(pair, now_ns), 0U);
  adapter.heard();
  adapter.say("z\r");
  receive();
  EXPECT_EQ(port->send(pair, now_ns), 0U) << "room for one: a drive command without its partner is worse than none";
  EXPECT_EQ(adapter.heard(), "");
  adapter.say("z\r");
  receive();
  EXPECT_EQ(port->send(pair, now_ns), 2U);
}

// An adapter in memory that answers within the step, or whose line halts.
class Line final : public SerialDevice {
 public:
  const char* open() noexcept override { return nullptr; }
  void close() noexcept override {}
  ssize_t read(std::span<char> text) noexcept override {
    if (answers.empty()) {
      errno = EAGAIN;
      return -1;
    }
    const std::size_t count = answers.copy(text.data(), text.size());
    answers.erase(0, count);
    return static_cast<ssize_t>(count);
  }
  ssize_t write(std::span<const char> text) noexcept override {
    const std::size_t count = std::min(text.size(), room);
    room -= count;
    heard.append(text.data(), count);
    errno = EAGAIN;
    return count > 0 ? static_cast<ssize_t>(count) : -1;
  }
  void discard() noexcept override { ++discarded; }
  // To each line heard; the first answer is damaged if asked for.
  void answer(bool damaged) {
    for (const char c : heard)
      if (c == '\r') answers += "z\r";
    if (damaged) answers[0] = 'y';
    heard.clear();
  }
  std::string heard, answers;
  std::size_t room = std::string::npos;
  int discarded = 0;
};

class SlcanLineTest : public ::testing::Test {
 protected:
  SlcanLineTest() {
    step({});
    line->answer(false);
    step({});
    EXPECT_TRUE(port.up());
  }
  // One control step; how many frames were taken.
  std::size_t step(std::span<const CanFrame> out) {
    now_ns += 10'000'000;
    port.receive(frames, now_ns);
    return port.send(out, now_ns);
  }
  std::shared_ptr<Line> line = std::make_shared<Line>();
  SlcanPort port{line};
  std::array<CanFrame, 64> frames{};
  std::uint64_t now_ns = 1'000'000'000;
  const std::array<CanFrame, 5> full{frame(0x201, 1), frame(0x202, 1), frame(0x70F, 1), frame(0x208, 1), frame(0x080, 0)};
};

// Lost answers would add up, a few in an hour of motor noise, until no room is left for SYNC and for one of the two drive commands.
TEST_F(SlcanLineTest, DamagedAnswersDoNotNarrowTheWindowForGood) {
  int left_out = 0;
  std::size_t before = full.size();
  for (int i = 0; i < 3000; ++i) {
    const std::size_t taken = step(full);
    ASSERT_TRUE(taken == full.size() || (taken == 0 && before > 0)) << taken << " frames in step " << i;
    if (taken == 0) ++left_out;
    before = taken;
    line->answer(i % 100 == 50);
  }
  EXPECT_LE(left_out, 2) << "one step for the lost answers that fill the window";
  EXPECT_TRUE(port.up());
  EXPECT_EQ(port.counters().send_refused, 30U - 6U + 5U * static_cast<std::uint32_t>(left_out)) << "lost answers count, too";
}

// A line too slow for the traffic looks the same, but it answers in the step that is left out.
TEST_F(SlcanLineTest, ASlowAdapterIsNeverGivenMoreThanTheWindow) {
  std::size_t waiting = 0;
  for (int i = 0; i < 300; ++i) {
    waiting += step(full);
    ASSERT_LE(waiting, SlcanPort::kWindow);
    const std::size_t answered = std::min<std::size_t>(waiting, 3);
    waiting -= answered;
    for (std::size_t k = 0; k < answered; ++k) line->answers += "z\r";
  }
  EXPECT_GT(port.counters().sent, 800U);
}

TEST_F(SlcanLineTest, ALineThatHaltsIsSetUpAgainAndNeverSendsWhatIsOld) {
  line->room = 20;  // the two drive commands
  step(full);
  line->heard.clear();
  line->room = 0;
  const int discarded = line->discarded;
  for (int i = 0; i < 6; ++i) step(full);
  EXPECT_FALSE(port.up());
  EXPECT_STREQ(port.problem(), "the adapter does not answer");
  EXPECT_EQ(line->discarded, discarded + 1) << "what the kernel still holds is as old";
  line->room = std::string::npos;
  step(full);
  EXPECT_EQ(line->heard, "\rC\rS5\rE1\rO\r");
}

TEST_F(SlcanPortTest, SilenceAfterFramesIsAFaultAndAtLastSetsUpAgain) {
  bring_up();
  const std::array out{frame(0x201, 1)};
  for (std::uint32_t i = 0; i < SlcanPort::kSilencesBeforeSetup; ++i) {
    EXPECT_TRUE(port->up());
    port->send(out, now_ns);
    now_ns += SlcanPort::kAnswerNs + 1;
    receive();
  }
  EXPECT_EQ(port->counters().send_refused, SlcanPort::kSilencesBeforeSetup);
  EXPECT_FALSE(port->up());
  EXPECT_NE(adapter.heard().find("\rC\rS5\rE1\rO\r"), std::string::npos);
}

// Found in a random session: noise on the line made a `C` of a frame, the adapter closed the bus, and from then on the hoist was deaf.
TEST_F(SlcanPortTest, AnAdapterThatRefusesEveryLineAndHearsNothingIsSetUpAgain) {
  bring_up();
  const std::array out{frame(0x201, 1)};
  const auto refuse = [&](std::uint32_t times) {
    for (std::uint32_t i = 0; i < times; ++i) {
      EXPECT_TRUE(port->up());
      port->send(out, now_ns);
      adapter.say("\a");
      receive();
    }
  };
  refuse(SlcanPort::kRefusalsBeforeSetup - 1);
  adapter.say("t2012015A\r");  // it hears: it is only full
  EXPECT_EQ(receive(), 1U);
  refuse(SlcanPort::kRefusalsBeforeSetup - 1);
  adapter.say("z\r");
  receive();
  refuse(SlcanPort::kRefusalsBeforeSetup);
  EXPECT_FALSE(port->up());
  EXPECT_NE(adapter.heard().find("\rC\rS5\rE1\rO\r"), std::string::npos);
}

TEST_F(SlcanPortTest, ComesBackAfterTheAdapterWasPulledOut) {
  const std::string link = ::testing::TempDir() + "hoist-slcan-" + std::to_string(::getpid());
  ::unlink(link.c_str());
  ASSERT_EQ(::symlink(adapter.path.c_str(), link.c_str()), 0);
  port = std::make_unique<SlcanPort>(link);
  bring_up();
  adapter.unplug();
  receive();
  EXPECT_FALSE(port->up());
  const std::array out{frame(0x201, 1)};
  EXPECT_EQ(port->send(out, now_ns), 0U);

  Adapter second;
  ::unlink(link.c_str());
  ASSERT_EQ(::symlink(second.path.c_str(), link.c_str()), 0);
  receive();
  EXPECT_EQ(second.heard(), "") << "not before the retry time";
  now_ns += SlcanPort::kRetryNs;
  receive();
  EXPECT_EQ(second.heard(), "\rC\rS5\rE1\rO\r");
  second.say("\r\r\r\a\r");
  receive();
  EXPECT_TRUE(port->up());
  EXPECT_EQ(port->counters().reopened, 1U);
  ::unlink(link.c_str());
}

TEST_F(SlcanPortTest, ABabblingLineIsBoundedAndRefused) {
  bring_up();
  std::string noise;
  std::uint32_t seed = 1;
  for (int i = 0; i < 3000; ++i) {
    seed = seed * 1664525U + 1013904223U;
    noise += static_cast<char>((seed >> 24) & 0x7FU);
  }
  adapter.say(noise + "\r");
  for (int i = 0; i < 10; ++i) receive();
  EXPECT_GT(port->counters().refused, 0U);
  adapter.say("t1812AB01\r");
  EXPECT_EQ(receive(), 1U) << "a good line after noise is heard";
}

TEST_F(SlcanPortTest, BusOffOfTheAdapterStopsSendingUntilItIsBack) {
  bring_up();
  EXPECT_STREQ(port->problem(), "");
  adapter.say("sw096000\r");
  receive();
  EXPECT_EQ(port->counters().state, BusState::warning);
  EXPECT_EQ(port->counters().rx_errors, 96U);
  EXPECT_TRUE(port->up());
  adapter.say("sp001128\r");
  receive();
  EXPECT_EQ(port->counters().state, BusState::passive);
  EXPECT_EQ(port->counters().tx_errors, 128U);
  EXPECT_TRUE(port->up());
  adapter.heard();

  adapter.say("sb001255\r");
  receive();
  EXPECT_EQ(port->counters().state, BusState::off);
  EXPECT_EQ(port->counters().bus_offs, 1U);
  EXPECT_FALSE(port->up());
  EXPECT_NE(std::string(port->problem()).find("bus-off"), std::string::npos);
  const std::array out{frame(0x201, 1)};
  EXPECT_EQ(port->send(out, now_ns), 0U) << "an old command must not wait for the bus";
  EXPECT_EQ(adapter.heard(), "");

  adapter.say("sa000000\r");
  receive();
  EXPECT_TRUE(port->up());
  EXPECT_STREQ(port->problem(), "");
  EXPECT_EQ(port->send(out, now_ns), 1U);
}

TEST_F(SlcanPortTest, BusOffWhoseEndWasNotHeardIsAskedForAgain) {
  bring_up();
  adapter.say("sb000255\r");
  receive();
  now_ns += SlcanPort::kBusOffNs - 1;
  receive();
  EXPECT_EQ(adapter.heard(), "");
  EXPECT_FALSE(port->up());
  now_ns += 1;
  receive();
  EXPECT_EQ(adapter.heard(), "\rC\rS5\rE1\rO\r");
  EXPECT_FALSE(port->up()) << "not before it has answered";
  adapter.say("\r\r\r\r\rsb000255\r");  // still off, and says so
  receive();
  EXPECT_FALSE(port->up());
  EXPECT_EQ(port->counters().bus_offs, 2U);
  now_ns += SlcanPort::kBusOffNs;
  receive();
  adapter.heard();
  adapter.say("\r\r\r\r\r");
  receive();
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, CountsErrorsTheAdapterTellsAndRefusesLinesThatCannotBe) {
  bring_up();
  adapter.say("e1a\re3boO\r");
  receive();
  EXPECT_EQ(port->counters().bus_errors, 4U);
  EXPECT_EQ(port->counters().overflows, 2U);
  EXPECT_EQ(port->counters().refused, 0U);
  for (const std::string bad : {"e\r", "e0\r", "e2a\r", "e1aa\r", "e1x\r", "eaa\r"}) {
    const std::uint32_t before = port->counters().refused;
    adapter.say(bad);
    receive();
    EXPECT_EQ(port->counters().refused, before + 1) << bad;
  }
  EXPECT_EQ(port->counters().bus_errors, 4U);
  EXPECT_TRUE(port->up());
}

TEST_F(SlcanPortTest, SaysWhyItIsNotUp) {
  SlcanPort nowhere("/nowhere/tty");
  nowhere.receive(frames, now_ns);
  EXPECT_STREQ(nowhere.problem(), "the device is not there");
  SlcanPort no_tty("/dev/null");
  no_tty.receive(frames, now_ns);
  EXPECT_STREQ(no_tty.problem(), "the device is no serial line, or not at this rate");
  EXPECT_FALSE(no_tty.up());
  receive();
  EXPECT_STREQ(port->problem(), "the adapter does not answer");
}

TEST_F(SlcanPortTest, SetsTheSerialLineUp) {
  port = std::make_unique<SlcanPort>(adapter.path, 2'000'000);
  bring_up();
  const int fd = ::open(adapter.path.c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(fd, 0);
  termios settings{};
  ASSERT_EQ(::tcgetattr(fd, &settings), 0);
  ::close(fd);
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B2000000));
  EXPECT_NE(settings.c_cflag & CRTSCTS, 0U);
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0U);
  EXPECT_EQ(settings.c_iflag & (ICRNL | IXON), 0U) << "a CR that becomes a line feed would end no line";
}

TEST(OpenPort, RefusesUnknownWordsAndSaysWhatToWrite) {
  std::string error;
  EXPECT_EQ(open_port("can0", error), nullptr);
  EXPECT_NE(error.find("slcan:"), std::string::npos);
  EXPECT_NE(error.find("socketcan:"), std::string::npos);
  EXPECT_EQ(open_port("slcan:", error), nullptr);
  EXPECT_NE(open_port("slcan:/nowhere", error), nullptr) << "a device that is not there yet is waited for";
}

TEST(OpenPort, RefusesARateThatIsNone) {
  std::string error;
  EXPECT_NE(open_port("slcan:/nowhere@115200", error), nullptr);
  EXPECT_NE(open_port("slcan:/nowhere@3000000", error), nullptr);
  for (const char* bad : {"slcan:/nowhere@", "slcan:/nowhere@1000001", "slcan:/nowhere@fast", "slcan:/nowhere@-1", "slcan:/nowhere@9600",
                          "slcan:/nowhere@1000000 ", "slcan:@1000000"}) {
    error.clear();
    EXPECT_EQ(open_port(bad, error), nullptr) << bad;
    EXPECT_FALSE(error.empty()) << bad;
  }
  open_port("slcan:/nowhere@9600", error);
  EXPECT_NE(error.find("1000000"), std::string::npos) << "says what is allowed";
}

TEST(OpenPort, RefusesAnInterfaceNameThatCannotBe) {
  std::string error;
  for (const char* bad : {"socketcan:", "socketcan:a/b", "socketcan:sixteencharacter", "socketcan:..", "socketcan:can 0"}) {
    error.clear();
    EXPECT_EQ(open_port(bad, error), nullptr) << bad;
    EXPECT_NE(error.find("15 characters"), std::string::npos) << bad;
  }
  // Whether this kernel has CAN or not: either a port that waits for its interface, or a refusal that says what is missing.
  error.clear();
  const auto port = open_port("socketcan:hoist-none", error);
  if (SocketCanPort::kernel_problem().empty()) {
    ASSERT_NE(port, nullptr);
    EXPECT_FALSE(port->up());
  } else {
    EXPECT_EQ(port, nullptr);
    EXPECT_EQ(error, SocketCanPort::kernel_problem());
  }
}

TEST(OpenPort, TheQueueThatIsPrescribedHoldsTwoSteps) {
  const std::string wanted = "txqueuelen " + std::to_string(SocketCanPort::kQueueFrames);
  for (const char* file : {"/control/bus/README.md", "/firmware/HARDWARE.md"}) {
    std::ifstream in(std::string(HOIST_SOURCE_DIR) + file);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_NE(text.find(wanted), std::string::npos) << file;
    EXPECT_EQ(text.find("txqueuelen "), text.rfind("txqueuelen ")) << file;
  }
}

// Only hoist-control --bus sim: takes steps from a simulator; no real bus and no tool can get that clock.
TEST(OpenPort, RefusesLockStep) {
  std::string error;
  EXPECT_EQ(open_port("sim:/tmp/step.sock", error), nullptr);
  EXPECT_NE(error.find("hoist-control"), std::string::npos) << error;
}

}  // namespace
}  // namespace hoist::bus
