// The threads of hoist-control beside its main thread (threads.def), and what they share.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "control/publish/core_link.hpp"
#include "control/run/control_loop.hpp"
#include "control/run/parameter_file.hpp"
#include "control/run/real_time.hpp"
#include "control/run/step_clock.hpp"
#include "control/run/watchdog.hpp"

namespace hoist::run {

/// What the control thread shares with the others.
struct LoopThread {
  std::atomic<bool> ready{false};  // `granted` and `id` are filled
  std::atomic<std::uint64_t> steps{0};
  std::atomic<bool> ended{false};
  Granted granted;
  int id = 0;
};

struct ThreadWishes {
  bool real_time = true;
  std::uint8_t cpu = kNoCpu;
  bool memory_locked = false;
};

/// Sleeps until an absolute time, runs one step, sleeps again: one sleep and the bus are its only system calls. After `stop_requested` it
/// stops the hoist and ends at standstill.
void control_thread(ControlLoop& loop, StepClock& clock, LoopThread& shared, const ThreadWishes& wishes,
                    const std::atomic<bool>& stop_requested);
/// Feeds the service manager's watchdog while steps continue.
void watchdog_thread(LoopThread& shared, Notifier& notifier, bool real_time);
/// Stores changed parameters and publishes the stored sequence for the server. A change waits at most one poll; the last poll comes after
/// the last step.
void store_thread(publish::CoreLink& link, LoopThread& shared, ParameterStore store, bool real_time);

}  // namespace hoist::run
