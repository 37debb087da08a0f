// The one list of a run's figures: the server, the export and the report all go through it. A new figure is one file and one row here.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "control/contract/reference_path.hpp"
#include "db/metrics/evaluate.hpp"

namespace hoist::db {

/// What a figure may look at. `path` is null for free walking.
struct MetricInput {
  RunColumns run;
  const contract::ReferencePath* path{};
};

struct Metric {
  std::string_view id;       ///< column and JSON name, unit as suffix
  std::string_view unit;     ///< for headings; empty for a pure number
  std::string_view meaning;  ///< one plain sentence
  bool needs_path;
  std::optional<double> (*compute)(const MetricInput&);
};

/// All figures, in the order they are shown.
[[nodiscard]] std::span<const Metric> metric_list();

}  // namespace hoist::db
