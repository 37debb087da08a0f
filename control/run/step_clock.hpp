// When the steps of the control thread begin, and at what time: by this computer's steady clock, or in lock-step with the simulator.
#pragma once
#include <atomic>
#include <cstdint>

#include "control/bus/step_line.hpp"
#include "control/run/control_loop.hpp"
#include "control/run/pacer.hpp"

namespace hoist::run {

/// This computer's steady clock.
[[nodiscard]] std::uint64_t steady_ns() noexcept;

class StepClock {
 public:
  virtual ~StepClock() = default;
  /// Waits until the next step is due and fills its number, times and lateness. `ending`: the program is to end soon.
  virtual void begin(ControlLoop::Step& step, const std::atomic<bool>& ending) noexcept = 0;
  /// The step is over.
  virtual void end() noexcept = 0;
};

/// The clock of every real hoist: steps on a grid of 10 ms, with their lateness (H22).
class SteadyClock final : public StepClock {
 public:
  void begin(ControlLoop::Step& step, const std::atomic<bool>& ending) noexcept override;
  void end() noexcept override;

 private:
  Pacer pacer_{0};  // begins with the first step
  std::uint64_t begun_ns_ = 0, duration_ns_ = 0;
};

/// The simulator's clock: 10 ms per step, never late, because simulated time waits for the core. It starts at the steady clock, so that it
/// still rises after a restart of this program.
class SimulatorClock final : public StepClock {
 public:
  SimulatorClock(bus::StepLine& line, std::uint64_t start_ns) : line_(line), time_ns_(start_ns) {}
  void begin(ControlLoop::Step& step, const std::atomic<bool>& ending) noexcept override;
  void end() noexcept override { line_.done(); }

 private:
  bus::StepLine& line_;
  std::uint64_t time_ns_, tick_ = 0;
};

}  // namespace hoist::run
