// hoist bus log: decodes a recording of the bus.
#include <cstdint>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/bus/candump_log.hpp"
#include "control/bus/decode.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/frame_text.hpp"

namespace hoist::tool {

namespace {

constexpr char kBusLogHelp[] =
    "usage: hoist bus log FILE [--json] [--only NAME] [--count]\n\n"
    "A recording in candump's log format (candump -L, hoist-control --capture), one frame a line, with names and units.\n"
    "  --json       one JSON object a line\n"
    "  --only NAME  only frames whose name begins with NAME: drive_left, tilt_base_tx1, sync ...\n"
    "  --count      how often each frame came, instead of the frames\n";

double seconds(std::uint64_t time_us) { return static_cast<double>(time_us) * 1e-6; }

}  // namespace

int run_bus_log(std::span<const std::string_view> arguments) {
  std::string path, only;
  bool json = false, count = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--help") {
      std::fputs(kBusLogHelp, stdout);
      return kDone;
    }
    if (argument == "--json") {
      json = true;
    } else if (argument == "--count") {
      count = true;
    } else if (argument == "--only" && i + 1 < arguments.size()) {
      only = arguments[++i];
    } else if (!argument.starts_with("-") && path.empty()) {
      path = argument;
    } else {
      std::fputs(kBusLogHelp, stderr);
      return kBadUsage;
    }
  }
  if (path.empty()) {
    std::fputs(kBusLogHelp, stderr);
    return kBadUsage;
  }
  std::vector<bus::LogEntry> entries;
  if (const std::string problem = bus::read_log(path, entries); !problem.empty()) {
    std::fprintf(stderr, "hoist bus log: %s\n", problem.c_str());
    return kRefused;
  }
  std::map<std::string, std::uint64_t> counts;
  for (const bus::LogEntry& entry : entries) {
    const bus::DecodedFrame frame = bus::decode_frame(entry.frame);
    if (!frame.name.starts_with(only)) continue;
    if (count)
      ++counts[frame.name.empty() ? "unknown" : frame.name];
    else if (json)
      print_frame_json(seconds(entry.time_us), entry, frame);
    else
      print_frame_text(seconds(entry.time_us) - seconds(entries.front().time_us), entry, frame);
  }
  const double span_s = seconds(entries.back().time_us) - seconds(entries.front().time_us);
  for (const auto& [name, times] : counts) {
    const double per_s = span_s > 0 ? static_cast<double>(times) / span_s : 0.0;
    if (json)
      std::printf("%s\n", nlohmann::ordered_json{{"name", name}, {"count", times}, {"per_s", per_s}}.dump().c_str());
    else
      std::printf("%-28s %10llu %10.2f a second\n", name.c_str(), static_cast<unsigned long long>(times), per_s);
  }
  return kDone;
}

}  // namespace hoist::tool
