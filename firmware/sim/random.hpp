// Random numbers of the simulator: the same on every machine and compiler for the same seed, unlike <random>'s distributions.
#pragma once

#include <cstdint>

namespace hoist::sim {

/// xorshift64* seeded through splitmix64, so that neighbouring seeds give unrelated streams.
class Random {
 public:
  explicit Random(std::uint64_t seed) {
    std::uint64_t z = seed + 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    state_ = z ^ (z >> 31);
    if (state_ == 0) state_ = 1;  // the one state that xorshift never leaves
  }

  std::uint64_t next() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return state_ * 0x2545F4914F6CDD1DULL;
  }

  /// Evenly spread in [low, high).
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(next() >> 11) * 0x1.0p-53; }

  /// Mean 0, standard deviation 1, never beyond 3.5: the sum of four uniform numbers. Bounded, so that noise alone cannot trip a monitor.
  double normal() {
    const std::uint64_t bits = next();
    const auto sum = static_cast<double>((bits & 0xFFFF) + ((bits >> 16) & 0xFFFF) + ((bits >> 32) & 0xFFFF) + (bits >> 48));
    constexpr double kMean = 4.0 * 65535.0 / 2.0;
    constexpr double kDeviation = 65536.0 * 0.57735026918962576;  // four variances of 65536^2 / 12 each
    return (sum - kMean) / kDeviation;
  }

 private:
  std::uint64_t state_;
};

}  // namespace hoist::sim
