#include "deploy/tools/trace/trace.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "control/contract/faults.hpp"
#include "control/contract/hazards.hpp"

namespace hoist::trace {
namespace {

using contract::FaultInfo;
using contract::HazardInfo;
using contract::kFaults;
using contract::kHazards;
using contract::Reaction;

bool word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }
bool digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// The hazards named in a text: an H that begins a word, and one or two digits.
std::vector<int> hazards_in(std::string_view text) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] != 'H' || !digit(text[i + 1]) || (i > 0 && word(text[i - 1]))) continue;
    std::size_t end = i + 1;
    while (end < text.size() && digit(text[end])) ++end;
    // A picture's path (H340) or a constant is no hazard.
    if (end - i - 1 > 2 || (end < text.size() && (text[end] == '.' && end + 1 < text.size() && digit(text[end + 1])))) continue;
    numbers.push_back(std::atoi(std::string(text.substr(i + 1, end - i - 1)).c_str()));
    i = end - 1;
  }
  return numbers;
}

std::string_view trimmed(std::string_view line) {
  while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  return line;
}

bool starts(std::string_view text, std::string_view prefix) { return text.substr(0, prefix.size()) == prefix; }

// The test that begins on this line, or empty: GoogleTest's macros, vitest's it('...'), a case of the Python suites.
std::string test_begun(std::string_view line, std::string_view path) {
  const std::string_view text = trimmed(line);
  if (starts(text, "TEST(") || starts(text, "TEST_F(") || starts(text, "TEST_P(") || starts(text, "TYPED_TEST(")) {
    const auto open = text.find('('), comma = text.find(','), close = text.find(')');
    if (comma == std::string_view::npos || close == std::string_view::npos || comma > close) return "?";
    return std::string(trimmed(text.substr(open + 1, comma - open - 1))) + "." +
           std::string(trimmed(text.substr(comma + 1, close - comma - 1)));
  }
  for (const std::string_view begin : {"it('", "test('"})
    if (starts(text, begin)) return std::string(text.substr(begin.size(), text.find('\'', begin.size()) - begin.size()));
  if (path.size() > 3 && path.substr(path.size() - 3) == ".py" && starts(line, "def "))
    return std::string(line.substr(4, line.find('(') - 4));
  if (path.size() > 4 && path.substr(path.size() - 4) == ".mjs" && (starts(line, "async function ") || starts(line, "  async "))) {
    const auto from = line.find(starts(line, "  async ") ? "async " : "function ") + (starts(line, "  async ") ? 6 : 9);
    return std::string(line.substr(from, line.find('(', from) - from));
  }
  return {};
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const auto end = std::min(text.find(' '), text.size());
    if (end > 0) words.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

bool watches(const FaultInfo& fault, int hazard) {
  const auto words = words_of(fault.hazards);
  return std::find(words.begin(), words.end(), "H" + std::to_string(hazard)) != words.end();
}

bool open(int hazard) {
  return std::any_of(contract::kOpenHazards.begin(), contract::kOpenHazards.end(),
                     [&](const contract::OpenHazard& row) { return row.number == hazard; });
}

std::string_view reaction_text(Reaction reaction) {
  switch (reaction) {
    case Reaction::warn:
      return "warns";
    case Reaction::soft_stop:
      return "soft stop";
    case Reaction::protective_stop:
      return "protective stop";
    case Reaction::out_of_service:
      return "protective stop, then out of service";
    case Reaction::power_off:
      return "power off";
  }
  return "?";
}

}  // namespace

void scan_file(std::string_view path, std::string_view text, Scan& scan) {
  std::set<std::pair<int, std::string>> seen;
  std::vector<int> pending;  // from a comment that may turn out to stand before a test
  std::string test;
  const auto add = [&](int hazard) {
    if (seen.emplace(hazard, test).second) scan.mentions.push_back({hazard, std::string(path), test});
  };
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    for (auto at = line.find("Fault::"); at != std::string::npos; at = line.find("Fault::", at + 1)) {
      auto end = at + 7;
      while (end < line.size() && (word(line[end]) || line[end] == '_')) ++end;
      scan.tested_faults.insert(line.substr(at + 7, end - at - 7));
    }
    const std::string_view bare = trimmed(line);
    const std::vector<int> named = hazards_in(bare);
    if (starts(bare, "//") || starts(bare, "#")) {
      pending.insert(pending.end(), named.begin(), named.end());
      continue;
    }
    if (std::string begun = test_begun(line, path); !begun.empty()) {
      test = std::move(begun);
      for (const int hazard : pending) add(hazard);
    } else if (!test.empty()) {
      for (const int hazard : pending) add(hazard);
    }
    pending.clear();
    for (const int hazard : named) add(hazard);
  }
}

Scan scan_tree(const std::filesystem::path& top) {
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"tests", "web/test"}) {
    if (!std::filesystem::exists(top / folder)) continue;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(top / folder)) {
      const std::string path = std::filesystem::relative(entry.path(), top).generic_string();
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() || path.find("node_modules") != std::string::npos) continue;
      // The trace's own tests are full of examples.
      if (path == "tests/contract/test_trace.cpp" || starts(path, "tests/tidy/")) continue;
      if (extension == ".cpp" || extension == ".hpp" || extension == ".ts" || extension == ".py" || extension == ".mjs")
        files.push_back(path);
    }
  }
  std::sort(files.begin(), files.end());
  Scan scan;
  for (const auto& path : files) scan_file(path.generic_string(), content_of(top / path), scan);
  return scan;
}

std::vector<std::string> holes(const Scan& scan, const std::filesystem::path& top) {
  std::vector<std::string> found;
  for (const HazardInfo& hazard : kHazards) {
    if (open(hazard.number)) continue;
    const std::string name = "H" + std::to_string(hazard.number) + " (" + std::string(hazard.what) + ")";
    const bool watched = std::any_of(kFaults.begin(), kFaults.end(), [&](const FaultInfo& f) { return watches(f, hazard.number); });
    if (!watched && hazard.guard.empty()) found.push_back(name + " has neither monitor nor guard");
    if (std::none_of(scan.mentions.begin(), scan.mentions.end(), [&](const Mention& m) { return m.hazard == hazard.number; }))
      found.push_back(name + " has no test that names it");
    for (const std::string_view file : words_of(hazard.files))
      if (!std::filesystem::exists(top / file))
        found.push_back(name + " is said to be answered by " + std::string(file) + ", which is not there");
  }
  for (const FaultInfo& fault : kFaults) {
    const std::string name(fault.name);
    for (const std::string_view hazard : words_of(fault.hazards)) {
      const bool request = std::any_of(contract::kRequests.begin(), contract::kRequests.end(),
                                       [&](const contract::RequestInfo& r) { return r.name == hazard; });
      const bool known =
          std::any_of(kHazards.begin(), kHazards.end(), [&](const HazardInfo& h) { return hazard == "H" + std::to_string(h.number); });
      if (!request && !known)
        found.push_back("the monitor of " + name + " names the hazard " + std::string(hazard) + ", which does not exist");
    }
    if (scan.tested_faults.count(name) == 0) found.push_back("no test names Fault::" + name);
  }
  for (const Mention& mention : scan.mentions)
    if (mention.hazard < 1 || mention.hazard > static_cast<int>(kHazards.size()))
      found.push_back(mention.file + ": " + mention.test + " names the hazard H" + std::to_string(mention.hazard) +
                      ", which does not exist");
  return found;
}

std::string listing(const Scan& scan) {
  std::string text;
  for (const HazardInfo& hazard : kHazards) {
    text += "H" + std::to_string(hazard.number) + "  " + std::string(hazard.what) + "\n";
    for (const FaultInfo& fault : kFaults)
      if (watches(fault, hazard.number))
        text += "    monitor  " + std::string(fault.name) + ": " + std::string(fault.threshold) + "; " +
                std::string(reaction_text(fault.reaction)) + " within " + std::to_string(fault.budget_ms) + " ms\n";
    if (!hazard.guard.empty()) text += "    guard    " + std::string(hazard.guard) + " (" + std::string(hazard.files) + ")\n";
    if (open(hazard.number)) text += "    MISSING  the whole answer\n";
    for (const auto& gap : contract::kHazardGaps)
      if (gap.number == hazard.number)
        text += "    MISSING  " + std::string(gap.missing) + "; comes with " + std::string(gap.comes_with) + "\n";
    for (const Mention& mention : scan.mentions)
      if (mention.hazard == hazard.number)
        text += "    test     " + mention.file + ": " + (mention.test.empty() ? "rows of its table" : mention.test) + "\n";
  }
  return text;
}

std::string page(const Scan& scan) {
  std::string text =
      "<!-- Made by `deploy/dev trace --write` from control/contract/hazards.def, control/contract/faults.def and the test sources; do not "
      "edit. -->\n"
      "# Hazards, their guards and tests\n\n"
      "`deploy/dev trace` prints the same with the name of every test, and fails when a hazard has no guard or no test, when a monitor "
      "has no\n"
      "hazard, or when a test names a hazard that does not exist.\n\n"
      "| | hazard | monitors | other guards | tests in |\n|---|---|---|---|---|\n";
  for (const HazardInfo& hazard : kHazards) {
    text += "| H" + std::to_string(hazard.number) + " | " + std::string(hazard.what) + " | ";
    std::string monitors;
    for (const FaultInfo& fault : kFaults)
      if (watches(fault, hazard.number)) monitors += (monitors.empty() ? "" : ", ") + std::string(fault.name);
    text += monitors + " | " + std::string(hazard.guard) + " | ";
    std::set<std::string> files;
    for (const Mention& mention : scan.mentions)
      if (mention.hazard == hazard.number) files.insert(mention.file.substr(0, mention.file.rfind('/')));
    std::string tests;
    for (const std::string& file : files) tests += (tests.empty() ? "`" : ", `") + file + "`";
    text += tests + " |\n";
  }
  text += "\n## Monitors\n\n| fault | hazard | trips when | then | budget |\n|---|---|---|---|---|\n";
  for (const FaultInfo& fault : kFaults)
    text += "| " + std::string(fault.name) + " | " + std::string(fault.hazards) + " | " + std::string(fault.threshold) + " | " +
            std::string(reaction_text(fault.reaction)) + " | " + std::to_string(fault.budget_ms) + " ms |\n";
  text += "\n";
  for (const auto& request : contract::kRequests) text += std::string(request.name) + ": " + std::string(request.why) + ".\n";
  text += "\n## Missing\n\n| | missing | comes with |\n|---|---|---|\n";
  for (const auto& row : contract::kOpenHazards)
    if (row.number > 0) text += "| H" + std::to_string(row.number) + " | the whole answer | " + std::string(row.comes_with) + " |\n";
  for (const auto& gap : contract::kHazardGaps)
    text += "| H" + std::to_string(gap.number) + " | " + std::string(gap.missing) + " | " + std::string(gap.comes_with) + " |\n";
  return text;
}

}  // namespace hoist::trace
