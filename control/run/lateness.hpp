// How late the steps begin: counted in fixed buckets, since the start and over the last ten seconds.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/loop_report.hpp"

namespace hoist::run {

class Lateness {
 public:
  static constexpr std::size_t kSliceSteps = 100, kSlices = 10;

  /// One step: its lateness and the duration of the previous one. True once a second, when the figures below are new.
  bool add(std::uint64_t lateness_ns, std::uint64_t previous_step_ns) noexcept {
    const std::size_t bucket = contract::lateness_bucket(lateness_ns);
    Slice& slice = slices_[slice_];
    ++slice.counts[bucket];
    if (lateness_ns > slice.latest_ns) slice.latest_ns = lateness_ns;
    ++report_.steps;
    ++report_.ever[bucket];
    ++report_.lately[bucket];
    if (lateness_ns > report_.latest_ever_ns) report_.latest_ever_ns = lateness_ns;
    if (previous_step_ns > report_.longest_step_ns) report_.longest_step_ns = previous_step_ns;
    if (++in_slice_ < kSliceSteps) return false;
    summarise();
    in_slice_ = 0;
    slice_ = (slice_ + 1) % kSlices;
    for (std::size_t i = 0; i < contract::kLatenessBuckets; ++i) report_.lately[i] -= slices_[slice_].counts[i];
    slices_[slice_] = {};
    return true;
  }

  /// Of the last ten seconds, as of the last whole second: never too low, at most a quarter too high.
  [[nodiscard]] float p50_s() const noexcept { return p50_s_; }
  [[nodiscard]] float p99_s() const noexcept { return p99_s_; }
  /// Exact.
  [[nodiscard]] float max_s() const noexcept { return max_s_; }
  [[nodiscard]] const contract::LoopReport& report() const noexcept { return report_; }

 private:
  struct Slice {
    std::array<std::uint8_t, contract::kLatenessBuckets> counts{};
    std::uint64_t latest_ns = 0;
  };
  static_assert(kSliceSteps <= 255);

  void summarise() noexcept {
    std::uint64_t steps = 0, latest_ns = 0;
    for (const std::uint64_t count : report_.lately) steps += count;
    for (const Slice& slice : slices_)
      if (slice.latest_ns > latest_ns) latest_ns = slice.latest_ns;
    max_s_ = seconds(latest_ns);
    p50_s_ = quantile_s(steps - steps / 2, latest_ns);
    p99_s_ = quantile_s(steps - steps / 100, latest_ns);
  }
  /// The end of the bucket in which the `rank`-th earliest step lies, or the latest one if that is less.
  [[nodiscard]] float quantile_s(std::uint64_t rank, std::uint64_t latest_ns) const noexcept {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < contract::kLatenessBuckets; ++i) {
      below += report_.lately[i];
      if (below < rank) continue;
      const std::uint64_t end_ns = contract::lateness_bucket_end_ns(i);
      return seconds(end_ns < latest_ns ? end_ns : latest_ns);
    }
    return seconds(latest_ns);
  }
  [[nodiscard]] static float seconds(std::uint64_t ns) noexcept { return static_cast<float>(ns) * 1e-9F; }

  contract::LoopReport report_;
  std::array<Slice, kSlices> slices_{};
  std::size_t slice_ = 0, in_slice_ = 0;
  float p50_s_ = 0, p99_s_ = 0, max_s_ = 0;
};

}  // namespace hoist::run
