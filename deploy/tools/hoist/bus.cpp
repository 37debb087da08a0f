// hoist bus: what concerns the CAN bus; one row and one file for each of its own sub-commands.
#include <array>
#include <cstdio>

#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

int run_bus_log(std::span<const std::string_view> arguments);

namespace {

constexpr std::array kBusCommands = {
    Command{"log", "a recording of the bus in words and units", &run_bus_log},
};

void print_bus_help(std::FILE* out) {
  std::fputs("usage: hoist bus COMMAND [ARGUMENTS]\n\ncommands (each explains itself with --help):\n", out);
  for (const Command& command : kBusCommands)
    std::fprintf(out, "  %-10.*s %.*s\n", static_cast<int>(command.name.size()), command.name.data(),
                 static_cast<int>(command.summary.size()), command.summary.data());
}

}  // namespace

int run_bus(std::span<const std::string_view> arguments) {
  if (!arguments.empty() && arguments[0] == "--help") {
    print_bus_help(stdout);
    return kDone;
  }
  if (!arguments.empty())
    for (const Command& command : kBusCommands)
      if (command.name == arguments[0]) return command.run(arguments.subspan(1));
  print_bus_help(stderr);
  return kBadUsage;
}

}  // namespace hoist::tool
