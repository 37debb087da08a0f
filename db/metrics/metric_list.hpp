// The rows of metrics.def.
#pragma once
#include <array>
#include <string_view>

#include "control/contract/check.hpp"

namespace hoist::db {

struct MetricInfo {
  std::string_view key;
  unsigned version;
  std::string_view unit;
  bool nullable;
  std::string_view inputs;  // names with a blank between
  std::string_view source, doc;
};

inline constexpr std::array kMetrics{
#define HOIST_METRIC(key, version, unit, member, defined, inputs, source, doc) \
  MetricInfo{#key, version, unit, std::string_view{#defined} == "nullable", inputs, source, doc},
#include "db/metrics/metrics.def"
#undef HOIST_METRIC
};
static_assert(contract::unique_by(kMetrics, [](const MetricInfo& m) { return m.key; }), "metrics.def: a figure is named twice");

}  // namespace hoist::db
