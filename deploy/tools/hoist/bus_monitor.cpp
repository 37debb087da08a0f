// hoist bus monitor: decodes the frames of a live bus.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "deploy/tools/hoist/bus_line.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/frame_text.hpp"

namespace hoist::tool {

namespace {

constexpr char kBusMonitorHelp[] =
    "usage: hoist bus monitor --bus ADDRESS [--only NAME] [--changes] [--seconds S] [--json]\n\n"
    "What passes on the bus now, one frame a line, until Ctrl-C. ADDRESS is slcan:/dev/ttyUSB0 or socketcan:can0.\n"
    "It sends nothing. A serial line belongs to one program: beside hoist-control, use its --capture and hoist bus log.\n"
    "  --only NAME   only frames whose name begins with NAME: drive_left, tilt_base_tx1, sync ...\n"
    "  --changes     only frames whose content differs from the last one of the same id\n"
    "  --seconds S   end after S seconds\n"
    "  --json        one JSON object a line\n";

struct MonitorRequest {
  std::string bus, only;
  bool json = false, changes = false;
  double seconds = std::numeric_limits<double>::infinity();
};

std::optional<double> parse_seconds(std::string_view text) {
  double value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc{} || end != text.data() + text.size() || !(value > 0 && std::isfinite(value))) return std::nullopt;
  return value;
}

std::optional<MonitorRequest> parse(std::span<const std::string_view> arguments) {
  MonitorRequest request;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    const bool more = i + 1 < arguments.size();
    if (argument == "--json") {
      request.json = true;
    } else if (argument == "--changes") {
      request.changes = true;
    } else if (argument == "--bus" && more) {
      request.bus = arguments[++i];
    } else if (argument == "--only" && more) {
      request.only = arguments[++i];
    } else if (argument == "--seconds" && more) {
      const auto seconds = parse_seconds(arguments[++i]);
      if (!seconds) return std::nullopt;
      request.seconds = *seconds;
    } else {
      return std::nullopt;
    }
  }
  if (request.bus.empty()) return std::nullopt;
  return request;
}

}  // namespace

int run_bus_monitor(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(kBusMonitorHelp, stdout);
    return kDone;
  }
  const auto request = parse(arguments);
  if (!request) {
    std::fputs(kBusMonitorHelp, stderr);
    return kBadUsage;
  }
  BusLine line;
  if (const std::string error = line.open(request->bus); !error.empty()) {
    std::fprintf(stderr, "hoist bus monitor: %s\n", error.c_str());
    return kRefused;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // each line at once, into a pipe too
  std::map<std::uint32_t, contract::CanFrame> last;
  const auto show = [&](const contract::CanFrame& frame) {
    const bus::DecodedFrame decoded = bus::decode_frame(frame);
    if (!decoded.name.starts_with(request->only)) return;
    if (request->changes) {
      const auto [at, is_new] = last.try_emplace(frame.id, frame);
      if (!is_new && at->second == frame) return;
      at->second = frame;
    }
    const bus::LogEntry entry{0, frame, {}, bus::Direction::unknown};
    if (request->json)
      print_frame_json(line.time_s(), entry, decoded);
    else
      print_frame_text(line.time_s(), entry, decoded);
  };
  // A lost bus is reported and waited for.
  std::string missing;
  const double end_s = line.time_s() + request->seconds;
  for (double left_s = request->seconds; left_s > 0; left_s = end_s - line.time_s()) {
    line.listen(std::min(left_s, 0.1), show);
    if (line.missing() == missing) continue;
    missing = line.missing();
    std::fprintf(stderr, "hoist bus monitor: %s\n", missing.empty() ? "the bus is back" : missing.c_str());
  }
  return kDone;
}

}  // namespace hoist::tool
