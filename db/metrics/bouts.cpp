#include "db/metrics/bouts.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace hoist::db {

namespace {
constexpr auto kBoutSamples = samples_in(kBout_s);
constexpr std::size_t kKeptSamples = samples_in(kSmoothMost_s) + 1;
}  // namespace

void BoutFinder::add(const WalkSample& sample) {
  const std::optional<std::size_t> place = run_.add(sample);
  if (!place || *place == 0) close();
  if (!place) return;
  if (count_++ == 0) begin_tick_ = sample.tick;
  tick_ = sample.tick;
  if (speed_m_s_.size() < kKeptSamples) speed_m_s_.push_back(sample.speed_m_s);
  if (count_ > kBoutSamples) out_.walked_m_s += std::fabs(sample.speed_m_s);
  if (count_ != kBoutSamples) return;
  // Only now the run is known to be a bout.
  ++out_.count;
  if (bout_end_tick_ && begin_tick_ - *bout_end_tick_ - 1 >= kBoutSamples) ++out_.pauses;
  for (const double speed_m_s : speed_m_s_) out_.walked_m_s += std::fabs(speed_m_s);
}

void BoutFinder::close() {
  if (count_ >= kBoutSamples) {
    out_.samples += count_;
    bout_end_tick_ = tick_;
    if (count_ > longest_) {
      longest_ = count_;
      out_.longest_m_s.swap(speed_m_s_);
    }
  }
  count_ = 0;
  speed_m_s_.clear();
}

BoutTotals BoutFinder::end() {
  close();
  return std::move(out_);
}

}  // namespace hoist::db
