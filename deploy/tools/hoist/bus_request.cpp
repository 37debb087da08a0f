#include "deploy/tools/hoist/bus_request.hpp"

#include "control/bus/object_words.hpp"
#include "deploy/tools/hoist/node_objects.hpp"

namespace hoist::tool {

using contract::CanFrame;
using contract::Node;
namespace canopen = contract::canopen;

namespace {

// Longer than two heartbeats, so that every running node and the control computer have been received.
constexpr double kListen_s = 0.25;

bool is_drive_command(const CanFrame& frame) {
  return frame.flags == 0 && (frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, Node::drive_left) ||
                              frame.id == contract::pdo_cob_id(contract::Pdo::drive_rx1, Node::drive_right));
}

struct Heard {
  std::map<std::uint32_t, int> states;
  bool drives_commanded = false;
};
Heard listen(BusLine& line) {
  Heard heard;
  line.listen(kListen_s, [&](const CanFrame& frame) {
    if (frame.flags == 0 && frame.dlc == 1 && frame.id > canopen::kHeartbeatBase && frame.id <= canopen::kHeartbeatBase + 127)
      heard.states[frame.id - canopen::kHeartbeatBase] = frame.data[0];
    heard.drives_commanded = heard.drives_commanded || is_drive_command(frame);
  });
  return heard;
}
bool computer_at_work(const Heard& heard) { return heard.states.count(contract::node_id(Node::core)) != 0; }

}  // namespace

std::optional<BusRequest> parse_bus_request(std::span<const std::string_view> arguments, std::size_t words) {
  BusRequest request;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--bus" && i + 1 < arguments.size())
      request.bus = arguments[++i];
    else if (argument == "--json")
      request.json = true;
    else if (argument == "--force")
      request.force = true;
    else if (argument == "--clear")
      request.clear = true;
    else if (argument.starts_with("--"))
      return std::nullopt;
    else
      request.words.push_back(argument);
  }
  if (request.bus.empty() || request.words.size() != words) return std::nullopt;
  return request;
}

bool wants_help(std::span<const std::string_view> arguments) { return arguments.size() == 1 && arguments[0] == "--help"; }

int bus_usage(const char* command, const char* arguments, std::FILE* out, const char* more) {
  std::fprintf(out,
               "usage: hoist bus %s --bus ADDRESS %s [--json]\n\n"
               "ADDRESS is socketcan:can0 or slcan:/dev/ttyUSB0. NODE is a name or number, OBJECT a name or INDEX:SUB of\n"
               "control/contract/can_dictionary.gen.md.\n%s",
               command, arguments, more);
  return out == stdout ? kDone : kBadUsage;
}

int bus_refused(const char* command, const std::string& why) {
  std::fprintf(stderr, "hoist bus %s: %s\n", command, why.c_str());
  return kRefused;
}

std::optional<int> begin_bus(const char* command, const BusRequest& request, BusLine& line, std::optional<Node>& node) {
  std::string error;
  if (!request.words.empty()) {
    node = parse_node(request.words[0], error);
    if (!node) return bus_refused(command, error);
  }
  if (error = line.open(request.bus); !error.empty()) return bus_refused(command, error);
  return std::nullopt;
}

const contract::NodeInfo& info_of(Node node) { return contract::kNodes[static_cast<std::size_t>(node)]; }

std::map<std::uint32_t, int> listen_for_states(BusLine& line) { return listen(line).states; }

std::string node_state_text(int state) {
  return state < 0 ? "silent" : std::string(bus::nmt_state_words(static_cast<std::uint8_t>(state)));
}

std::string why_not_write(BusLine& line, bool force) {
  return force || !computer_at_work(listen(line)) ? std::string()
                                                  : "the control computer is at work on this bus; stop hoist-control first, or add --force";
}

std::string why_not_command(BusLine& line) {
  const Heard heard = listen(line);
  if (computer_at_work(heard)) return "the control computer is at work on this bus and commands the nodes itself; stop hoist-control first";
  if (heard.drives_commanded) return "another program commands the drives on this bus; end it first";
  return {};
}

}  // namespace hoist::tool
