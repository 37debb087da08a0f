// A recording as a bus: recorded received frames are received again in the same timing. Frames of the recorded computer are left out, and
// sent frames are discarded. For tools, and to run a core on recorded data; the recorded nodes do not answer, so no core starts driving.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "control/bus/can_port.hpp"
#include "control/bus/candump_log.hpp"

namespace hoist::bus {

class ReplayPort final : public CanPort {
 public:
  // A recorded time that steps backward (the clock was set) counts as no time.
  explicit ReplayPort(std::vector<LogEntry> entries) : entries_(std::move(entries)) {}

  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept override;
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept override;
  // Until the last frame was handed over.
  [[nodiscard]] bool up() const noexcept override { return next_ < entries_.size(); }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const char* problem() const noexcept override { return problem_.load(std::memory_order_relaxed); }

 private:
  std::vector<LogEntry> entries_;
  std::size_t next_ = 0;
  bool begun_ = false;
  std::uint64_t due_ns_ = 0;  // of the next frame
  PortCounters counters_;
  std::atomic<const char*> problem_{""};
};

}  // namespace hoist::bus
