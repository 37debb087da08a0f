// Table II: how well the pelvis turns where the path turns.
#pragma once

#include <optional>
#include <span>

namespace hoist::db {

/// Normalised cross-correlation at zero lag, sum(x y) / sqrt(sum x^2 sum y^2), the mean not removed (MATLAB xcorr with 'coeff', D28).
/// Within [-1, 1]. No value when the two differ in length, when one is zero throughout (the factor is then undefined), or when a sample
/// is not finite.
[[nodiscard]] std::optional<double> cross_correlation(std::span<const double> x, std::span<const double> y);

}  // namespace hoist::db
