// The safety file (control/safety): each of its tables against what it speaks of. A new package, a new folder or a renamed test fails here.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "control/safety/safety_file.hpp"

namespace hoist::safety {
namespace {

namespace fs = std::filesystem;
const fs::path kTop = HOIST_SOURCE_DIR;
using Names = std::set<std::string>;

std::string output_of(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) text.append(buffer.data(), n);
  return pclose(pipe) == 0 ? text : std::string{};
}

/// What a GoogleTest program says of its own tests, as Suite.Name; instances of a parameter count as their test.
Names listed(const std::string& text) {
  Names names;
  std::istringstream lines(text);
  std::string suite;
  for (std::string line; std::getline(lines, line);) {
    const std::string word = line.substr(0, line.find('#'));
    const std::size_t begin = word.find_first_not_of(' ');
    if (begin == std::string::npos) continue;
    std::string name = word.substr(begin, word.find_last_not_of(' ') - begin + 1);
    if (begin == 0) {
      suite = name.substr(name.find('/') == std::string::npos ? 0 : name.find('/') + 1);
    } else {
      names.insert(suite + name.substr(0, name.find('/')));
    }
  }
  return names;
}

Names lines_of(const std::string& text) {
  Names lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

const char* const kCases = "node " HOIST_SOURCE_DIR "/tests/web/e2e.mjs --list 2>/dev/null";

/// Rows whose test does not exist.
std::vector<std::string> unknown_tests(std::span<const SafetyTest> rows) {
  std::map<std::string, Names> programs{{"e2e", lines_of(output_of(kCases))}};
  std::vector<std::string> unknown;
  for (const SafetyTest& row : rows) {
    const std::string program{row.program};
    // A list that is written as a report of a run would be counted as one.
    if (!programs.contains(program))
      programs[program] = listed(output_of("env -u GTEST_OUTPUT " HOIST_BINARY_DIR "/bin/" + program + " --gtest_list_tests"));
    if (!programs[program].contains(std::string{row.test})) unknown.push_back(program + " " + std::string{row.test});
  }
  return unknown;
}

TEST(SafetyFile, EveryRegisteredTestExists) {
  if (output_of(kCases).empty()) GTEST_SKIP() << "needs Node, for the cases of the browser";
  for (const std::string& name : unknown_tests(kSafetyTests)) ADD_FAILURE() << name << ": no such test (control/safety/tests.def)";
  EXPECT_EQ(unknown_tests(std::array{SafetyTest{1, "test_safety", "Monitors.NoSuchTest"}, SafetyTest{1, "no_such_program", "A.B"},
                                     SafetyTest{1, "e2e", "no such case"}})
                .size(),
            3U);
}

TEST(SafetyFile, EveryHazardHasATest) {
  std::set<int> tested;
  for (const SafetyTest& row : kSafetyTests) {
    tested.insert(row.hazard);
    EXPECT_NE(risk_of(row.hazard), nullptr) << "H" << row.hazard << " does not exist";
  }
  for (const Risk& risk : kRisks) EXPECT_TRUE(tested.contains(risk.hazard)) << "H" << risk.hazard << " has no row in tests.def";
}

TEST(SafetyFile, StopPathsNameHazardsThatExist) {
  for (const StopPath& stop : kStopPaths) {
    std::istringstream numbers{std::string{stop.hazards}};
    for (int number = 0; numbers >> number;) EXPECT_NE(risk_of(number), nullptr) << stop.name << " H" << number;
    EXPECT_TRUE(stop.category == "B" || (stop.category.size() == 1 && stop.category[0] >= '1' && stop.category[0] <= '4')) << stop.name;
  }
}

// ----- packages -----

/// Names in deploy/packages, alternatives (A|B) each.
Names debian_packages(std::istream& lines) {
  Names names;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string group, package;
    if (!(words >> group >> package) || group[0] == '#') continue;
    std::istringstream either(package);
    for (std::string one; std::getline(either, one, '|');) names.insert(one);
  }
  return names;
}

/// What the package.json files of the tree ask for by name.
Names npm_packages(const fs::path& top) {
  Names names;
  for (auto at = fs::recursive_directory_iterator(top); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && (name == "node_modules" || name == "build" || name == ".git" || name == "dist"))
      at.disable_recursion_pending();
    if (name != "package-lock.json") continue;
    std::ifstream file(at->path());
    const auto lock = nlohmann::json::parse(file);
    const auto& root = lock["packages"][""];
    for (const char* kind : {"dependencies", "devDependencies"})
      if (root.contains(kind))
        for (const auto& [package, version] : root[kind].items()) names.insert(package);
  }
  return names;
}

Names rows_of(Origin origin) {
  Names names;
  for (const Soup& row : kSoup)
    if (row.origin == origin) names.insert(std::string{row.name});
  return names;
}

void expect_same(const Names& used, const Names& rows) {
  for (const std::string& name : used) EXPECT_TRUE(rows.contains(name)) << name << " has no row in control/safety/soup.def";
  for (const std::string& name : rows) EXPECT_TRUE(used.contains(name)) << name << " is in control/safety/soup.def and not used";
}

TEST(SafetyFile, EveryDebianPackageHasARow) {
  std::ifstream file(kTop / "deploy/packages");
  Names used = debian_packages(file);
  ASSERT_GT(used.size(), 40U);
  // Two names of one package.
  used.erase("pkgconf");
  expect_same(used, rows_of(Origin::debian));
  std::istringstream sample("# a comment\nbuild  one|other  12\n\ntest   third\n");
  EXPECT_EQ(debian_packages(sample), (Names{"one", "other", "third"}));
}

TEST(SafetyFile, EveryNpmPackageHasARow) { expect_same(npm_packages(kTop), rows_of(Origin::npm)); }

// ----- parts -----

/// Folders with program text, from the top of the tree, that no row holds.
Names unclassified(const fs::path& top) {
  const Names endings{".cpp", ".hpp", ".def", ".ts", ".tsx", ".mjs", ".sh", ".py", ".ld"};
  Names folders;
  for (auto at = fs::recursive_directory_iterator(top); at != fs::recursive_directory_iterator(); ++at) {
    const std::string name = at->path().filename().string();
    if (at->is_directory() && (name == "node_modules" || name[0] == '.' || name == "dist" || at->path() == top / "build"))
      at.disable_recursion_pending();
    if (!at->is_regular_file() || !endings.contains(at->path().extension().string())) continue;
    const std::string folder = fs::relative(at->path().parent_path(), top).string() + "/";
    const bool held =
        std::any_of(kParts.begin(), kParts.end(), [&](const Part& part) { return folder.starts_with(std::string{part.folder} + "/"); });
    if (!held) folders.insert(folder);
  }
  return folders;
}

TEST(SafetyFile, EveryPartHasAClass) {
  for (const std::string& folder : unclassified(kTop)) ADD_FAILURE() << folder << " is in no row of control/safety/parts.def";
  for (const Part& part : kParts) EXPECT_TRUE(fs::is_directory(kTop / part.folder)) << part.folder;
}

TEST(SafetyFile, ListsOfTestsAreRead) {
  EXPECT_EQ(listed("Running main() from gtest_main.cc\nSuite.\n  One\n  Two  # GetParam() = 3\nAll/Each.\n  Works/0\n  Works/1\n"),
            (Names{"Suite.One", "Suite.Two", "Each.Works"}));
}

}  // namespace
}  // namespace hoist::safety
