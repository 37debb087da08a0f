// From each hazard to what watches it and to the tests that try it: the tables of control/contract against the test sources of the tree.
#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace hoist::trace {

/// A test that names a hazard: in its own name, in a comment before or inside it (// H9), or in a row of its file's table.
struct Mention {
  int hazard;
  std::string file, test;  // test is empty for a row of a table before the file's first test
};

struct Scan {
  std::vector<Mention> mentions;        // each test once per hazard, in the order of the files
  std::set<std::string> tested_faults;  // faults that some test names as Fault::NAME
};
/// One source file's mentions are added to `scan`.
void scan_file(std::string_view path, std::string_view text, Scan& scan);
/// All tests below the top of the tree.
[[nodiscard]] Scan scan_tree(const std::filesystem::path& top);

/// What is missing, a sentence each; empty when every hazard has an answer and a test.
[[nodiscard]] std::vector<std::string> holes(const Scan& scan, const std::filesystem::path& top);

/// The listing for the screen: every hazard with its monitors, guards and tests by name.
[[nodiscard]] std::string listing(const Scan& scan);
/// The committed page: the same with the tests' folders instead of every test's name, so that a new test does not change it.
[[nodiscard]] std::string page(const Scan& scan);
inline constexpr std::string_view kPage = "control/HAZARDS.gen.md";

}  // namespace hoist::trace
