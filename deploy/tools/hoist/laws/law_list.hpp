// The laws `hoist laws` computes: one row each, by the names of the golden files.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string_view>

#include "deploy/tools/hoist/laws/fields.hpp"

namespace hoist::tool {

struct Law {
  std::string_view name;
  std::string_view summary;
  std::string_view inputs;
  std::string_view parameters;  ///< empty without any
  std::string_view outputs;
  /// Throws Refusal. Reads every known field from both, so that unknown ones can be refused afterwards.
  nlohmann::json (*compute)(Fields& in, Fields& params);
};

/// Rows of laws_motion.cpp, laws_tilt.cpp and laws_metrics.cpp.
[[nodiscard]] std::span<const Law> motion_laws();
[[nodiscard]] std::span<const Law> tilt_laws();
[[nodiscard]] std::span<const Law> metric_laws();

/// nullptr for an unknown name.
[[nodiscard]] const Law* find_law(std::string_view name);

/// The answer to one line: `line` is a case's "in" with "params" added, `shared_params` goes before the defaults and behind the line's own.
/// Throws Refusal.
[[nodiscard]] nlohmann::json compute_law(const Law& law, const nlohmann::json& line, const nlohmann::json& shared_params);

}  // namespace hoist::tool
