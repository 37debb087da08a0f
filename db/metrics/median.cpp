#include "db/metrics/median.hpp"

#include <algorithm>
#include <bit>

namespace hoist::db {

namespace {
constexpr std::uint64_t kSign = std::uint64_t{1} << 63U;
// Whole numbers in the order of the numbers that they stand for.
std::uint64_t key_of(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  return (bits & kSign) != 0 ? ~bits : bits | kSign;
}
}  // namespace

void MedianSearch::add(double value) {
  if (pass_ == kPasses) return;
  const std::uint64_t key = key_of(value);
  const unsigned low = 64 - kBits * (pass_ + 1);
  if (pass_ > 0 && key >> (low + kBits) != found_) return;
  ++counts_[(key >> low) & (counts_.size() - 1)];
  count_ += pass_ == 0 ? 1 : 0;
}

bool MedianSearch::again() {
  if (pass_ == kPasses || count_ == 0) return false;
  if (pass_ == 0) rank_ = count_ / 2;
  std::uint64_t place = 0;
  while (counts_[place] <= rank_) rank_ -= counts_[place++];
  found_ = found_ << kBits | place;
  std::ranges::fill(counts_, 0);
  return ++pass_ < kPasses;
}

double MedianSearch::value() const {
  if (count_ == 0) return 0.0;
  return std::bit_cast<double>((found_ & kSign) != 0 ? found_ & ~kSign : ~found_);
}

}  // namespace hoist::db
