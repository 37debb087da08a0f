// Lock-step: both ends of the step socket, each against a partner that the test plays.
#include "firmware/sim/lock_step.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "control/bus/step_line.hpp"
#include "firmware/sim/unix_listener.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::sim {
namespace {

using contract::StepHeader;
using Answer = LockStep::Answer;

std::string packet(std::uint32_t step, std::uint32_t room, const std::string& text, std::uint32_t magic = contract::kStepMagic) {
  const StepHeader header{magic, step, room};
  return std::string(reinterpret_cast<const char*>(&header), sizeof header) + text;
}
void say(int fd, const std::string& bytes) {
  EXPECT_EQ(::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL), static_cast<ssize_t>(bytes.size()));
}
std::string hear(int fd) {
  std::array<char, 4096> buffer{};
  const ssize_t size = ::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
  return size > 0 ? std::string(buffer.data(), static_cast<std::size_t>(size)) : size == 0 ? "closed" : "nothing";
}
// What a partner of another version, or another program, may send instead of `step`.
std::vector<std::string> malformed(std::uint32_t step, std::uint32_t room) {
  return {"",
          "HTP",
          packet(step, room, "t1", 7),
          packet(step - 1, room, "t1"),
          packet(step + 1, room, "t1"),
          packet(step, contract::kStepTextMax + 1, "t1"),
          packet(step, room, std::string(contract::kStepTextMax + 1, 'x'))};
}

class LockStepTest : public ::testing::Test {
 protected:
  int connect() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.c_str(), path.size());
    const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    return fd;
  }

 private:
  const test::TemporaryFolder folder_;

 protected:
  const std::string path = folder_ / "step";
};

TEST_F(LockStepTest, TheSimulatorGivesAStepAndWaitsForItsAnswer) {
  LockStep line;
  ASSERT_EQ(line.open(path), "");
  line.give();
  EXPECT_EQ(line.take(0), Answer::done) << "no core: time goes on";
  const int core = connect();
  line.give();
  EXPECT_TRUE(line.presence().there);
  EXPECT_EQ(hear(core), packet(1, contract::kStepTextMax, ""));
  EXPECT_EQ(line.take(0), Answer::waiting) << "the world stands still";
  say(core, packet(1, 0, "O\r"));
  EXPECT_EQ(line.take(0), Answer::done);
  std::array<char, 8> text{};
  EXPECT_EQ(line.read(text), 2U);
  EXPECT_EQ(std::string(text.data(), 2), "O\r");
  EXPECT_EQ(line.write(std::string_view("\rt1\r")), 4U);
  line.give();
  EXPECT_EQ(hear(core), packet(2, contract::kStepTextMax, "\rt1\r"));
  ::close(core);
  EXPECT_EQ(line.take(0), Answer::lost);
  EXPECT_FALSE(line.presence().there);
}

TEST_F(LockStepTest, TheSimulatorLetsGoOfACoreThatHangsOrTalksNonsense) {
  LockStep line(60);
  ASSERT_EQ(line.open(path), "");
  for (const std::string& bad : malformed(1, 0)) {
    const int core = connect();
    line.give();
    say(core, bad);
    EXPECT_EQ(line.take(0), Answer::lost) << bad.size();
    static_cast<void>(hear(core));
    EXPECT_EQ(hear(core), "closed");
    ::close(core);
  }
  const int core = connect();
  line.give();
  EXPECT_EQ(line.take(20), Answer::waiting);
  EXPECT_EQ(line.take(20), Answer::waiting);
  EXPECT_EQ(line.take(20), Answer::lost);
  EXPECT_STREQ(line.why(), "does not answer");
  ::close(core);
}

// The core's end, with a simulator that the test plays.
class StepLineTest : public LockStepTest {
 protected:
  StepLineTest() { EXPECT_EQ(listen_at(path, SOCK_SEQPACKET, 1, listener_), ""); }
  ~StepLineTest() override {
    ::close(sim);
    ::close(listener_);
  }
  /// Until the line has connected: it retries every 0.2 s, and steps without the simulator meanwhile.
  void accept(bus::StepLine& line) {
    ::close(sim);
    for (sim = -1; sim < 0; sim = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK)) EXPECT_FALSE(line.wait(ending));
  }
  std::atomic<bool> ending{false};
  int sim = -1;

 private:
  int listener_ = -1;
};

TEST_F(StepLineTest, TheCoreStepsWithTheSimulator) {
  bus::StepLine line(path);
  EXPECT_NE(line.open(), nullptr);
  accept(line);
  say(sim, packet(1, 3, ""));
  ASSERT_TRUE(line.wait(ending));
  EXPECT_EQ(line.open(), nullptr);
  EXPECT_EQ(line.write(std::string_view("abcdef")), 3) << "no more than the simulator has room for";
  line.done();
  EXPECT_EQ(hear(sim), packet(1, 0, "abc"));
  say(sim, packet(2, 0, "xy"));
  ASSERT_TRUE(line.wait(ending));
  std::array<char, 8> text{};
  EXPECT_EQ(line.read(text), 2);
  EXPECT_LT(line.read(text), 0) << "nothing more, and the line is there";
  ::close(sim);
  sim = -1;
  EXPECT_FALSE(line.wait(ending));
  EXPECT_EQ(line.read(text), 0) << "the line is gone";
  EXPECT_STREQ(line.open(), "the simulator has gone away");
}

TEST_F(StepLineTest, TheCoreLetsGoOfASimulatorThatHangsOrTalksNonsense) {
  for (const std::string& bad : malformed(2, 0)) {
    bus::StepLine line(path);
    accept(line);
    say(sim, packet(1, 0, ""));
    ASSERT_TRUE(line.wait(ending));
    say(sim, bad);
    EXPECT_FALSE(line.wait(ending)) << bad.size();
    EXPECT_FALSE(line.coupled());
  }
  bus::StepLine line(path, 40);
  accept(line);
  say(sim, packet(1, 0, ""));
  ASSERT_TRUE(line.wait(ending));
  EXPECT_FALSE(line.wait(ending)) << "it goes on by the steady clock";
  EXPECT_STREQ(line.open(), "the simulator does not answer");
}

}  // namespace
}  // namespace hoist::sim
