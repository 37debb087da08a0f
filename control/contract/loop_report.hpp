// How punctual the control loop is, in full: more than fits the record of a step. Written once a second, read on request.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace hoist::contract {

/// Four buckets to the octave: below 1.024 us, then up to 15 s. Fixed, so that two machines and two years compare.
inline constexpr std::size_t kLatenessBuckets = 96;
inline constexpr unsigned kLatenessFirstBit = 10;  // 2^10 ns: shorter times share the first bucket

[[nodiscard]] constexpr std::size_t lateness_bucket(std::uint64_t lateness_ns) noexcept {
  const auto bits = static_cast<unsigned>(std::bit_width(lateness_ns));
  if (bits <= kLatenessFirstBit) return 0;
  const unsigned octave = bits - 1 - kLatenessFirstBit;
  const std::size_t bucket = 1 + octave * std::size_t{4} + ((lateness_ns >> (bits - 3)) & 3U);
  return bucket < kLatenessBuckets ? bucket : kLatenessBuckets - 1;
}
/// Where a bucket ends, ns; its values are below. The last one has no end: this is where it would be.
[[nodiscard]] constexpr std::uint64_t lateness_bucket_end_ns(std::size_t bucket) noexcept {
  if (bucket == 0) return std::uint64_t{1} << kLatenessFirstBit;
  const std::size_t octave = (bucket - 1) / 4, quarter = (bucket - 1) % 4;
  return (std::uint64_t{5} + quarter) << (kLatenessFirstBit - 2 + octave);
}

struct LoopReport {
  std::uint64_t steps = 0;                               // since the start
  std::array<std::uint64_t, kLatenessBuckets> ever{};    // since the start
  std::array<std::uint64_t, kLatenessBuckets> lately{};  // the last ten seconds
  std::uint64_t latest_ever_ns = 0;
  std::uint64_t longest_step_ns = 0;  // since the start
};

}  // namespace hoist::contract
