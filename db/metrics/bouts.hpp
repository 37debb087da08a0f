// Bouts of walking: more than 0.05 m/s for a second or longer.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "db/metrics/smoothness.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

inline constexpr double kBout_s = 1.0;

struct BoutTotals {
  int count = 0;
  /// How often walking was interrupted for kBout_s or longer. Steps that are not recorded count as interruption, too.
  int pauses = 0;
  std::uint64_t samples = 0;  ///< of all bouts
  double walked_m_s = 0;      ///< sum of the speeds' sizes over these samples
  /// The speeds of the longest bout, of two equally long ones of the first; empty for none. Of one that is longer than kSmoothMost_s, which no
  /// figure takes, the first sample beyond it is the last one here.
  std::vector<double> longest_m_s;
};

class BoutFinder {
 public:
  /// The next sample that counts.
  void add(const WalkSample& sample);
  /// After the last sample.
  [[nodiscard]] BoutTotals end();

 private:
  void close();
  FastRun run_;
  BoutTotals out_;
  std::uint64_t longest_ = 0;  // samples
  std::optional<std::uint64_t> bout_end_tick_;
  // The run under way.
  std::uint64_t begin_tick_ = 0, tick_ = 0, count_ = 0;
  std::vector<double> speed_m_s_;
};

}  // namespace hoist::db
