// The arguments of hoist-control, and the parameters that it starts with.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/params.hpp"

namespace hoist::run {

/// Why the program does not start; false: it does.
struct Failure {
  int exit_code = 0;
  std::string text;
  explicit operator bool() const { return exit_code != 0; }
};
inline constexpr int kBadArguments = 2, kBadComputer = 1;  // exit codes

struct Options {
  std::string bus = "slcan:/dev/ttyUSB0";
  std::string socket = "/run/hoist/core.sock";
  std::string params;
  std::string capture;
  std::string inputs = "can";
  std::vector<std::string> set;
  std::string cpu = "auto";
  bool real_time = true;
  bool version = false;
  bool help = false;
};

/// The socket of hoist-sim --lock-step; empty for another bus. The only bus with a foreign clock; no option sets one for another bus.
[[nodiscard]] std::string lock_step_socket(std::string_view bus);

[[nodiscard]] std::string_view help_text();
[[nodiscard]] Failure parse_options(int argc, const char* const* argv, Options& options);

struct StartParams {
  contract::Params stored;    // of the file, or the defaults
  contract::Params in_force;  // with the values of --set
};
/// Reads the parameter file and applies --set. Remarks about the file go to standard error.
[[nodiscard]] Failure load_start_params(const Options& options, StartParams& params);

}  // namespace hoist::run
