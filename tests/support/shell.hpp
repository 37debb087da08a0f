// A command of the shell, run to its end.
#pragma once
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace hoist::test {

struct ShellResult {
  int exit_code = -1;  ///< -1: not started, or ended by a signal
  std::string output;  ///< what it printed on standard output; with "2>&1" in the command also its errors
};

inline ShellResult run_shell(const std::string& command) {
  ShellResult result;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> piece{};
  while (const std::size_t got = std::fread(piece.data(), 1, piece.size(), pipe)) result.output.append(piece.data(), got);
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

}  // namespace hoist::test
