// hoist: the engineer's tool. What it can do is in command_list.cpp.
#include <sys/stat.h>

#include <cstdio>
#include <exception>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/program_version.hpp"
#include "deploy/tools/hoist/command.hpp"

namespace {

void print_main_help(std::FILE* out) {
  std::fputs("usage: hoist COMMAND [ARGUMENTS]\n       hoist --version\n\ncommands (each explains itself with --help):\n", out);
  for (const auto& command : hoist::tool::command_list()) {
    std::fprintf(out, "  %-10.*s %.*s\n", static_cast<int>(command.name.size()), command.name.data(),
                 static_cast<int>(command.summary.size()), command.summary.data());
  }
}

int run(std::span<const std::string_view> arguments) {
  if (arguments.empty()) {
    print_main_help(stderr);
    return hoist::tool::kBadUsage;
  }
  if (arguments.front() == "--help" || arguments.front() == "-h" || arguments.front() == "help") {
    print_main_help(stdout);
    return hoist::tool::kDone;
  }
  if (arguments.front() == "--version") {
    std::printf("hoist %s\n", std::string(hoist::contract::program_version()).c_str());
    return hoist::tool::kDone;
  }
  for (const auto& command : hoist::tool::command_list()) {
    if (command.name != arguments.front()) continue;
    try {
      return command.run(arguments.subspan(1));
    } catch (const std::exception& error) {
      std::fprintf(stderr, "hoist %s: %s\n", std::string(command.name).c_str(), error.what());
      return hoist::tool::kRefused;
    }
  }
  std::fprintf(stderr, "hoist: there is no command \"%s\"\n", std::string(arguments.front()).c_str());
  print_main_help(stderr);
  return hoist::tool::kBadUsage;
}

}  // namespace

int main(int count, char** values) {
  ::umask(077);  // what this program writes is about patients or decides how hard they may be pushed: for its own user only
  const std::vector<std::string_view> arguments(values + (count > 0 ? 1 : 0), values + count);
  const int code = run(arguments);
  // Lost output is no success, whatever the command says: its reader would take a cut list for a whole one.
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  std::fputs("hoist: the output could not be written whole\n", stderr);
  return hoist::tool::kRefused;
}
