#include "tests/unit/law/golden.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

namespace hoist::test {

using nlohmann::json;

const std::vector<GoldenFile>& golden_files() {
  static const std::vector<GoldenFile> kFiles = [] {
    std::vector<GoldenFile> files;
    for (const auto& entry : std::filesystem::directory_iterator(std::string(HOIST_SOURCE_DIR) + "/tests/golden")) {
      if (entry.path().extension() != ".json") continue;
      std::ifstream stream(entry.path());
      const json document = json::parse(stream);
      files.push_back({document.at("function"), document.at("kind"), document.at("abs_tol"), document.at("rel_tol"), document.at("cases")});
    }
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.function < b.function; });
    return files;
  }();
  return kFiles;
}

bool is_law(const GoldenFile& file) { return file.kind == "printed" || file.kind == "interpretive"; }

json line_of(const json& golden_case) {
  json line = golden_case.at("in");
  if (golden_case.contains("params")) line["params"] = golden_case["params"];
  return line;
}

std::string difference(const json& actual, const json& expected, double abs_tol, double rel_tol, const std::string& at) {
  const std::string values = at + ": " + actual.dump().substr(0, 200) + " instead of " + expected.dump().substr(0, 200);
  if (expected.is_object()) {
    if (!actual.is_object() || actual.size() != expected.size()) return values;
    for (const auto& [name, value] : expected.items()) {
      if (!actual.contains(name)) return values;
      if (auto found = difference(actual[name], value, abs_tol, rel_tol, at.empty() ? name : at + "." + name); !found.empty()) return found;
    }
    return "";
  }
  if (expected.is_array()) {
    if (!actual.is_array() || actual.size() != expected.size()) return values;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const std::string place = at + "[" + std::to_string(i) + "]";
      if (auto found = difference(actual[i], expected[i], abs_tol, rel_tol, place); !found.empty()) return found;
    }
    return "";
  }
  if (expected.is_number()) {
    if (!actual.is_number()) return values;
    double off = actual.get<double>() - expected.get<double>();
    if (at == "psi" || at == "pphi") off = std::remainder(off, 2.0 * std::numbers::pi);
    return std::fabs(off) <= abs_tol + rel_tol * std::fabs(expected.get<double>()) ? "" : values;
  }
  return actual == expected ? "" : values;
}

}  // namespace hoist::test
