#include "control/run/options.hpp"

#include <charconv>
#include <cstdio>
#include <iostream>
#include <system_error>

#include "control/bus/step_line.hpp"
#include "control/run/parameter_file.hpp"

namespace hoist::run {
namespace {

constexpr std::string_view kLockStep = "sim:";

// Lock-step needs no priority: a busy computer slows simulated time, and no step is late.
Failure take_lock_step(Options& options) {
  if (!bus::StepLine::valid_path(lock_step_socket(options.bus)))
    return {kBadArguments, "--bus sim: needs the socket of hoist-sim --lock-step, 1 to 107 characters"};
  if (options.inputs != "can")
    return {kBadArguments, "--inputs " + options.inputs + ": a device of its own knows real time only; not with --bus sim:"};
  options.real_time = false;
  return {};
}

// Options without a value; false for any other.
bool take_switch(std::string_view argument, Options& options) {
  if (argument == "--help" || argument == "-h")
    options.help = true;
  else if (argument == "--version")
    options.version = true;
  else if (argument == "--no-realtime")
    options.real_time = false;
  else
    return false;
  return true;
}

std::string* text_option(std::string_view argument, Options& options) {
  if (argument == "--bus") return &options.bus;
  if (argument == "--socket") return &options.socket;
  if (argument == "--params") return &options.params;
  if (argument == "--capture") return &options.capture;
  if (argument == "--inputs") return &options.inputs;
  if (argument == "--cpu") return &options.cpu;
  return nullptr;
}

// Empty, or why this NAME=VALUE of --set is refused.
std::string apply_set(contract::Params& params, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) return "--set needs NAME=VALUE, not " + assignment;
  const std::string name = assignment.substr(0, equals);
  const auto index = contract::find_param(name);
  if (!index) return "there is no parameter " + name;
  double value = 0;
  const char* end = assignment.data() + assignment.size();
  const auto [at, error] = std::from_chars(assignment.data() + equals + 1, end, value);
  const contract::ParamInfo& info = contract::kParams[*index];
  if (error != std::errc() || at != end || contract::check_param(*index, value) != contract::ParamCheck::ok) {
    char text[200];
    std::snprintf(text, sizeof text, "%s must be a number from %g to %g %s", name.c_str(), info.min, info.max,
                  std::string(info.unit).c_str());
    return text;
  }
  contract::set_param_unchecked(params, *index, value);
  return {};
}

// Full lean below hanging and falls, as where a value is changed: of rows that are as stored nothing is asked (contract::kParamRooms).
std::string missing_room(const StartParams& params) {
  const auto changed = [&params](contract::ParamName name) {
    const std::size_t row = contract::param_index(name);
    return contract::get_param(params.in_force, row) != contract::get_param(params.stored, row);
  };
  for (const contract::ParamRoom& room : contract::kParamRooms) {
    if (contract::leaves_room(room, params.in_force) || (!changed(room.smaller) && !changed(room.larger))) continue;
    char text[200];
    const std::string smaller(contract::kParams[contract::param_index(room.smaller)].name);
    const std::string larger(contract::kParams[contract::param_index(room.larger)].name);
    std::snprintf(text, sizeof text, "%s must be at least %g below %s", smaller.c_str(), room.room, larger.c_str());
    return text;
  }
  return {};
}

Failure load_stored(const std::string& file, contract::Params& params) {
  if (file.empty()) return {};
  const LoadedParams loaded = load_parameter_file(file);
  for (const std::string& remark : loaded.remarks) std::cerr << "hoist-control: " << remark << "\n";
  params = loaded.params;
  if (loaded.usable) return {};
  return {kBadComputer, loaded.problem +
                            "\n  Parameters decide how hard this machine may push a patient, so it does not start on guesses.\n"
                            "  Move the file away to start from the defaults."};
}

}  // namespace

std::string lock_step_socket(std::string_view bus) { return std::string(bus.starts_with(kLockStep) ? bus.substr(kLockStep.size()) : ""); }

std::string_view help_text() {
  return "hoist-control: the 100 Hz control core of Hoist\n\n"
         "  --bus ADDRESS      socketcan:NAME, slcan:DEVICE[@BAUD], replay:FILE (default slcan:/dev/ttyUSB0), or sim:SOCKET: hoist-sim\n"
         "                     --lock-step SOCKET, whose time is then this program's; for the simulator only\n"
         "  --inputs WHERE     bumpers, switches and batteries from: can (the input node, default), pokeys:usb, pokeys:/dev/hidraw0 or\n"
         "                     pokeys:udp:HOST; pins in control/bus/README.md\n"
         "  --capture FILE     appends every frame to FILE, in candump's log format\n"
         "  --socket PATH      where hoist-server attaches (default /run/hoist/core.sock)\n"
         "  --params FILE      stored parameters; created at the first change (default: nothing is stored). FILE.stops beside it keeps\n"
         "                     how often the machine's own faults have stopped the hoist\n"
         "  --set NAME=VALUE   starts with this value (SI units) instead of the stored one; may be repeated\n"
         "  --cpu WHICH        core for the control thread: auto (one that the kernel keeps free, else the last; default), none or a "
         "number\n"
         "  --no-realtime      no real-time priority, no locked memory\n"
         "  --version          which source this program was built from\n"
         "  --help             this page\n\n"
         "Ends with a controlled stop on SIGINT or SIGTERM.\n";
}

Failure parse_options(int argc, const char* const* argv, Options& options) {
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (take_switch(argument, options)) {
      if (options.help || options.version) return {};
      continue;
    }
    std::string* const text = text_option(argument, options);
    if (text == nullptr && argument != "--set") return {kBadArguments, "unknown argument " + std::string(argument) + "; --help lists them"};
    if (++i == argc) return {kBadArguments, std::string(argument) + " needs a value"};
    if (text != nullptr)
      *text = argv[i];
    else
      options.set.emplace_back(argv[i]);
  }
  return options.bus.starts_with(kLockStep) ? take_lock_step(options) : Failure{};
}

Failure load_start_params(const Options& options, StartParams& params) {
  if (Failure failure = load_stored(options.params, params.stored)) return failure;
  params.in_force = params.stored;
  for (const std::string& assignment : options.set)
    if (std::string problem = apply_set(params.in_force, assignment); !problem.empty()) return {kBadArguments, std::move(problem)};
  if (const char* conflict = contract::check_param_set(params.in_force)) return {kBadArguments, conflict};
  if (std::string conflict = missing_room(params); !conflict.empty()) return {kBadArguments, std::move(conflict)};
  return {};
}

}  // namespace hoist::run
