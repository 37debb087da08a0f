// The golden files, read once, and the rule by which an answer passes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace hoist::test {

struct GoldenFile {
  std::string function;
  std::string kind;
  double abs_tol{};
  double rel_tol{};
  std::vector<nlohmann::json> cases;
};

/// All files of tests/golden, sorted by function.
[[nodiscard]] const std::vector<GoldenFile>& golden_files();

/// Files that `hoist laws` must compute: kind printed or interpretive.
[[nodiscard]] bool is_law(const GoldenFile& file);

/// A case as a line of `hoist laws`: its "in", with "params" added.
[[nodiscard]] nlohmann::json line_of(const nlohmann::json& golden_case);

/// Empty when `actual` passes, else where it first differs. psi and pphi are compared modulo 2 pi.
[[nodiscard]] std::string difference(const nlohmann::json& actual, const nlohmann::json& expected, double abs_tol, double rel_tol,
                                     const std::string& at = "");

}  // namespace hoist::test
