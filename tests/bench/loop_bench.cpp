// Wake-up lateness of the running hoist-control beside a bare 100 Hz loop at the same priority, in the same seconds.
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "control/publish/server_link.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {
constexpr std::uint64_t kPeriodNs = 10'000'000;
std::uint64_t now_ns() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<std::uint64_t>(t.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(t.tv_nsec);
}
// The 20-line loop: sleeps to an absolute time, notes how late it woke, does nothing.
std::vector<double> bare_loop(double seconds, bool& real_time) {
  std::vector<double> late_us;
  late_us.reserve(static_cast<std::size_t>(seconds * 100) + 10);
  std::thread thread([&] {
    const sched_param priority{49};
    real_time = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority) == 0;
    ::prctl(PR_SET_TIMERSLACK, 1UL);
    std::uint64_t wake = now_ns() + kPeriodNs;
    const std::uint64_t end = wake + static_cast<std::uint64_t>(seconds * 1e9);
    while (wake < end) {
      const timespec until{static_cast<time_t>(wake / 1'000'000'000U), static_cast<long>(wake % 1'000'000'000U)};
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      const std::uint64_t woke = now_ns();
      late_us.push_back(static_cast<double>(woke - wake) * 1e-3);
      wake += kPeriodNs * (1 + (woke - wake) / kPeriodNs);
    }
  });
  thread.join();
  return late_us;
}
double percentile(std::vector<double>& values, double p) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}
}  // namespace

Rows measure_loop(const std::string& bin, double seconds) {
  const TemporaryFolder folder;
  const Process sim({bin + "/hoist-sim", "--scenario", "stand", "--pty-link", folder / "can", "--control", folder / "sim.sock"},
                    folder / "log");
  const Process control({bin + "/hoist-control", "--bus", "slcan:" + (folder / "can"), "--socket", folder / "core.sock"}, folder / "log");
  publish::ServerLink link(folder / "core.sock");
  for (int i = 0; i < 500 && !link.poll_connect(); ++i) ::poll(nullptr, 0, 10);
  if (!link.attached()) throw std::runtime_error("hoist-control did not come up: " + link.last_error());
  ::poll(nullptr, 0, 2000);  // let the nodes start

  publish::TickReader reader(link);
  std::vector<double> core_us, step_us;
  std::atomic<bool> done{false};
  std::thread collector([&] {
    std::vector<contract::TickRecord> records(256);
    for (;;) {
      const bool last = done.load();
      const auto got = reader.read(records);
      for (std::size_t i = 0; i < got.count; ++i) {
        core_us.push_back(static_cast<double>(records[i].wake_lateness_s) * 1e6);
        step_us.push_back(static_cast<double>(records[i].tick_duration_s) * 1e6);
      }
      if (last) return;
      ::poll(nullptr, 0, 500);
    }
  });
  bool real_time = false;
  const std::uint64_t cpu_before = control.cpu_ns();
  std::vector<double> bare_us = bare_loop(seconds, real_time);
  const std::uint64_t cpu_ns = control.cpu_ns() - cpu_before;
  done = true;
  collector.join();
  const std::string note = real_time ? "both SCHED_FIFO 49, the core bound to its processor core as shipped, idle machine, " +
                                           std::to_string(core_us.size()) + " wake-ups"
                                     : "no real-time priority here: both ordinary threads";
  const std::string bare = "bare 100 Hz loop, same seconds";
  return {{"control loop wake-up lateness, median", percentile(core_us, 0.5), "us", percentile(bare_us, 0.5), bare, 1.15, 0, false, note},
          {"control loop wake-up lateness, 99 %", percentile(core_us, 0.99), "us", percentile(bare_us, 0.99), bare, 1.3, 0, false, ""},
          {"control loop step, bus reading and writing included, median", percentile(step_us, 0.5), "us", 0, "", 0, 0, false,
           "SLCAN over a pty"},
          {"control program CPU per step", static_cast<double>(cpu_ns) * 1e-3 / std::max<double>(1.0, static_cast<double>(core_us.size())),
           "us", 0, "", 0, 0, false, "all threads"}};
}

}  // namespace hoist::bench
