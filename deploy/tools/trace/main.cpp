// hoist-trace: prints every hazard with its monitors, guards and tests; fails when one is missing.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "deploy/tools/trace/trace.hpp"

namespace {

constexpr const char* kHelp =
    "usage: hoist-trace --top FOLDER [--write]\n"
    "  prints every hazard with its monitors, guards and tests; ends with 1 when one of them is missing\n"
    "  --write  also writes the committed page control/HAZARDS.gen.md\n";

int run(int count, char** arguments) {
  std::filesystem::path top;
  bool write = false;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--top" && i + 1 < count) {
      top = arguments[++i];
    } else if (argument == "--write") {
      write = true;
    } else {
      std::fputs(kHelp, argument == "--help" ? stdout : stderr);
      return argument == "--help" ? 0 : 2;
    }
  }
  if (top.empty()) {
    std::fputs(kHelp, stderr);
    return 2;
  }
  const auto scan = hoist::trace::scan_tree(top);
  std::fputs(hoist::trace::listing(scan).c_str(), stdout);
  if (write) {
    std::ofstream out(top / hoist::trace::kPage, std::ios::binary | std::ios::trunc);
    out << hoist::trace::page(scan);
    if (!out.flush()) {
      std::fputs("hoist-trace: cannot write the page\n", stderr);
      return 1;
    }
  }
  const auto holes = hoist::trace::holes(scan, top);
  for (const std::string& hole : holes) std::printf("HOLE: %s\n", hole.c_str());
  return holes.empty() ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hoist-trace: %s\n", error.what());
    return 1;
  }
}
