#include "control/run/step_clock.hpp"

#include <cerrno>
#include <ctime>

namespace hoist::run {
namespace {
static_assert(kPeriodNs == contract::kStepPeriod_ns);
}

std::uint64_t steady_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}

void SteadyClock::begin(ControlLoop::Step& step, const std::atomic<bool>& /*ending*/) noexcept {
  if (begun_ns_ == 0) pacer_ = Pacer(steady_ns() + kPeriodNs);
  const std::uint64_t wake_ns = pacer_.wake_ns();
  const timespec until{static_cast<time_t>(wake_ns / 1'000'000'000U), static_cast<long>(wake_ns % 1'000'000'000U)};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  begun_ns_ = steady_ns();
  step.tick = pacer_.tick();
  step.time_ns = begun_ns_;
  step.wake_lateness_ns = pacer_.begin(begun_ns_);
  step.previous_duration_ns = duration_ns_;
}

void SteadyClock::end() noexcept {
  const std::uint64_t now_ns = steady_ns();
  duration_ns_ = now_ns - begun_ns_;
  pacer_.end(now_ns);
}

void SimulatorClock::begin(ControlLoop::Step& step, const std::atomic<bool>& ending) noexcept {
  static_cast<void>(line_.wait(ending));
  time_ns_ += kPeriodNs;
  step.tick = tick_++;
  step.time_ns = time_ns_;
}

}  // namespace hoist::run
