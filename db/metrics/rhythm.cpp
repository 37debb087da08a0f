#include "db/metrics/rhythm.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace hoist::db {

namespace {

constexpr std::size_t kSettle = samples_in(kSettle_s);
/// The middle of the sway is its mean over three seconds around, which follows bends and slow leaning.
constexpr std::size_t kMiddle = samples_in(1.5);
static_assert(kMiddle <= kSettle);
/// A stride takes 0.6 to 3.5 s: 34 to 200 steps a minute.
constexpr std::size_t kShortest = samples_in(0.6), kLongest = samples_in(3.5);
/// A stretch shorter than this holds no two strides.
constexpr std::size_t kLeastStretch = samples_in(5.0);
/// Of several peaks the first that is nearly as high as the highest: at twice the stride the sway is alike, too.
constexpr double kMainPeak = 0.85;

using Signal = std::vector<double>;

// The sway of each steady stretch, about its mean over `half` samples to either side.
std::vector<Signal> sways_of(const Walk& walk, const std::vector<Stretch>& bouts, std::size_t half) {
  std::vector<Signal> out;
  for (const Stretch& bout : bouts) {
    if (bout.count() < 2 * kSettle + kLeastStretch) continue;
    std::vector<double> sum(bout.count() + 1, 0.0);
    for (std::size_t i = 0; i < bout.count(); ++i) sum[i + 1] = sum[i] + walk.dy_m[bout.first + i];
    Signal sway;
    for (std::size_t i = kSettle; i + kSettle < bout.count(); ++i)
      sway.push_back(walk.dy_m[bout.first + i] - (sum[i + half + 1] - sum[i - half]) / static_cast<double>(2 * half + 1));
    out.push_back(std::move(sway));
  }
  return out;
}

// A(m) = sum x_i x_{i+m} / (N - m), all stretches together.
double autocorrelation(const std::vector<Signal>& sways, std::size_t m) {
  double sum = 0;
  std::size_t pairs = 0;
  for (const Signal& x : sways) {
    if (x.size() <= m) continue;
    pairs += x.size() - m;
    for (std::size_t i = 0; i + m < x.size(); ++i) sum += x[i] * x[i + m];
  }
  return pairs == 0 ? 0.0 : sum / static_cast<double>(pairs);
}

// The first main peak, in samples, between them by a parabola; 0 for none.
double main_peak(const std::vector<double>& a) {
  std::vector<std::size_t> peaks;
  double highest = 0;
  for (std::size_t m = kShortest; m <= kLongest; ++m) {
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

double between(const std::vector<double>& values, double at) {
  const auto before = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(before);
  return values[before] + share * (values[std::min(before + 1, values.size() - 1)] - values[before]);
}

// Upward crossings of the middle, in samples; each after a clear swing to the right, so that noise at the middle is none.
std::vector<double> crossings_of(const Signal& x, double rms_m, double stride) {
  constexpr double kClear = 0.3, kNearest = 0.5;
  std::vector<double> out;
  bool swung = false;
  for (std::size_t i = 1; i < x.size(); ++i) {
    swung = swung || x[i] < -kClear * rms_m;
    if (!swung || x[i] < 0 || x[i - 1] >= 0) continue;
    const double at = static_cast<double>(i) - x[i] / (x[i] - x[i - 1]);
    if (out.empty() || at - out.back() > kNearest * stride) out.push_back(at);
    swung = false;
  }
  return out;
}

/// Points of the mean stride, and the harmonics that are kept of it: more would follow the noise.
constexpr std::size_t kPoints = 100, kHarmonics = 4;
using MeanStride = std::array<double, kPoints>;

constexpr std::size_t kFine = 4000;
std::vector<double> smoothed(const MeanStride& mean) {
  constexpr double kTurn_rad = 2 * std::numbers::pi;
  std::vector<double> out(kFine, 0.0);
  for (std::size_t h = 1; h <= kHarmonics; ++h) {
    double cosine = 0, sine = 0;
    for (std::size_t p = 0; p < kPoints; ++p) {
      const double angle_rad = kTurn_rad * static_cast<double>(h * p) / kPoints;
      cosine += 2.0 / kPoints * mean[p] * std::cos(angle_rad);
      sine += 2.0 / kPoints * mean[p] * std::sin(angle_rad);
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
double asymmetry_of(const MeanStride& mean) {
  const std::vector<double> stride = smoothed(mean);
  double squares = 0;
  for (const double value : stride) squares += value * value;
  const double level = std::sqrt(squares / static_cast<double>(kFine));
  const auto left = static_cast<std::size_t>(std::ranges::max_element(stride) - stride.begin());
  const auto right = static_cast<std::size_t>(std::ranges::min_element(stride) - stride.begin());
  const double to_left = way_across(stride, right, left, level), to_right = way_across(stride, left, right, -level);
  return 2.0 * (to_left - to_right) / (to_left + to_right);
}

// Strides one by one, and the mean of all of them drawn to one length.
void add_strides(const std::vector<Signal>& sways, Rhythm& out) {
  constexpr double kLongestNorm = 1.6;
  const double stride = out.stride_s / kSample_s;
  const double rms_m = std::sqrt(autocorrelation(sways, 0));
  MeanStride mean{};
  for (const Signal& x : sways) {
    const std::vector<double> crossings = crossings_of(x, rms_m, stride);
    for (std::size_t k = 1; k < crossings.size(); ++k) {
      const double length = crossings[k] - crossings[k - 1];
      if (length > kLongestNorm * stride) continue;  // one was missed
      out.strides_s.push_back(length * kSample_s);
      for (std::size_t p = 0; p < kPoints; ++p) mean[p] += between(x, crossings[k - 1] + length * static_cast<double>(p) / kPoints);
    }
  }
  out.why_no_spread = out.strides_s.size() < kFewestForSpread ? NoFigure::few_strides : NoFigure::none;
  if (out.why_no_spread != NoFigure::none) return;
  out.asymmetry = asymmetry_of(mean);
}

}  // namespace

Rhythm rhythm_of(const Walk& walk, const std::vector<Stretch>& bouts) {
  Rhythm out;
  const auto none = [&out](NoFigure why) {
    out.why = out.why_no_spread = why;
    return out;
  };
  if (!walk.has_sway) return none(NoFigure::not_recorded);
  if (bouts.empty()) return none(NoFigure::no_motion);
  const std::vector<Signal> sways = sways_of(walk, bouts, kMiddle);
  std::size_t steady = 0;
  for (const Signal& x : sways) steady += x.size();
  if (steady < kFewestStrides * kShortest) return none(NoFigure::few_strides);
  std::vector<double> a;
  for (std::size_t m = 0; m <= kLongest + 1; ++m) a.push_back(autocorrelation(sways, m));
  if (a[0] < kLeastSway_m * kLeastSway_m) return none(NoFigure::no_rhythm);
  const double stride = main_peak(a);
  if (stride <= 0 || between(a, stride) < kLeastRegularity * a[0]) return none(NoFigure::no_rhythm);
  if (static_cast<double>(steady) < static_cast<double>(kFewestStrides) * stride) return none(NoFigure::few_strides);
  out.why = NoFigure::none;
  out.stride_s = stride * kSample_s;
  out.stride_regularity = between(a, stride) / a[0];
  out.step_regularity = std::fabs(between(a, stride / 2)) / a[0];
  // About its mean over one stride: a mean over another time would keep a part of the stride itself, and shift its extremes.
  add_strides(sways_of(walk, bouts, std::min(samples_in(out.stride_s / 2), kSettle)), out);
  return out;
}

}  // namespace hoist::db
