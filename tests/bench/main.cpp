// hoist-bench: every figure with its reference measured in the same run.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/bench/bench.hpp"

namespace {
using namespace hoist::bench;

std::vector<Section> sections_of(const std::string& bin) {
  return {{"law", "the control law and the whole tick", measure_law_and_tick},
          {"memory", "shared memory beside memcpy", measure_shared_memory},
          {"simulator", "the closed loop in virtual time", measure_simulator},
          {"loop", "hoist-control beside bare loops, 40 s", [bin](Report& r) { measure_loop(r, bin); }},
          {"websocket", "hoist-server beside a bare sender, 1, 20 and 64 clients", [bin](Report& r) { measure_websocket(r, bin); }},
          {"driving", "from the bus to the browser, and from the joystick to the bus", [bin](Report& r) { measure_driving(r, bin); }},
          {"recording", "a session beside SQLite rows and the sqlite3 shell", measure_recording},
          {"export", "each export format of ten minutes and of an hour", [bin](Report& r) { measure_export(r, bin); }},
          {"served", "hoist-server's memory while it exports ten minutes and three hours", [bin](Report& r) { measure_served(r, bin); }},
          {"rerun", "a recorded session run again, and its journal", measure_rerun},
          {"rest", "hoist-server beside nginx", [bin](Report& r) { measure_rest(r, bin); }},
          {"instructions", "counted by callgrind",
           [bin](Report& r) {
             measure_instructions(r, bin);
             measure_status_instructions(r, bin);
           }},
          {"console", "size of web/dist", measure_console},
          {"firmware", "cycles and sizes, from the generated pages", measure_firmware}};
}
void print_help(const std::vector<Section>& sections) {
  std::printf(
      "hoist-bench [--only SECTION]... [--store FILE] [--compare FILE]\n\n"
      "  --only SECTION   runs this section; may be repeated (default: all)\n"
      "  --store FILE     writes the ratios and exact counts; figures of sections that did not run stay\n"
      "  --compare FILE   ends with status 1 when a figure is more than 10 %% worse than in FILE\n\n");
  for (const Section& section : sections) std::printf("  %-12s %s\n", section.name.c_str(), section.what.c_str());
}
}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3 && (argv[1] == std::string(kReplayTicks) || argv[1] == std::string(kReplaySteps))) {
      (argv[1] == std::string(kReplayTicks) ? replay_ticks : replay_steps)(std::stoi(argv[2]));
      return 0;
    }
    const std::vector<Section> sections = sections_of(std::filesystem::read_symlink("/proc/self/exe").parent_path().string());
    const Options options = parse_options({argv + 1, argv + argc}, sections);
    if (options.help) {
      print_help(sections);
      return 0;
    }
    return run(sections, options);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "hoist-bench: %s\n", problem.what());
    return 2;
  }
}
