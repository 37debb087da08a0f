// hoist bus: commands for the CAN bus; one row and one file for each sub-command.
#include <array>
#include <cstdio>
#include <vector>

#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

int run_bus_scan(std::span<const std::string_view> arguments);
int run_bus_read(std::span<const std::string_view> arguments);
int run_bus_write(std::span<const std::string_view> arguments);
int run_bus_dump(std::span<const std::string_view> arguments);
int run_bus_restore(std::span<const std::string_view> arguments);
int run_bus_save(std::span<const std::string_view> arguments);
int run_bus_load_defaults(std::span<const std::string_view> arguments);
int run_bus_emcy(std::span<const std::string_view> arguments);
int run_bus_load(std::span<const std::string_view> arguments);
int run_bus_log(std::span<const std::string_view> arguments);
int run_bus_monitor(std::span<const std::string_view> arguments);
int run_bus_nmt(std::span<const std::string_view> arguments);
int run_bus_reset_fault(std::span<const std::string_view> arguments);

namespace {

constexpr std::array kBusCommands = {
    Command{"scan", "every node: name, state, device (1008h), hardware (1009h), software (100Ah)", &run_bus_scan},
    Command{"monitor", "what passes on the bus now, in words and units", &run_bus_monitor},
    Command{"read", "one object of a node, states and status bits in words", &run_bus_read},
    Command{"write", "one object of a node", &run_bus_write},
    Command{"dump", "all objects of a node", &run_bus_dump},
    Command{"restore", "the parameters of a dump back into a node", &run_bus_restore},
    Command{"save", "store a node's parameters", &run_bus_save},
    Command{"load-defaults", "let a node start with defaults", &run_bus_load_defaults},
    Command{"emcy", "the errors that a node remembers, in words", &run_bus_emcy},
    Command{"nmt", "start, stop or reset a node, or all of them", &run_bus_nmt},
    Command{"reset-fault", "reset the fault of a drive", &run_bus_reset_fault},
    Command{"load", "load and response times, from the tables", &run_bus_load},
    Command{"log", "a recording of the bus in words and units", &run_bus_log},
};

void print_bus_help(std::FILE* out) {
  std::fputs("usage: hoist bus COMMAND [ARGUMENTS]\n\ncommands (each explains itself with --help):\n", out);
  for (const Command& command : kBusCommands)
    std::fprintf(out, "  %-13.*s %.*s\n", static_cast<int>(command.name.size()), command.name.data(),
                 static_cast<int>(command.summary.size()), command.summary.data());
  std::fputs(
      "\n--bus ADDRESS, here or behind the command: socketcan:can0, or slcan:/dev/ttyUSB0 (gateway; the line must be free, so end\n"
      "hoist-control first). load and log need no bus. --json prints for programs.\n"
      "nmt and reset-fault are refused while a control computer owns the bus; write, restore, save and load-defaults are, too,\n"
      "unless --force is given. Exit codes: 0 done, 1 refused, 2 not understood.\n",
      out);
}

}  // namespace

int run_bus(std::span<const std::string_view> arguments) {
  // The address may also stand first: hoist bus --bus slcan:/dev/ttyUSB0 scan.
  std::vector<std::string_view> turned;
  if (arguments.size() >= 3 && arguments[0] == "--bus") {
    turned.push_back(arguments[2]);
    turned.insert(turned.end(), arguments.begin(), arguments.begin() + 2);
    turned.insert(turned.end(), arguments.begin() + 3, arguments.end());
    arguments = turned;
  }
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
