// What threads request of the operating system, and what was granted.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace hoist::run {

enum class ThreadId : std::uint8_t {
#define HOIST_THREAD(name, fifo, own_cpu, why) name,
#include "control/run/threads.def"
#undef HOIST_THREAD
};
struct ThreadRow {
  std::string_view name;
  std::uint8_t fifo;
  bool own_cpu;
};
inline constexpr ThreadRow kThreads[] = {
#define HOIST_THREAD(name, fifo, own_cpu, why) ThreadRow{#name, fifo, (own_cpu) != 0},
#include "control/run/threads.def"
#undef HOIST_THREAD
};
[[nodiscard]] constexpr const ThreadRow& row_of(ThreadId thread) { return kThreads[static_cast<std::size_t>(thread)]; }

inline constexpr std::uint8_t kNoCpu = 255;

/// The core for the steps. `wish`: "none", a number, or "auto": the first isolated one (isolcpus), else the last of several that this
/// program may use, else none. Empty for an invalid wish; `error` says why. `isolated` is the text of /sys/devices/system/cpu/isolated,
/// `allowed` the cores that this program may use, as bits.
[[nodiscard]] std::optional<std::uint8_t> choose_cpu(std::string_view wish, std::string_view isolated, std::uint64_t allowed,
                                                     std::string& error);
/// The two inputs of choose_cpu for this computer.
[[nodiscard]] std::string isolated_cpus();
[[nodiscard]] std::uint64_t allowed_cpus();

/// What one thread got.
struct Granted {
  std::uint8_t priority = 0;  // under SCHED_FIFO; 0: ordinary
  std::uint8_t cpu = kNoCpu;
  std::string problem;  // what was refused, for people; empty when the whole row was granted
};
/// Called by a thread at its beginning: takes its name and, when `real_time`, its row of threads.def. A thread with an ordinary row gives
/// up an inherited priority (a service manager may start the whole program with real-time priority).
[[nodiscard]] Granted take_row(ThreadId thread, bool real_time, std::uint8_t cpu);

/// Touches `bytes` of this thread's stack, so that it causes no later page fault.
void touch_stack();
/// Locks present and future memory. Empty on success, otherwise the reason.
[[nodiscard]] std::string lock_memory();

/// Page faults of a thread of this process so far, minor and major, from its line in /proc; empty when unreadable.
[[nodiscard]] std::optional<std::uint64_t> page_faults_of(int thread);

}  // namespace hoist::run
