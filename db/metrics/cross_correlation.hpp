// Table II: how well the pelvis turns where the path turns.
#pragma once

#include <optional>
#include <span>

namespace hoist::db {

/// Normalised cross-correlation at zero lag, sum(x y) / sqrt(sum x^2 sum y^2), the mean not removed (MATLAB xcorr with 'coeff', D28), of pairs
/// that come one by one. Nothing of them is kept.
class CrossCorrelation {
 public:
  void add(double x, double y);
  /// Within [-1, 1]. No value without pairs, when one signal is zero throughout (the factor is then undefined), or when a sample is not finite.
  [[nodiscard]] std::optional<double> value() const;

 private:
  // The sum of squares, in units of 2^exponent squared: the largest sample so far is 0.5 to 1 of that unit. Powers of two are exact, and squares
  // of very small or very large samples neither vanish nor overflow.
  struct Signal {
    int exponent = -2000;
    double energy = 0;
  };
  double scaled(double sample, Signal& signal);
  Signal x_, y_;
  double both_ = 0;
  bool finite_ = true;
};

/// The same of whole columns. No value when they differ in length, either.
[[nodiscard]] std::optional<double> cross_correlation(std::span<const double> x, std::span<const double> y);

}  // namespace hoist::db
