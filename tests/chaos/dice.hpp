// Random numbers of a seed. Distributions of the standard library differ between implementations, and a seed must give the same session everywhere.
#pragma once
#include <cstdint>

namespace hoist::chaos {

// splitmix64. Streams of one seed are independent: leaving a fault out changes only that fault.
class Dice {
 public:
  explicit Dice(std::uint64_t seed, std::uint64_t stream = 0) : state_(seed) { state_ = next() ^ (stream * 0xD1B54A32D192ED03ULL); }
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  double norm() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double between(double low, double high) { return low + (high - low) * norm(); }
  int below(int limit) { return static_cast<int>(next() % static_cast<std::uint64_t>(limit)); }
  bool chance(double share) { return norm() < share; }

 private:
  std::uint64_t state_;
};

}  // namespace hoist::chaos
