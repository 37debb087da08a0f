// Every monitor switched off, and every limit of every monitor made twice as lax, one at a time: some safety test must fail. What survives
// is a limit that nobody would miss if it were wrong.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace hoist {
namespace {

const char* const kSuite = HOIST_BINARY_DIR "/bin/mutant_suite";

// Mutants that change nothing anybody could notice, each with the reason.
struct Equivalent {
  const char* mutant;
  const char* why;
};
constexpr std::array<Equivalent, 0> kEquivalent{};

struct Outcome {
  std::string output;
  int status = -1;  // as from waitpid
};

Outcome run(const std::string& arguments) {
  Outcome result;
  // A mutant may also make a test wait for ever: that is noticed too.
  FILE* pipe = popen((std::string("exec timeout 20 ") + kSuite + " " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) result.output.append(buffer.data(), n);
  result.status = pclose(pipe);
  return result;
}

std::vector<std::string> mutants() {
  std::vector<std::string> names;
  std::istringstream lines(run("--list").output);
  for (std::string line; std::getline(lines, line);) names.push_back(line);
  return names;
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}

class EachMutant : public testing::TestWithParam<std::string> {};

TEST_P(EachMutant, IsNoticed) {
  const Outcome result = run("--gtest_brief=1 --mutant '" + GetParam() + "'");
  ASSERT_TRUE(WIFEXITED(result.status)) << result.output;
  const int code = WEXITSTATUS(result.status);
  ASSERT_NE(code, 2) << result.output;
  const auto* const known =
      std::find_if(kEquivalent.begin(), kEquivalent.end(), [](const Equivalent& row) { return row.mutant == GetParam(); });
  if (known != kEquivalent.end()) {
    EXPECT_EQ(code, 0) << "a test notices it now: take it off the list of equivalent mutants";
    return;
  }
  EXPECT_NE(code, 0) << "no test failed with this mutant: nobody would notice if it were so";
}
INSTANTIATE_TEST_SUITE_P(Mutants, EachMutant, testing::ValuesIn(mutants()), test_name);

TEST(Mutants, WithoutAMutantEveryTestPasses) {
  const Outcome result = run("--gtest_brief=1");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_GE(mutants().size(), 20U) << "the list of mutants came back short";
}

}  // namespace
}  // namespace hoist
