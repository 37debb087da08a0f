// One control step with its input and output: bus in, commands in, tick, bus out, publish. Everything but the waiting, so that the
// real-time thread, the allocation test and the benchmark run the same lines.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "control/bus/can_port.hpp"
#include "control/core/tick.hpp"
#include "control/publish/core_link.hpp"
#include "control/publish/step_publisher.hpp"
#include "control/run/lateness.hpp"

namespace hoist::run {

class ControlLoop {
 public:
  // `initial` was checked by the caller (load_params refuses otherwise and the defaults stay). `earlier`: stops of earlier runs (H22).
  ControlLoop(bus::CanPort& port, publish::CoreLink& link, const contract::Params& initial, const core::StopHistory& earlier = {});

  struct Step {
    std::uint64_t tick = 0;
    std::uint64_t time_ns = 0;
    std::uint64_t wake_lateness_ns = 0;
    std::uint64_t previous_duration_ns = 0;
    bool stop = false;  // the program is ending: once, as if STOP had been pressed
  };
  // Runs one step. No allocation, no exception, no system call but the port's.
  void step(const Step& step) noexcept;

  /// What the computer gave the thread that runs the steps. Set before the first one.
  void set_granted(std::uint8_t priority, std::uint8_t cpu, bool memory_locked) noexcept;
  /// Counted by another thread while the steps run.
  void note_page_faults(std::uint32_t since_settled) noexcept { page_faults_.store(since_settled, std::memory_order_relaxed); }
  /// Counted by the thread itself, before a step.
  void note_allocations(std::uint32_t since_first_step) noexcept { loop_.allocations = since_first_step; }

  /// The stop history to store, for another thread. False while unchanged since `seen`, the last number returned.
  [[nodiscard]] bool read_stops(core::StopHistory& history, std::uint64_t& seen) const noexcept;

  [[nodiscard]] bool standing_still() const noexcept { return outputs_.record.standing_still != 0; }
  [[nodiscard]] const contract::TickRecord& record() const noexcept { return outputs_.record; }

 private:
  void publish_params() noexcept;

  static constexpr std::size_t kFramesPerStep = 256;  // a full bus brings 23 frames per step; the rest is reserve after a delay
  bus::CanPort& port_;
  publish::CoreLink& link_;
  publish::StepPublisher publisher_;
  core::CoreState state_;
  core::TickOutputs outputs_;
  contract::SeqSlot<core::StopHistory> stops_{};
  std::uint64_t stops_written_ = 0;
  Lateness lateness_;
  core::LoopHealth loop_;
  std::atomic<std::uint32_t> page_faults_{0};
  std::array<contract::CanFrame, kFramesPerStep> frames_{};
  std::array<contract::Command, core::kCommandsPerTick> commands_{};
};

}  // namespace hoist::run
