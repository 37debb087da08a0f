// hoist bus log: a recording of the bus in words and units.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/bus/candump_log.hpp"
#include "control/bus/decode.hpp"
#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

namespace {

constexpr char kHelp[] =
    "usage: hoist bus log FILE [--json] [--only NAME] [--count]\n\n"
    "A recording in candump's log format (candump -L, hoist-control --capture), one frame a line, with names and units.\n"
    "  --json       one JSON object a line\n"
    "  --only NAME  only frames whose name begins with NAME: drive_left, tilt_base_tx1, sync ...\n"
    "  --count      how often each frame came, instead of the frames\n";

double seconds(std::uint64_t time_us) { return static_cast<double>(time_us) * 1e-6; }

void print_text(const bus::LogEntry& entry, const bus::DecodedFrame& frame, std::uint64_t begin_us) {
  const char* direction = entry.direction == bus::Direction::sent ? "sent" : entry.direction == bus::Direction::received ? "    " : "";
  std::printf("%12.6f %s %03X %-24s", seconds(entry.time_us) - seconds(begin_us), direction, entry.frame.id,
              frame.name.empty() ? "unknown" : frame.name.c_str());
  if (frame.name.empty())
    for (std::size_t i = 0; i < entry.frame.dlc; ++i) std::printf(" %02X", entry.frame.data[i]);
  for (const bus::DecodedField& field : frame.fields) {
    if (field.hex)
      std::printf(" %s=%llXh", field.name.c_str(), static_cast<unsigned long long>(field.value));
    else
      std::printf(" %s=%.10g", field.name.c_str(), field.value);
    if (!field.unit.empty()) std::printf(" %s", field.unit.c_str());
    if (!field.meaning.empty()) std::printf(" (%s)", field.meaning.c_str());
  }
  if (!frame.problem.empty()) std::printf(" REFUSED: %s", frame.problem.c_str());
  std::putchar('\n');
}

void print_json(const bus::LogEntry& entry, const bus::DecodedFrame& frame) {
  nlohmann::ordered_json line{{"time_s", seconds(entry.time_us)}, {"id", entry.frame.id}, {"name", nullptr}};
  if (!frame.name.empty()) line["name"] = frame.name;
  if (entry.direction != bus::Direction::unknown) line["sent"] = entry.direction == bus::Direction::sent;
  nlohmann::ordered_json fields = nlohmann::ordered_json::object();
  for (const bus::DecodedField& field : frame.fields) {
    // What is no number (a damaged float) has no JSON.
    fields[field.name] = std::isfinite(field.value) ? nlohmann::ordered_json(field.value) : nlohmann::ordered_json(nullptr);
  }
  line["fields"] = fields;
  if (!frame.problem.empty()) line["problem"] = frame.problem;
  std::printf("%s\n", line.dump().c_str());
}

}  // namespace

int run_bus_log(std::span<const std::string_view> arguments) {
  std::string path, only;
  bool json = false, count = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--help") {
      std::fputs(kHelp, stdout);
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
      std::fputs(kHelp, stderr);
      return kBadUsage;
    }
  }
  if (path.empty()) {
    std::fputs(kHelp, stderr);
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
      print_json(entry, frame);
    else
      print_text(entry, frame, entries.front().time_us);
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
