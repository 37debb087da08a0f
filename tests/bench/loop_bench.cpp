// The running hoist-control beside two bare 100 Hz loops on the same processor core with the same priority, in the same seconds: one only
// sleeps, one also reads and writes as many bytes of a pseudo-terminal as the core's bus.
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "control/publish/server_link.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/bench/statistics.hpp"

namespace hoist::bench {
namespace {
constexpr std::uint64_t kPeriodNs = 10'000'000;
constexpr int kTurns = 8, kStepsPerTurn = 500;  // 40 s; the two bare loops swap their places behind the core's step each turn
constexpr std::size_t kSlcanBytes = 22;         // "tIIIL" + 16 digits + CR
constexpr std::uint8_t kNoCpu = 255;

std::uint64_t now_ns(clockid_t clock = CLOCK_MONOTONIC) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(t.tv_nsec);
}

// A pseudo-terminal whose far end answers each write with `answer` bytes, like the simulator on the core's bus.
class AnsweringTerminal {
 public:
  explicit AnsweringTerminal(std::size_t answer) : answer_(answer, 'T') {
    far_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (far_ < 0 || ::grantpt(far_) != 0 || ::unlockpt(far_) != 0) throw std::runtime_error("no pseudo-terminal");
    near_ = ::open(::ptsname(far_), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    termios raw{};
    if (near_ < 0 || ::tcgetattr(near_, &raw) != 0) throw std::runtime_error("cannot open the pseudo-terminal");
    ::cfmakeraw(&raw);
    ::tcsetattr(near_, TCSANOW, &raw);
    peer_ = std::thread([this] { serve(); });
  }
  ~AnsweringTerminal() {
    done_ = true;
    peer_.join();
    ::close(near_);
    ::close(far_);
  }
  AnsweringTerminal(const AnsweringTerminal&) = delete;
  AnsweringTerminal& operator=(const AnsweringTerminal&) = delete;
  [[nodiscard]] int fd() const { return near_; }

 private:
  void serve() {
    std::array<char, 4096> buffer;
    while (!done_) {
      pollfd wait{far_, POLLIN, 0};
      if (::poll(&wait, 1, 100) == 1 && ::read(far_, buffer.data(), buffer.size()) > 0 && ::write(far_, answer_.data(), answer_.size()) < 0)
        return;
    }
  }
  std::string answer_;
  int far_ = -1, near_ = -1;
  std::atomic<bool> done_{false};
  std::thread peer_;
};

struct BareLoop {
  int fd = -1;  // bus, or none
  std::size_t write_bytes = 0;
  std::vector<double> late_us = {};
  std::uint64_t cpu_ns = 0;
  std::uint64_t steps = 0;
  bool real_time = false;

  void turn(std::uint64_t first_wake_ns, std::uint8_t cpu) {
    const sched_param priority{49};
    real_time = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority) == 0;
    if (cpu != kNoCpu) {
      cpu_set_t set;
      CPU_ZERO(&set);
      CPU_SET(cpu, &set);
      ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set);
    }
    ::prctl(PR_SET_TIMERSLACK, 1UL);
    std::array<char, 4096> buffer;
    buffer.fill('t');
    const std::uint64_t cpu_before = now_ns(CLOCK_THREAD_CPUTIME_ID), end = first_wake_ns + kStepsPerTurn * kPeriodNs;
    for (std::uint64_t wake = first_wake_ns; wake < end; ++steps) {
      const timespec until{static_cast<time_t>(wake / 1'000'000'000U), static_cast<long>(wake % 1'000'000'000U)};
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      const std::uint64_t woke = now_ns();
      late_us.push_back(static_cast<double>(woke - wake) * 1e-3);
      if (fd >= 0 && ::read(fd, buffer.data(), buffer.size()) != 0) (void)!::write(fd, buffer.data(), write_bytes);
      wake += kPeriodNs * (1 + (woke - wake) / kPeriodNs);
    }
    cpu_ns += now_ns(CLOCK_THREAD_CPUTIME_ID) - cpu_before;
  }
  [[nodiscard]] double cpu_us_per_step() const { return static_cast<double>(cpu_ns) * 1e-3 / static_cast<double>(steps); }
};

// Bytes that the core reads and writes per step, from one second of its bus.
struct BusBytes {
  std::size_t read = 0, written = 0;
};
BusBytes bus_bytes_per_step(const publish::ServerLink& link) {
  publish::BusReader reader(link);
  std::vector<contract::BusRecord> frames(512);
  std::array<std::size_t, 2> count{};
  for (int i = 0; i < 20; ++i) {
    ::poll(nullptr, 0, 50);
    const auto got = reader.read(frames);
    for (std::size_t k = 0; k < got.count; ++k) ++count[frames[k].sent != 0 ? 1 : 0];
  }
  return {count[0] * kSlcanBytes / 100, std::max<std::size_t>(1, count[1] * kSlcanBytes / 100)};
}

struct CoreSteps {
  std::vector<double> late_us, step_us;
};
void collect(publish::TickReader& reader, const std::atomic<bool>& done, CoreSteps& steps) {
  std::vector<contract::TickRecord> records(256);
  for (bool last = false; !last; ::poll(nullptr, 0, last ? 0 : 500)) {
    last = done;
    const auto got = reader.read(records);
    for (std::size_t i = 0; i < got.count; ++i) {
      steps.late_us.push_back(static_cast<double>(records[i].wake_lateness_s) * 1e6);
      steps.step_us.push_back(static_cast<double>(records[i].tick_duration_s) * 1e6);
    }
  }
}

void run_turns(Report& report, const publish::ServerLink& link, BareLoop& plain, BareLoop& with_bus) {
  for (int turn = 0; turn < kTurns; ++turn) {
    report.progress("turn " + std::to_string(turn + 1) + " of " + std::to_string(kTurns) + ", 5 s each");
    contract::TickRecord newest{};
    if (!link.newest(newest)) throw std::runtime_error("hoist-control ended");
    const std::uint64_t third = kPeriodNs / 3, start = newest.time_ns + 5 * kPeriodNs;
    const bool swap = turn % 2 == 1;
    std::thread a([&] { plain.turn(start + (swap ? 2 : 1) * third, newest.loop_cpu); });
    std::thread b([&] { with_bus.turn(start + (swap ? 1 : 2) * third, newest.loop_cpu); });
    a.join();
    b.join();
  }
}
}  // namespace

void measure_loop(Report& report, const std::string& bin) {
  const RunningHoist hoist(bin, {.server = false});
  publish::ServerLink link(hoist.core_socket());
  for (int i = 0; i < 500 && !link.poll_connect(); ++i) ::poll(nullptr, 0, 10);
  if (!link.attached()) throw std::runtime_error("hoist-control did not come up: " + link.last_error());
  ::poll(nullptr, 0, 2000);  // let the nodes start
  const BusBytes bytes = bus_bytes_per_step(link);
  const AnsweringTerminal terminal(bytes.read);
  BareLoop plain, with_bus{terminal.fd(), bytes.written};

  publish::TickReader reader(link);
  CoreSteps core;
  std::atomic<bool> done{false};
  std::thread collector([&] { collect(reader, done, core); });
  const std::uint64_t cpu_before = hoist.control().cpu_ns();
  std::string problem;
  try {
    run_turns(report, link, plain, with_bus);
  } catch (const std::exception& failure) {
    problem = failure.what();
  }
  const double cpu_us = static_cast<double>(hoist.control().cpu_ns() - cpu_before) * 1e-3;
  done = true;
  collector.join();
  if (!problem.empty() || core.late_us.empty()) throw std::runtime_error("no steps were measured: " + problem);

  const double step_cpu_us = cpu_us / static_cast<double>(core.late_us.size());
  const std::string note = plain.real_time ? "all SCHED_FIFO 49 on the same processor core" : "no real-time priority: ordinary threads";
  const std::string bus = "bare loop with " + std::to_string(bytes.read) + " B read, " + std::to_string(bytes.written) + " B written";
  report.add({"loop.p50", "wake-up lateness, median", median(core.late_us), "us", median(plain.late_us), "bare loop", {1.15}, false, note});
  report.add(
      {"loop.p99", "wake-up lateness, 99 %", percentile(core.late_us, 0.99), "us", percentile(plain.late_us, 0.99), "bare loop", {1.3}});
  report.add({"loop.cpu", "CPU of hoist-control per step, all threads", step_cpu_us, "us", plain.cpu_us_per_step(), "bare loop", {2}});
  report.add({"loop.cpu_bus", "CPU of hoist-control per step, all threads", step_cpu_us, "us", with_bus.cpu_us_per_step(), bus});
  report.add({"loop.step", "step, bus reading and writing included, median", median(core.step_us), "us", 0, ""});
}

}  // namespace hoist::bench
