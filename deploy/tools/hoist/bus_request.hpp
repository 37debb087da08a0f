// Shared by the sub-commands of `hoist bus` that use a bus: command line, bus, nodes on it.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/can_dictionary.hpp"
#include "deploy/tools/hoist/bus_line.hpp"
#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

struct BusRequest {
  std::string bus;
  std::vector<std::string_view> words;
  bool json = false, force = false, clear = false;
};

/// Empty for an invalid command line.
[[nodiscard]] std::optional<BusRequest> parse_bus_request(std::span<const std::string_view> arguments, std::size_t words);
[[nodiscard]] bool wants_help(std::span<const std::string_view> arguments);
/// Prints the usage; the exit code belongs to the stream: stdout for --help.
int bus_usage(const char* command, const char* arguments, std::FILE* out, const char* more = "");
int bus_refused(const char* command, const std::string& why);

/// Opens the bus and reads the node from the first argument; an exit code on failure.
[[nodiscard]] std::optional<int> begin_bus(const char* command, const BusRequest& request, BusLine& line,
                                           std::optional<contract::Node>& node);

[[nodiscard]] const contract::NodeInfo& info_of(contract::Node node);
/// State by node id, from the heartbeats of a quarter of a second.
[[nodiscard]] std::map<std::uint32_t, int> listen_for_states(BusLine& line);
/// "operational"; "silent" for a node without heartbeat.
[[nodiscard]] std::string node_state_text(int state);

/// Why no value may be written now (a running control computer would not know of it). Empty when allowed.
[[nodiscard]] std::string why_not_write(BusLine& line, bool force);
/// Why no node may be commanded now: a control computer, or another program that commands the drives, owns the bus. There is no override.
[[nodiscard]] std::string why_not_command(BusLine& line);

}  // namespace hoist::tool
