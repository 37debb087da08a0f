#include "db/metrics/turns.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::db {

namespace {
constexpr auto kHesitation = samples_in(kHesitation_s);
}  // namespace

void TurnFinder::add(const WalkSample& sample) {
  if (count_ > 0 && sample.tick != tick_ + 1) close_stretch();
  tick_ = sample.tick;
  window_[count_ % kWindow] = {sample.psi_rad, sample.dpsi_rad};
  ++count_;
  if (count_ <= kHalf) return;
  const std::size_t place = count_ - 1 - kHalf;
  const double from_rad = place < kHalf ? 0.0 : window_[(place - kHalf) % kWindow].psi_rad;
  judge(place, place < kHalf ? 0.0 : (sample.psi_rad - from_rad) / (2.0 * static_cast<double>(kHalf) * kSample_s));
}

void TurnFinder::judge(std::size_t place, double rate_rad_s) {
  const Heading& heading = window_[place % kWindow];
  lead_.add(heading.dpsi_rad, rate_rad_s);
  if (std::fabs(rate_rad_s) <= kTurnEdge_rad_s) return;
  const bool goes_on = part_ && place - (part_->last + 1) < kHesitation && (part_->rate_rad_s > 0) == (rate_rad_s > 0);
  if (!goes_on) {
    close_part();
    part_ = Part{place, place, heading.psi_rad, 0, 0, 0};
  }
  part_->last = place;
  part_->last_rad = heading.psi_rad;
  part_->rate_rad_s = rate_rad_s;
  part_->peak_rad_s = std::max(part_->peak_rad_s, std::fabs(rate_rad_s));
}

void TurnFinder::close_part() {
  if (!part_) return;
  const double angle_rad = part_->last_rad - part_->first_rad;
  if (part_->peak_rad_s > kTurnPeak_rad_s && std::fabs(angle_rad) > kTurnLeast_rad) {
    ++(angle_rad > 0 ? out_.left : out_.right);
    out_.angle_rad += std::fabs(angle_rad);
    out_.time_s += static_cast<double>(part_->last + 1 - part_->first) * kSample_s;
  }
  part_.reset();
}

void TurnFinder::close_stretch() {
  for (std::size_t place = count_ > kHalf ? count_ - kHalf : 0; place < count_; ++place) judge(place, 0.0);
  close_part();
  count_ = 0;
}

TurnTotals TurnFinder::end() {
  close_stretch();
  out_.lead = lead_.value();
  return out_;
}

}  // namespace hoist::db
