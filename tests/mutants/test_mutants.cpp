// Every monitor switched off, and every limit of every monitor made twice as lax, one at a time: some safety test must fail. A survivor is
// an untested limit.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace hoist {
namespace {

const char* const kSuite = HOIST_BINARY_DIR "/bin/mutant_suite";

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

// The suite without a mutant, and several times what it needed, on this machine as busy as it is now.
struct Unchanged {
  Outcome outcome;
  int limit_s = 0;
};

const Unchanged& unchanged() {
  static const Unchanged it = [] {
    const auto begin = std::chrono::steady_clock::now();
    Outcome outcome = run("--gtest_brief=1", 600);
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return Unchanged{std::move(outcome), 20 + static_cast<int>(10 * took_s)};
  }();
  return it;
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
  // Few tests notice most mutants: those that noticed one before go first.
  static std::set<std::string> noticing;
  std::string first;
  for (const std::string& test : noticing) first += test + ":";
  const auto attack = [](const std::string& filter) {
    return run("--gtest_brief=1 --mutant '" + GetParam() + "' --gtest_filter='" + filter + "'", unchanged().limit_s);
  };
  Outcome result;
  if (!first.empty()) result = attack(first);
  if (first.empty() || result.status == 0) result = attack("-" + first);
  ASSERT_TRUE(WIFEXITED(result.status)) << result.output;
  const int code = WEXITSTATUS(result.status);
  ASSERT_NE(code, 2) << result.output;
  // One that makes a test hang is not noticed: otherwise a busy machine would notice them all.
  EXPECT_NE(code, kTimedOut) << "not done within " << unchanged().limit_s << " s";
  EXPECT_NE(code, 0) << "no test failed with this mutant: nobody would notice if it were so";
  const std::string noticed = "noticed by ";
  const std::size_t by = result.output.find(noticed);
  ASSERT_NE(by, std::string::npos) << "it ended with " << code << ", but no test says why:\n" << result.output;
  const std::size_t name = by + noticed.size();
  noticing.insert(result.output.substr(name, result.output.find('\n', name) - name));
}
INSTANTIATE_TEST_SUITE_P(Mutants, EachMutant, testing::ValuesIn(mutants()), test_name);

TEST(Mutants, WithoutAMutantEveryTestPasses) {
  EXPECT_EQ(unchanged().outcome.status, 0) << unchanged().outcome.output;
  EXPECT_GE(mutants().size(), 20U) << "the list of mutants came back short";
}

}  // namespace
}  // namespace hoist
