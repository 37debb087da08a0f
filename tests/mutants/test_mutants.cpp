// Every monitor switched off, and every limit of every monitor made twice as lax, one at a time: some safety test must fail. A survivor is
// an untested limit.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace hoist {
namespace {

const char* const kSuite = HOIST_BINARY_DIR "/bin/mutant_suite";

// Equivalent mutants, each with the reason.
struct Equivalent {
  const char* mutant;
  const char* why;
};
constexpr std::array<Equivalent, 0> kEquivalent{};

// Mutants that make a test hang instead of fail. Any other one that does not end in time counts as not noticed:
// otherwise a busy machine would notice them all.
constexpr std::array<const char*, 0> kHanging{};

struct Outcome {
  std::string output;
  int status = -1;  // as from waitpid
};

constexpr int kTimedOut = 124;  // as timeout(1) says it

Outcome run(const std::string& arguments, int limit_s) {
  Outcome result;
  FILE* pipe = popen(("exec timeout " + std::to_string(limit_s) + " " + kSuite + " " + arguments + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) result.output.append(buffer.data(), n);
  result.status = pclose(pipe);
  return result;
}

// Several times what the suite needs without a mutant, on this machine as busy as it is now.
int limit_s() {
  static const int limit = [] {
    const auto begin = std::chrono::steady_clock::now();
    static_cast<void>(run("--gtest_brief=1", 600));
    return 20 + static_cast<int>(10 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }();
  return limit;
}

std::vector<std::string> mutants() {
  std::vector<std::string> names;
  std::istringstream lines(run("--list", 60).output);
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
  const Outcome result = run("--gtest_brief=1 --mutant '" + GetParam() + "'", limit_s());
  ASSERT_TRUE(WIFEXITED(result.status)) << result.output;
  const int code = WEXITSTATUS(result.status);
  ASSERT_NE(code, 2) << result.output;
  const auto* const known =
      std::find_if(kEquivalent.begin(), kEquivalent.end(), [](const Equivalent& row) { return row.mutant == GetParam(); });
  if (known != kEquivalent.end()) {
    EXPECT_EQ(code, 0) << "a test notices it now: take it off the list of equivalent mutants";
    return;
  }
  const bool hangs = std::find(kHanging.begin(), kHanging.end(), GetParam()) != kHanging.end();
  if (hangs) {
    EXPECT_EQ(code, kTimedOut) << "it ends now: take it off the list of hanging mutants";
    return;
  }
  EXPECT_NE(code, kTimedOut) << "not done within " << limit_s() << " s";
  EXPECT_NE(code, 0) << "no test failed with this mutant: nobody would notice if it were so";
  EXPECT_NE(result.output.find("noticed by "), std::string::npos) << "it ended with " << code << ", but no test says why:\n"
                                                                  << result.output;
}
INSTANTIATE_TEST_SUITE_P(Mutants, EachMutant, testing::ValuesIn(mutants()), test_name);

TEST(Mutants, WithoutAMutantEveryTestPasses) {
  const Outcome result = run("--gtest_brief=1", 600);
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_GE(mutants().size(), 20U) << "the list of mutants came back short";
}

}  // namespace
}  // namespace hoist
