// Every golden case of kind printed and interpretive, in process.
#include "tests/unit/law/golden.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "deploy/tools/hoist/laws/law_list.hpp"

namespace hoist::test {
namespace {

using nlohmann::json;

struct Case {
  const GoldenFile* file;
  const json* golden;
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const auto& file : golden_files()) {
    if (!is_law(file)) continue;
    for (const auto& golden : file.cases) cases.push_back({&file, &golden});
  }
  return cases;
}

class Golden : public testing::TestWithParam<Case> {};

TEST_P(Golden, HoldsInTheDefaultReading) {
  const auto& [file, golden] = GetParam();
  const auto* law = tool::find_law(file->function);
  ASSERT_NE(law, nullptr) << file->function;
  const json out = tool::compute_law(*law, line_of(*golden), json::object());
  EXPECT_EQ(difference(out, golden->at("out"), file->abs_tol, file->rel_tol), "") << golden->value("note", "");
}

INSTANTIATE_TEST_SUITE_P(Files, Golden, testing::ValuesIn(all_cases()), [](const testing::TestParamInfo<Case>& which) {
  std::string name = which.param.golden->at("id");
  for (auto& letter : name) {
    if (letter == '-') letter = '_';
  }
  return name;
});

// A missing folder, or a law without a file, must fail.
TEST(GoldenFiles, CoverExactlyTheLaws) {
  std::set<std::string> files;
  std::size_t cases = 0;
  for (const auto& file : golden_files()) {
    if (!is_law(file)) continue;
    files.insert(file.function);
    cases += file.cases.size();
  }
  std::set<std::string> laws;
  for (const auto group : {tool::motion_laws(), tool::tilt_laws(), tool::metric_laws()}) {
    for (const auto& law : group) laws.emplace(law.name);
  }
  EXPECT_EQ(files, laws);
  EXPECT_GE(cases, 129U);
}

// The comparison itself must be able to fail.
TEST(GoldenComparison, SeesEveryKindOfDifference) {
  const json expected = {{"a", 1.0}, {"b", {1.0, 2.0}}, {"psi", 3.0}, {"m", "n"}, {"t", nullptr}};
  EXPECT_EQ(difference(expected, expected, 0.0, 0.0), "");
  for (const auto& [name, wrong] : std::vector<std::pair<std::string, json>>{
           {"a", 1.1}, {"a", nullptr}, {"a", "1"}, {"b", {1.0}}, {"b", {1.0, 2.1}}, {"psi", 3.1}, {"m", "d"}, {"t", 0.0}}) {
    json actual = expected;
    actual[name] = wrong;
    EXPECT_NE(difference(actual, expected, 0.01, 0.01), "") << name << " " << wrong;
  }
  json turned = expected;
  turned["psi"] = 3.0 + 2.0 * M_PI;
  EXPECT_EQ(difference(turned, expected, 1e-12, 0.0), "");
  json more = expected;
  more["c"] = 1.0;
  EXPECT_NE(difference(more, expected, 0.0, 0.0), "");
}

}  // namespace
}  // namespace hoist::test
