#include "db/metrics/cross_correlation.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace hoist::db {

std::optional<double> cross_correlation(std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size() || x.empty()) return std::nullopt;
  const auto length = static_cast<Eigen::Index>(x.size());
  const Eigen::Map<const Eigen::VectorXd> a(x.data(), length);
  const Eigen::Map<const Eigen::VectorXd> b(y.data(), length);
  if (!a.allFinite() || !b.allFinite()) return std::nullopt;
  // Scaled to 1 first: squares of very small or very large samples must not vanish or overflow.
  const double largest_a = a.cwiseAbs().maxCoeff();
  const double largest_b = b.cwiseAbs().maxCoeff();
  if (!(largest_a > 0.0) || !(largest_b > 0.0)) return std::nullopt;
  const double both = ((a / largest_a).array() * (b / largest_b).array()).sum();
  const double energy = std::sqrt((a / largest_a).squaredNorm()) * std::sqrt((b / largest_b).squaredNorm());
  // Rounding may carry two equal signals a few parts in 1e16 beyond one.
  return std::clamp(both / energy, -1.0, 1.0);
}

}  // namespace hoist::db
