#include <array>

#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

int run_laws(std::span<const std::string_view> arguments);

namespace {

constexpr std::array kCommands = {
    Command{"laws", "compute the paper's equations from JSON lines", &run_laws},
};

}  // namespace

std::span<const Command> command_list() { return kCommands; }

}  // namespace hoist::tool
