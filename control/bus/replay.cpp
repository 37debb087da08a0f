#include "control/bus/replay.hpp"

namespace hoist::bus {

using contract::CanFrame;

std::size_t ReplayPort::receive(std::span<CanFrame> out, std::uint64_t now_ns) noexcept {
  if (!begun_) {
    begun_ = true;
    due_ns_ = now_ns;
  }
  std::size_t count = 0;
  while (next_ < entries_.size() && due_ns_ <= now_ns) {
    const LogEntry& entry = entries_[next_];
    if (entry.direction != Direction::sent && (entry.frame.flags & CanFrame::kError) == 0) {
      if (count < out.size()) {
        out[count++] = entry.frame;
        ++counters_.received;
      } else {
        ++counters_.refused;
      }
    }
    if (++next_ == entries_.size()) {
      problem_ = "the recording is over";
      break;
    }
    if (entries_[next_].time_us > entry.time_us) due_ns_ += (entries_[next_].time_us - entry.time_us) * 1000U;
  }
  return count;
}

std::size_t ReplayPort::send(std::span<const CanFrame> frames, std::uint64_t) noexcept {
  if (!up()) {
    counters_.send_refused += static_cast<std::uint32_t>(frames.size());
    return 0;
  }
  counters_.sent += static_cast<std::uint32_t>(frames.size());
  return frames.size();
}

}  // namespace hoist::bus
