#include "control/run/threads.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <ctime>
#include <iostream>

#include "control/run/heap_watch.hpp"
#include "control/run/pacer.hpp"

namespace hoist::run {
namespace {

// From 0.65 m/s at 0.5 m/s2 takes 1.3 s; then the program ends even if something still turns.
constexpr std::uint64_t kStopWithin_ns = 3'000'000'000;

}  // namespace

void control_thread(ControlLoop& loop, StepClock& clock, LoopThread& shared, const ThreadWishes& wishes,
                    const std::atomic<bool>& stop_requested) {
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // without it an ordinary thread wakes 50 us late (measured)
  touch_stack();
  shared.granted = take_row(ThreadId::control, wishes.real_time, wishes.cpu);
  shared.id = ::gettid();
  loop.set_granted(shared.granted.priority, shared.granted.cpu, wishes.memory_locked);
  shared.ready.store(true);
  std::uint64_t stop_since_ns = 0;  // 0: not stopping
  const std::uint64_t heap_at_start = heap_requests();
  for (;;) {
    ControlLoop::Step step;
    clock.begin(step, stop_requested);
    step.stop = stop_since_ns == 0 && stop_requested.load(std::memory_order_relaxed);
    if (step.stop) stop_since_ns = step.time_ns;
    loop.note_allocations(static_cast<std::uint32_t>(heap_requests() - heap_at_start));
    loop.step(step);
    clock.end();
    shared.steps.store(shared.steps.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (stop_since_ns != 0 && (loop.standing_still() || step.time_ns - stop_since_ns > kStopWithin_ns)) break;
  }
  shared.ended.store(true);
}

void watchdog_thread(LoopThread& shared, Notifier& notifier, bool real_time) {
  static_cast<void>(take_row(ThreadId::watchdog, real_time, kNoCpu));
  const timespec pause{0, static_cast<long>(notifier.period_ns())};
  while (!shared.ended.load()) {
    ::clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
    notifier.look(shared.steps.load(std::memory_order_relaxed));
  }
  notifier.tell("STOPPING=1");
}

void store_thread(publish::CoreLink& link, LoopThread& shared, ParameterStore store, bool real_time) {
  static_cast<void>(take_row(ThreadId::store, real_time, kNoCpu));
  constexpr timespec kLook{0, 50'000'000};
  std::string told;
  std::uint64_t stored = 0;  // sequence that needs no further look
  for (bool last = false;; ::clock_nanosleep(CLOCK_MONOTONIC, 0, &kLook, nullptr)) {
    last = shared.ended.load();
    if (!last && link.params_sequence() == stored) continue;
    contract::ParamsInForce in_force;
    if (const std::uint64_t sequence = link.params(in_force); sequence != 0) {
      const contract::StoreReport& report = store.look(in_force, sequence, steady_ns());
      link.publish_store(report);
      stored = report.stored;
    }
    if (store.problem() != told) {
      told = store.problem();
      std::cerr << "hoist-control: " << (told.empty() ? "parameters are stored again" : "parameters not stored: " + told) << std::endl;
    }
    if (last) return;
  }
}

}  // namespace hoist::run
