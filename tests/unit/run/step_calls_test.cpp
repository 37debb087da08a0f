// System calls of a step of hoist-control: one sleep, one read and one write of the bus, and no allocation. The unmodified program runs on
// a pseudo-terminal. Its control thread is traced, and its sleeps are made to end at once, so that the steps take no real time.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/can_frame.hpp"
#include "control/contract/slcan_codec.hpp"
#include "control/publish/server_link.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::run {
namespace {

constexpr int kSettleSteps = 500, kSteps = 1000;
constexpr int kPatience_ms = 20'000;  // only a hung program takes so long

// A pseudo-terminal whose far end is an adapter: it accepts every line, and any frames may arrive.
class Adapter {
 public:
  Adapter() : far_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (::grantpt(far_) != 0 || ::unlockpt(far_) != 0) return;
    device_ = ::ptsname(far_);
    near_ = ::open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios raw{};
    ::tcgetattr(near_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(near_, TCSANOW, &raw);
  }
  ~Adapter() {
    ::close(near_);
    ::close(far_);
  }
  Adapter(const Adapter&) = delete;
  Adapter& operator=(const Adapter&) = delete;
  [[nodiscard]] const std::string& device() const { return device_; }

  // Reads the `written` characters of the core's last step, and what it wrote before it was traced, and answers. Returns when the answer
  // can be read, because the kernel delivers characters of a pseudo-terminal asynchronously.
  void serve(std::size_t written) {
    std::string answer;
    std::array<char, 4096> text{};
    while (wait_for(far_, written > 0 ? kPatience_ms : 0)) {
      const ssize_t got = ::read(far_, text.data(), text.size());
      if (got <= 0) continue;
      written -= std::min(written, static_cast<std::size_t>(got));
      for (ssize_t i = 0; i < got; ++i)
        if (text[static_cast<std::size_t>(i)] == contract::kSlcanOk) answer.push_back(contract::kSlcanOk);
    }
    if (answer.empty()) return;
    for (int i = 0; i < 8; ++i) {
      const std::size_t length = contract::slcan_encode(any_frame(), text);
      answer.append(text.data(), length);
    }
    ASSERT_EQ(::write(far_, answer.data(), answer.size()), static_cast<ssize_t>(answer.size()));
    for (int ready = 0; ready < static_cast<int>(answer.size()); ::sched_yield())
      if (!wait_for(near_, kPatience_ms) || ::ioctl(near_, TIOCINQ, &ready) != 0) return;
  }

 private:
  static bool wait_for(int fd, int patience_ms) {
    pollfd wait{fd, POLLIN, 0};
    return ::poll(&wait, 1, patience_ms) == 1;
  }
  contract::CanFrame any_frame() {
    constexpr std::array<std::uint32_t, 8> kIds{0x181, 0x182, 0x191, 0x192, 0x193, 0x701, 0x711, 0x581};
    contract::CanFrame frame;
    frame.id = kIds[next() % kIds.size()];
    frame.dlc = 8;
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(next());
    return frame;
  }
  std::uint32_t next() { return (seed_ = seed_ * 1664525U + 1013904223U) >> 8; }

  int far_, near_ = -1;
  std::string device_;
  std::uint32_t seed_ = 7;
};

// hoist-control in its own folder.
class Program {
 public:
  explicit Program(const std::string& device) {
    const std::string bus = "slcan:" + device, socket = this->socket();
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int nowhere = ::open("/dev/null", O_RDWR);
    for (int fd = 0; fd < 3; ++fd) ::dup2(nowhere, fd);
    ::execl(HOIST_CONTROL, HOIST_CONTROL, "--bus", bus.c_str(), "--socket", socket.c_str(), nullptr);
    ::_exit(127);
  }
  ~Program() {
    ::kill(pid_, SIGKILL);
    // A traced thread must be waited for separately, before the others.
    for (pid_t ended = 0; ended != pid_ && ended >= 0;) ended = ::waitpid(-1, nullptr, __WALL);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  [[nodiscard]] std::string socket() const { return folder_ / "core.sock"; }
  // The number of its thread of this name, which is waited for; 0 when none comes.
  [[nodiscard]] pid_t thread(const std::string& name) const {
    for (int i = 0; i < kPatience_ms; ++i, ::poll(nullptr, 0, 1)) {
      std::error_code gone;
      for (const auto& task : std::filesystem::directory_iterator(tasks(), gone)) {
        std::string comm;
        std::getline(std::ifstream(task.path() / "comm"), comm);
        if (comm == name) return std::stoi(task.path().filename());
      }
    }
    return 0;
  }
  [[nodiscard]] std::uint64_t page_faults(pid_t thread) const {
    std::string line;
    std::getline(std::ifstream(tasks() / std::to_string(thread) / "stat"), line);
    unsigned long long minor = 0, major = 0;
    EXPECT_EQ(std::sscanf(line.c_str() + line.rfind(')') + 1, " %*c %*d %*d %*d %*d %*d %*u %llu %*u %llu", &minor, &major), 2);
    return minor + major;
  }

 private:
  [[nodiscard]] std::filesystem::path tasks() const { return "/proc/" + std::to_string(pid_) + "/task"; }
  test::TemporaryFolder folder_;
  pid_t pid_ = -1;
};

// A thread that stops at each system call.
class Traced {
 public:
  struct Call {
    bool enters = false;
    std::uint64_t number = 0;
    std::array<std::uint64_t, 6> arguments{};
    std::int64_t result = 0;
  };
  // `refused`: the kernel does not let this program trace.
  Traced(pid_t thread, bool& refused) : thread_(thread) {
    refused = trace(PTRACE_SEIZE, 0, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL) != 0;
    if (!refused) trace(PTRACE_INTERRUPT, 0, 0);
  }
  // The next start or end of a call; empty when the thread has ended.
  std::optional<Call> next() {
    for (;;) {
      int status = 0;
      if (::waitpid(thread_, &status, __WALL) != thread_ || !WIFSTOPPED(status)) return std::nullopt;
      if (WSTOPSIG(status) == (SIGTRAP | 0x80)) break;
      const int signal = status >> 16 == 0 ? WSTOPSIG(status) : 0;
      trace(PTRACE_SYSCALL, 0, static_cast<std::uint64_t>(signal));
    }
    __ptrace_syscall_info info{};
    if (trace(PTRACE_GET_SYSCALL_INFO, sizeof info, reinterpret_cast<std::uintptr_t>(&info)) <= 0) return std::nullopt;
    Call call;
    call.enters = info.op == PTRACE_SYSCALL_INFO_ENTRY;
    if (call.enters) {
      number_ = info.entry.nr;
      std::copy(std::begin(info.entry.args), std::end(info.entry.args), call.arguments.begin());
    } else {
      call.result = info.exit.rval;
    }
    call.number = number_;
    return call;
  }
  void go_on() const { trace(PTRACE_SYSCALL, 0, 0); }
  // An absolute sleep ends at once when it is to end at 0.
  void end_sleep(const Call& sleep) const {
    for (std::size_t word = 0; word < 2; ++word) trace(PTRACE_POKEDATA, sleep.arguments[2] + word * sizeof(long), 0);
  }

 private:
  long trace(__ptrace_request request, std::uint64_t address, std::uint64_t data) const {
    return ::ptrace(request, thread_, reinterpret_cast<void*>(address), reinterpret_cast<void*>(data));
  }

  pid_t thread_;
  std::uint64_t number_ = 0;
};

TEST(Step, AsksTheKernelForOneSleepOneReadAndOneWriteAndForNoMemory) {
  Adapter adapter;
  ASSERT_FALSE(adapter.device().empty()) << "no pseudo-terminal";
  const Program program(adapter.device());
  const pid_t control = program.thread("control");
  ASSERT_NE(control, 0) << "hoist-control has no control thread";
  bool refused = false;
  Traced thread(control, refused);
  if (refused) GTEST_SKIP() << "this program may not trace another one";
  publish::ServerLink server(program.socket());

  // Without a clock that is read in user space (vDSO), reading it is a call, too.
  const std::vector<std::uint64_t> expected{SYS_read, SYS_write};
  std::vector<std::uint64_t> calls;
  std::size_t written = 0;
  int steps = 0, others = 0;
  std::uint64_t faults_before = 0;
  while (steps < kSettleSteps + kSteps) {
    const auto call = thread.next();
    ASSERT_TRUE(call) << "hoist-control ended";
    if (!call->enters && call->number == SYS_write && call->result > 0) written += static_cast<std::size_t>(call->result);
    if (call->enters && call->number == SYS_clock_nanosleep) {
      if (steps > kSettleSteps && calls != expected && ++others < 5)
        ADD_FAILURE() << "step " << steps << " made " << calls.size() + 1 << " calls, the sleep and " << ::testing::PrintToString(calls);
      if (steps == kSettleSteps) faults_before = program.page_faults(control);
      calls.clear();
      adapter.serve(written);
      written = 0;
      if (server.poll_connect()) {
        ++steps;
        server.beat();
        contract::Command command;
        command.kind = static_cast<contract::CommandKind>(steps % 11);
        server.send(command);
      }
      thread.end_sleep(*call);
    } else if (call->enters && call->number != SYS_clock_gettime) {
      calls.push_back(call->number);
    }
    thread.go_on();
  }
  ASSERT_TRUE(thread.next());
  EXPECT_EQ(others, 0);
  EXPECT_EQ(program.page_faults(control) - faults_before, 0U) << "page faults in " << kSteps << " steps";
  contract::TickRecord record;
  ASSERT_TRUE(server.newest(record));
  EXPECT_EQ(record.allocations, 0U) << "requests to the heap since the first step";
  EXPECT_GT(record.bus_frames, static_cast<std::uint32_t>(kSteps)) << "frames have arrived in each step";
}

}  // namespace
}  // namespace hoist::run
