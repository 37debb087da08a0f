// hoist-gen: rewrites every committed *.gen.* file from the tables, or says which ones are out of date.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "deploy/tools/gen/generate.hpp"
#include "deploy/tools/trace/trace.hpp"

namespace {

std::string content_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

constexpr const char* kHelp =
    "usage: hoist-gen --top FOLDER [--check]\n"
    "  writes all generated files below FOLDER (the top of the tree); those that are right already are left alone\n"
    "  --check  writes nothing, names the files that differ and exits with 1 when there are any\n";

int run(int count, char** arguments) {
  std::filesystem::path top;
  bool check = false;
  for (int i = 1; i < count; ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--top" && i + 1 < count) {
      top = arguments[++i];
    } else if (argument == "--check") {
      check = true;
    } else if (argument == "--help") {
      std::fputs(kHelp, stdout);
      return 0;
    } else {
      std::fprintf(stderr, "hoist-gen: unknown argument '%s'\n%s", arguments[i], kHelp);
      return 2;
    }
  }
  if (top.empty()) {
    std::fputs(kHelp, stderr);
    return 2;
  }
  auto files = hoist::gen::generate_all();
  const std::string lock_path(hoist::gen::kIdLockPath);
  const auto lock = hoist::gen::updated_id_lock(content_of(top / lock_path));
  for (const auto& conflict : lock.conflicts) std::fprintf(stderr, "hoist-gen: %s\n", conflict.c_str());
  if (!lock.conflicts.empty()) {
    std::fprintf(stderr, "hoist-gen: give new rows new ids; if a row was only renamed, rename it in %s as well\n", lock_path.c_str());
    return 1;
  }
  files.push_back({lock_path, lock.text});
  // Made from the tables and the names of the tests.
  files.push_back({std::string(hoist::trace::kPage), hoist::trace::page(hoist::trace::scan_tree(top))});
  int different = 0;
  for (const auto& file : files) {
    const auto path = top / file.path;
    if (content_of(path) == file.text) continue;
    ++different;
    std::printf("%s %s\n", check ? "out of date:" : "wrote", file.path.c_str());
    if (check) continue;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out << file.text;
    if (!out.flush()) {
      std::fprintf(stderr, "hoist-gen: cannot write %s\n", path.c_str());
      return 1;
    }
  }
  if (check && different > 0) std::puts("run: deploy/dev gen");
  return check && different > 0 ? 1 : 0;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count, arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hoist-gen: %s\n", error.what());
    return 1;
  }
}
