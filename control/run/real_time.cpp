#include "control/run/real_time.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

namespace hoist::run {
namespace {

constexpr unsigned kCpuLimit = 64;  // of the bits in allowed_cpus()

/// A small kernel file; empty when unreadable.
std::string read_small(const char* path) {
  const int file = ::open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return {};
  std::array<char, 1024> text{};
  const ssize_t got = ::read(file, text.data(), text.size());
  ::close(file);
  return got > 0 ? std::string(text.data(), static_cast<std::size_t>(got)) : std::string();
}

std::optional<unsigned> number(std::string_view text) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end == text.data()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::uint8_t> choose_cpu(std::string_view wish, std::string_view isolated, std::uint64_t allowed, std::string& error) {
  if (wish == "none") return kNoCpu;
  const auto may = [allowed](unsigned cpu) { return cpu < kCpuLimit && ((allowed >> cpu) & 1U) != 0; };
  if (wish == "auto") {
    // "2-3,6": the first number is the first core.
    if (const auto first = number(isolated); first && may(*first)) return static_cast<std::uint8_t>(*first);
    if ((allowed & (allowed - 1)) == 0) return kNoCpu;  // a single core is shared
    unsigned last = kCpuLimit - 1;
    while (!may(last)) --last;
    return static_cast<std::uint8_t>(last);
  }
  const auto cpu = number(wish);
  if (!cpu || std::to_string(*cpu) != wish) {
    error = "auto, none or the number of a core, not '" + std::string(wish) + "'";
    return std::nullopt;
  }
  if (!may(*cpu)) {
    error = "this program may not use core " + std::string(wish);
    return std::nullopt;
  }
  return static_cast<std::uint8_t>(*cpu);
}

std::string isolated_cpus() { return read_small("/sys/devices/system/cpu/isolated"); }

std::uint64_t allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::uint64_t bits = 0;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) return bits;
  for (unsigned cpu = 0; cpu < kCpuLimit; ++cpu)
    if (CPU_ISSET(cpu, &set)) bits |= std::uint64_t{1} << cpu;
  return bits;
}

Granted take_row(ThreadId thread, bool real_time, std::uint8_t cpu) {
  const ThreadRow& row = row_of(thread);
  Granted granted;
  // The main thread's name is the program's, by which people find it.
  if (thread != ThreadId::main) ::pthread_setname_np(::pthread_self(), std::string(row.name).c_str());
  if (!real_time) return granted;
  sched_param priority{};
  priority.sched_priority = row.fifo;
  const int refused = ::pthread_setschedparam(::pthread_self(), row.fifo > 0 ? SCHED_FIFO : SCHED_OTHER, &priority);
  if (refused != 0)
    granted.problem = std::string("no real-time priority: ") + std::strerror(refused);
  else
    granted.priority = row.fifo;
  // Without a priority a bound thread would queue behind others on that core.
  if (!row.own_cpu || cpu == kNoCpu || granted.priority == 0) return granted;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  if (::pthread_setaffinity_np(::pthread_self(), sizeof set, &set) == 0)
    granted.cpu = cpu;
  else
    granted.problem = "not bound to core " + std::to_string(cpu);
  return granted;
}

void touch_stack() {
  constexpr std::size_t kBytes = std::size_t{128} * 1024, kPage = 4096;
  std::array<unsigned char, kBytes> stack;
  // Through a volatile pointer, so that the compiler keeps the writes.
  volatile unsigned char* page = stack.data();
  for (std::size_t i = 0; i < kBytes; i += kPage) page[i] = 0;
}

std::string lock_memory() {
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return std::strerror(errno);
  return {};
}

std::optional<std::uint64_t> page_faults_of(int thread) {
  const std::string line = read_small(("/proc/self/task/" + std::to_string(thread) + "/stat").c_str());
  // The second field, a name in brackets, may hold anything; the fields are counted behind its end. minflt is the 10th, majflt the 12th.
  const std::size_t bracket = line.rfind(')');
  if (bracket == std::string::npos) return std::nullopt;
  unsigned long long minor = 0, major = 0;
  if (std::sscanf(line.c_str() + bracket + 1, " %*c %*d %*d %*d %*d %*d %*u %llu %*u %llu", &minor, &major) != 2) return std::nullopt;
  return minor + major;
}

}  // namespace hoist::run
