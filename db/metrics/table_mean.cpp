#include "db/metrics/table_mean.hpp"

#include <cstddef>

namespace hoist::db {

std::vector<std::optional<double>> table_mean(std::span<const std::vector<std::optional<double>>> rows) {
  if (rows.empty()) return {};
  const std::size_t runs = rows.front().size();
  for (const auto& row : rows) {
    if (row.size() != runs) return {};
  }
  std::vector<std::optional<double>> mean(runs);
  for (std::size_t run = 0; run < runs; ++run) {
    double sum = 0.0;
    std::size_t present = 0;
    for (const auto& row : rows) {
      if (!row[run]) continue;
      sum += *row[run];
      ++present;
    }
    if (present > 0) mean[run] = sum / static_cast<double>(present);
  }
  return mean;
}

}  // namespace hoist::db
