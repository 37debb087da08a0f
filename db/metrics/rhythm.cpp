#include "db/metrics/rhythm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace hoist::db {

namespace {

constexpr std::size_t kSettle = samples_in(kSettle_s);
/// A stretch shorter than this holds no two strides.
constexpr std::size_t kLeastStretch = samples_in(5.0);
/// Of several peaks the first that is nearly as high as the highest: at twice the stride the sway is alike, too.
constexpr double kMainPeak = 0.85;
/// A crossing sooner after the last one than this share of the stride is none; a stride longer than this has missed one.
constexpr double kNearestNorm = 0.5, kLongestNorm = 1.6;

// The first main peak, in samples, between them by a parabola; 0 for none.
double main_peak(std::span<const double> a, std::size_t shortest, std::size_t longest) {
  std::vector<std::size_t> peaks;
  double highest = 0;
  for (std::size_t m = shortest; m <= longest; ++m) {
    if (!(a[m] > 0 && a[m] >= a[m - 1] && a[m] > a[m + 1])) continue;
    peaks.push_back(m);
    highest = std::max(highest, a[m]);
  }
  for (const std::size_t m : peaks) {
    if (a[m] < kMainPeak * highest) continue;
    const double bend = a[m - 1] - 2 * a[m] + a[m + 1];
    return static_cast<double>(m) + (bend < 0 ? 0.5 * (a[m - 1] - a[m + 1]) / bend : 0.0);
  }
  return 0;
}

double between(std::span<const double> values, double at) {
  const auto before = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(before);
  return values[before] + share * (values[std::min(before + 1, values.size() - 1)] - values[before]);
}

/// Harmonics that are kept of the mean stride: more would follow the noise.
constexpr std::size_t kHarmonics = 4;

constexpr std::size_t kFine = 4000;
std::vector<double> smoothed(std::span<const double> mean) {
  const auto points = static_cast<double>(mean.size());
  constexpr double kTurn_rad = 2 * std::numbers::pi;
  std::vector<double> out(kFine, 0.0);
  for (std::size_t h = 1; h <= kHarmonics; ++h) {
    double cosine = 0, sine = 0;
    for (std::size_t p = 0; p < mean.size(); ++p) {
      const double angle_rad = kTurn_rad * static_cast<double>(h * p) / points;
      cosine += 2.0 / points * mean[p] * std::cos(angle_rad);
      sine += 2.0 / points * mean[p] * std::sin(angle_rad);
    }
    for (std::size_t f = 0; f < kFine; ++f) {
      const double angle_rad = kTurn_rad * static_cast<double>(h * f) / kFine;
      out[f] += cosine * std::cos(angle_rad) + sine * std::sin(angle_rad);
    }
  }
  return out;
}

// Points from the last one beyond -level to the first one beyond +level, on the way between two places of the stride.
double way_across(const std::vector<double>& stride, std::size_t from, std::size_t to, double level) {
  const std::size_t length = (to + kFine - from) % kFine;
  std::size_t last = 0, first = length;
  for (std::size_t k = 0; k < length; ++k) {
    const double value = stride[(from + k) % kFine] * (level > 0 ? 1.0 : -1.0);
    if (value < -std::fabs(level)) last = k;
    if (value > std::fabs(level)) {
      first = k;
      break;
    }
  }
  return static_cast<double>(first) - static_cast<double>(last);
}

// The extremes themselves are flat, and their place is lost in the noise; the way between the levels of the root mean square is steep.
double asymmetry_of(std::span<const double> mean) {
  const std::vector<double> stride = smoothed(mean);
  double squares = 0;
  for (const double value : stride) squares += value * value;
  const double level = std::sqrt(squares / static_cast<double>(kFine));
  const auto left = static_cast<std::size_t>(std::ranges::max_element(stride) - stride.begin());
  const auto right = static_cast<std::size_t>(std::ranges::min_element(stride) - stride.begin());
  const double to_left = way_across(stride, right, left, level), to_right = way_across(stride, left, right, -level);
  return 2.0 * (to_left - to_right) / (to_left + to_right);
}

}  // namespace

const SwayStream::Piece& SwayStream::add(const WalkSample& sample) {
  piece_.sway_m.clear();
  const std::optional<std::size_t> at = run_.add(sample);
  if (!at || *at == 0) {
    held_.clear();
    place_ = 0;
    sum_m_[0] = 0;
  }
  if (!at) return piece_;
  const std::size_t k = *at;
  dy_m_[k % kWindow] = sample.dy_m;
  sum_m_[(k + 1) % kWindow] = sum_m_[k % kWindow] + sample.dy_m;
  if (k < 2 * kSettle) return piece_;
  static_assert(2 * kSettle + 2 <= kWindow);
  const std::size_t i = k - kSettle;
  const double middle_m = (sum_m_[(i + half_ + 1) % kWindow] - sum_m_[(i - half_) % kWindow]) / static_cast<double>(2 * half_ + 1);
  held_.push_back(dy_m_[i % kWindow] - middle_m);
  if (k + 1 < 2 * kSettle + kLeastStretch) return piece_;
  piece_.sway_m.swap(held_);
  piece_.place = std::exchange(place_, place_ + piece_.sway_m.size());
  return piece_;
}

void RhythmFinder::add(const WalkSample& sample) {
  const SwayStream::Piece& piece = sway_.add(sample);
  std::size_t place = piece.place;
  for (const double sway_m : piece.sway_m) {
    switch (pass_) {
      case Pass::likeness:
        add_likeness(place, sway_m);
        break;
      case Pass::size:
        ++size_count_;
        squares_ += sway_m * sway_m;
        break;
      case Pass::strides:
        add_stride_sample(place, sway_m);
        break;
      case Pass::over:
        break;
    }
    ++place;
  }
}

// A(m) = sum x_i x_{i+m} / (N - m), all stretches together.
void RhythmFinder::add_likeness(std::size_t place, double sway_m) {
  if (place == 0) {
    ++stretches_;
    window_.fill(0.0);
  }
  ++steady_;
  window_[next_] = window_[next_ + kLags] = sway_m;
  next_ = (next_ + 1) % kLags;
  // Before a stretch's first value the window holds zeros, which add nothing.
  const double* const earlier = window_.data() + next_;
  for (std::size_t i = 0; i < kLags; ++i) products_[i] += earlier[i] * sway_m;
}

bool RhythmFinder::find_stride() {
  const auto none = [this](NoFigure why) {
    out_.why = out_.why_no_spread = why;
    return false;
  };
  if (steady_ < kFewestStrides * kShortest) return none(NoFigure::few_strides);
  static_assert(kLeastStretch > kLags, "every stretch has pairs of each distance");
  std::array<double, kLags> a{};
  for (std::size_t m = 0; m < kLags; ++m) a[m] = products_[kLags - 1 - m] / static_cast<double>(steady_ - stretches_ * m);
  if (a[0] < kLeastSway_m * kLeastSway_m) return none(NoFigure::no_rhythm);
  stride_ = main_peak(a, kShortest, kLongest);
  if (stride_ <= 0 || between(a, stride_) < kLeastRegularity * a[0]) return none(NoFigure::no_rhythm);
  if (static_cast<double>(steady_) < static_cast<double>(kFewestStrides) * stride_) return none(NoFigure::few_strides);
  out_.why = NoFigure::none;
  out_.stride_s = stride_ * kSample_s;
  out_.stride_regularity = between(a, stride_) / a[0];
  out_.step_regularity = std::fabs(between(a, stride_ / 2)) / a[0];
  stride_ = out_.stride_s / kSample_s;
  return true;
}

bool RhythmFinder::again() {
  // About its mean over one stride: a mean over another time would keep a part of the stride itself, and shift its extremes.
  const auto over_a_stride = [this] { return SwayStream(std::min(samples_in(out_.stride_s / 2), kSettle)); };
  switch (pass_) {
    case Pass::likeness:
      pass_ = find_stride() ? Pass::size : Pass::over;
      if (pass_ == Pass::size) sway_ = over_a_stride();
      break;
    case Pass::size:
      rms_m_ = size_count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(size_count_));
      pass_ = Pass::strides;
      sway_ = over_a_stride();
      break;
    case Pass::strides:
      finish();
      pass_ = Pass::over;
      break;
    case Pass::over:
      break;
  }
  return pass_ != Pass::over;
}

// Upward crossings of the middle, each after a clear swing to the right, so that noise at the middle is none.
void RhythmFinder::add_stride_sample(std::size_t place, double sway_m) {
  constexpr double kClear = 0.3;
  kept_m_[place % kKept] = sway_m;
  if (place == 0) {
    swung_ = false;
    crossing_.reset();
    return;
  }
  const double before_m = kept_m_[(place - 1) % kKept];
  swung_ = swung_ || sway_m < -kClear * rms_m_;
  if (!swung_ || sway_m < 0 || before_m >= 0) return;
  swung_ = false;
  const double at = static_cast<double>(place) - sway_m / (sway_m - before_m);
  if (crossing_ && at - *crossing_ <= kNearestNorm * stride_) return;
  if (crossing_ && at - *crossing_ <= kLongestNorm * stride_) add_stride(*crossing_, at);
  crossing_ = at;
}

// The stride itself, and its part of the mean of all of them drawn to one length.
void RhythmFinder::add_stride(double from, double to) {
  static_assert(kLongestNorm * (kLongest + 1) + 2 < kKept);
  const double beyond_s = (to - from) * kSample_s - out_.stride_s;
  ++strides_;
  beyond_s_ += beyond_s;
  beyond2_s2_ += beyond_s * beyond_s;
  for (std::size_t p = 0; p < kPoints; ++p) mean_[p] += sway_at(from + (to - from) * static_cast<double>(p) / kPoints);
}

double RhythmFinder::sway_at(double place) const {
  const auto before = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(before), at_m = kept_m_[before % kKept];
  return at_m + share * (kept_m_[(before + 1) % kKept] - at_m);
}

void RhythmFinder::finish() {
  out_.why_no_spread = strides_ < kFewestForSpread ? NoFigure::few_strides : NoFigure::none;
  if (out_.why_no_spread != NoFigure::none) return;
  const auto count = static_cast<double>(strides_);
  const double variance_s2 = (beyond2_s2_ - beyond_s_ * beyond_s_ / count) / (count - 1);
  out_.stride_time_cv = std::sqrt(std::max(variance_s2, 0.0)) / (out_.stride_s + beyond_s_ / count);
  out_.asymmetry = asymmetry_of(mean_);
}

Rhythm RhythmFinder::result(const Walk& walk, bool any_bout) const {
  if (walk.has_sway && any_bout) return out_;
  Rhythm none;
  none.why = none.why_no_spread = walk.has_sway ? why_no_bout(walk) : NoFigure::not_recorded;
  return none;
}

}  // namespace hoist::db
