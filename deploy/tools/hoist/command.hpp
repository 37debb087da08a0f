// A sub-command of `hoist`: one file each, one row each in command_list.cpp.
#pragma once

#include <span>
#include <string_view>

namespace hoist::tool {

struct Command {
  std::string_view name;
  std::string_view summary;  ///< one line for `hoist --help`
  /// Gets what follows the name; returns the exit code: 0 done, 1 something was refused, 2 the command line was not understood, 3 done only in part.
  int (*run)(std::span<const std::string_view> arguments);
};

/// All sub-commands, in the order `hoist --help` prints them.
[[nodiscard]] std::span<const Command> command_list();

inline constexpr int kDone = 0;
inline constexpr int kRefused = 1;
inline constexpr int kBadUsage = 2;
inline constexpr int kPartly = 3;

}  // namespace hoist::tool
