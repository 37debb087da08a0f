#include "db/metrics/cross_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hoist::db {

double CrossCorrelation::scaled(double sample, Signal& signal) {
  int exponent = 0;
  (void)std::frexp(sample, &exponent);
  if (sample != 0.0 && exponent > signal.exponent) {
    const int shift = signal.exponent - exponent;
    signal.energy = std::ldexp(signal.energy, 2 * shift);
    both_ = std::ldexp(both_, shift);
    signal.exponent = exponent;
  }
  return sample == 0.0 ? 0.0 : std::ldexp(sample, -signal.exponent);
}

void CrossCorrelation::add(double x, double y) {
  finite_ = finite_ && std::isfinite(x) && std::isfinite(y);
  if (!finite_) return;
  const double a = scaled(x, x_), b = scaled(y, y_);
  x_.energy += a * a;
  y_.energy += b * b;
  both_ += a * b;
}

std::optional<double> CrossCorrelation::value() const {
  if (!finite_ || !(x_.energy > 0.0) || !(y_.energy > 0.0)) return std::nullopt;
  // Rounding may carry two equal signals a few parts in 1e16 beyond one.
  return std::clamp(both_ / (std::sqrt(x_.energy) * std::sqrt(y_.energy)), -1.0, 1.0);
}

std::optional<double> cross_correlation(std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size()) return std::nullopt;
  CrossCorrelation out;
  for (std::size_t i = 0; i < x.size(); ++i) out.add(x[i], y[i]);
  return out.value();
}

}  // namespace hoist::db
