// Last rows of Tables II and III: the mean of each run over the subjects who did it.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace hoist::db {

/// One row per subject; a missing run is nullopt. All rows of one length, else an empty answer. A run without any
/// subject has no mean.
[[nodiscard]] std::vector<std::optional<double>> table_mean(std::span<const std::vector<std::optional<double>>> rows);

}  // namespace hoist::db
