// Speed of the motor's shaft from the encoder, once per millisecond, better than the difference of positions: at 2.5 rad/s that difference
// is 0 or 3.1 rad/s, which makes the servo audible.
//
// The counts of a tick give the distance within one count; the time between the last two edges gives the speed. The estimate is the speed
// from the edge time, limited to one count around the plain difference. Without a timer it is the plain difference. Without an edge the
// speed is at most one count per time without edges, which brings a stopping or a dead encoder down to zero at once.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/core/law/odometry.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

class SpeedEstimate {
 public:
  static constexpr std::size_t kLinePeriod = 4;    // edges of one encoder line: over a line period unequal spacing cancels
  static constexpr std::int32_t kCountedFrom = 4;  // so many counts in a tick (13 rad/s) say more than the time between two of them
  static constexpr std::uint32_t kIntervalMax_us = 1'000'000;  // longer intervals count as this: 0.003 rad/s
  static constexpr std::uint32_t kQuietMax_ms = 10'000;        // where the time without edges stops counting

  /// Begins at this position, at rest.
  void restart(std::int32_t position_counts) {
    *this = {};
    position_counts_ = position_counts;
  }

  /// One tick of 1 ms. Returns counts per millisecond, positive forward. edge_time_us as DriveBoard::edge_time_us().
  float step(std::int32_t position_counts, std::uint32_t edge_time_us) {
    const std::int32_t moved = law::delta32(position_counts, position_counts_);
    position_counts_ = position_counts;
    if (moved == 0) {
      if (quiet_ms_ < kQuietMax_ms) ++quiet_ms_;
      if (edges_ == 0) speed_ = 0;  // no edge time and no count
      const float most = 1.0F / static_cast<float>(quiet_ms_);
      if (speed_ > most) speed_ = most;
      if (speed_ < -most) speed_ = -most;
      return speed_;
    }
    const bool forward = moved > 0;
    const std::int32_t size = forward ? moved : -moved;
    if (forward != forward_) edges_ = 0;
    forward_ = forward;
    const float counted = static_cast<float>(size);
    float magnitude = counted;
    if (size < kCountedFrom && edge_time_us != kEdgeTimeUnknown_us && edge_time_us != 0) {
      note(edge_time_us, size);
      const float timed = 1000.0F * static_cast<float>(edges_) / static_cast<float>(sum_us());
      const float low = counted - 1.0F, high = counted + 1.0F;
      magnitude = timed < low ? low : (timed > high ? high : timed);
    } else {
      edges_ = 0;
    }
    quiet_ms_ = 0;
    speed_ = forward ? magnitude : -magnitude;
    return speed_;
  }

 private:
  // Keeps up to one line period of intervals while every edge is seen and the speed is steady: after a standstill, or in a quick start,
  // older intervals are invalid.
  void note(std::uint32_t edge_time_us, std::int32_t size) {
    if (size > 1) edges_ = 0;
    if (edges_ > 0) {
      const std::uint32_t last_us = times_us_[edges_ - 1];
      if (edge_time_us > 2 * last_us || last_us > 2 * edge_time_us) edges_ = 0;
    }
    if (edges_ == kLinePeriod) {
      for (std::size_t i = 1; i < kLinePeriod; ++i) times_us_[i - 1] = times_us_[i];
      --edges_;
    }
    times_us_[edges_++] = edge_time_us < kIntervalMax_us ? edge_time_us : kIntervalMax_us;
  }
  [[nodiscard]] std::uint32_t sum_us() const {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < edges_; ++i) sum += times_us_[i];
    return sum;
  }

  std::int32_t position_counts_ = 0;
  std::uint32_t quiet_ms_ = 0;
  float speed_ = 0;  // counts per millisecond
  bool forward_ = true;
  std::size_t edges_ = 0;
  std::array<std::uint32_t, kLinePeriod> times_us_{};
};

}  // namespace hoist::firmware
