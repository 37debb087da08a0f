// hoist bus nmt, reset-fault: what changes the state of a node. Only on a bus that no control computer owns.
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "control/bus/object_words.hpp"
#include "deploy/tools/hoist/bus_request.hpp"
#include "deploy/tools/hoist/drive_fault.hpp"
#include "deploy/tools/hoist/node_objects.hpp"

namespace hoist::tool {

namespace {

using contract::Node;
using nlohmann::ordered_json;
namespace canopen = contract::canopen;

constexpr char kOwner[] = "Refused while a control computer, or another program that commands the drives, is on this bus.\n";

struct NmtWord {
  std::string_view word;
  canopen::NmtCommand command;
};
constexpr std::array kNmtWords{
    NmtWord{"start", canopen::NmtCommand::start},
    NmtWord{"stop", canopen::NmtCommand::stop},
    NmtWord{"pre-operational", canopen::NmtCommand::pre_operational},
    NmtWord{"reset", canopen::NmtCommand::reset_node},
    NmtWord{"reset-communication", canopen::NmtCommand::reset_communication},
};
constexpr char kNmtArguments[] = "NODE|all start|stop|pre-operational|reset|reset-communication";
// From the reset to a boot-up message and the next heartbeat.
constexpr double kRestart_s = 0.3;

void print_states(const std::map<std::uint32_t, int>& states, bool json) {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) {
    const contract::NodeInfo& info = contract::kNodes[i];
    const auto found = states.find(info.id);
    const std::string state = node_state_text(found == states.end() ? -1 : found->second);
    if (json)
      list.push_back({{"node", info.name}, {"state", state}});
    else
      std::printf("%-12s %s\n", std::string(info.name).c_str(), state.c_str());
  }
  if (json) std::printf("%s\n", list.dump().c_str());
}

struct DriveState {
  std::uint32_t status = 0, error = 0;
};
std::optional<DriveState> read_drive(BusLine& line, std::uint8_t id) {
  DriveState state;
  if (!line.upload(id, 0x6041, 0)) return std::nullopt;
  state.status = line.client().value();
  if (!line.upload(id, 0x603F, 0)) return std::nullopt;
  state.error = line.client().value();
  return state;
}
std::string drive_words(std::uint16_t index, std::uint32_t raw) { return bus::object_words(contract::NodeKind::drive, index, 0, raw); }
bool has_fault(const DriveState& state) {
  return canopen::drive::state(static_cast<std::uint16_t>(state.status)) == canopen::drive::State::fault;
}

void print_drive(std::string_view name, const DriveState& state, bool json) {
  const std::string status = drive_words(0x6041, state.status), error = drive_words(0x603F, state.error);
  if (json)
    std::printf("%s\n",
                ordered_json{{"node", name}, {"fault", has_fault(state)}, {"status", status}, {"code", state.error}, {"error", error}}
                    .dump()
                    .c_str());
  else
    std::printf("%s: %s; error %04Xh, %s\n", std::string(name).c_str(), status.c_str(), state.error, error.c_str());
}

}  // namespace

int run_bus_nmt(std::span<const std::string_view> arguments) {
  if (wants_help(arguments)) return bus_usage("nmt", kNmtArguments, stdout, kOwner);
  const auto request = parse_bus_request(arguments, 2);
  if (!request) return bus_usage("nmt", kNmtArguments, stderr, kOwner);
  const NmtWord* word = nullptr;
  for (const NmtWord& known : kNmtWords)
    if (known.word == request->words[1]) word = &known;
  if (word == nullptr) return bus_usage("nmt", kNmtArguments, stderr, kOwner);
  std::string error;
  std::uint8_t id = 0;  // all
  if (request->words[0] != "all") {
    const auto node = parse_node(request->words[0], error);
    if (!node) return bus_refused("nmt", error);
    id = info_of(*node).id;
  }
  BusLine line;
  if (error = line.open(request->bus); !error.empty()) return bus_refused("nmt", error);
  if (error = why_not_command(line); !error.empty()) return bus_refused("nmt", error);
  if (!line.send(canopen::nmt(word->command, id))) return bus_refused("nmt", "the bus did not take the command: " + line.problem());
  line.listen(kRestart_s, {});
  print_states(listen_for_states(line), request->json);
  return kDone;
}

int run_bus_reset_fault(std::span<const std::string_view> arguments) {
  if (wants_help(arguments)) return bus_usage("reset-fault", "DRIVE", stdout, kOwner);
  const auto request = parse_bus_request(arguments, 1);
  if (!request) return bus_usage("reset-fault", "DRIVE", stderr, kOwner);
  std::string error;
  const auto node = parse_node(request->words[0], error);
  if (!node) return bus_refused("reset-fault", error);
  const contract::NodeInfo& info = info_of(*node);
  if (info.kind != contract::NodeKind::drive) return bus_refused("reset-fault", std::string(info.name) + " is no drive");
  BusLine line;
  if (error = line.open(request->bus); !error.empty()) return bus_refused("reset-fault", error);
  if (error = why_not_command(line); !error.empty()) return bus_refused("reset-fault", error);
  auto state = read_drive(line, info.id);
  if (!state) return bus_refused("reset-fault", line.problem());
  if (!has_fault(*state)) {
    print_drive(info.name, *state, request->json);
    return kDone;
  }
  if (!line.upload(info.id, 0x1400, 1)) return bus_refused("reset-fault", line.problem());
  const std::uint32_t command_id = line.client().value();
  if ((command_id & contract::kPdoOffBit) != 0) return bus_refused("reset-fault", "the drive's command PDO (1400h) is switched off");
  for (const contract::CanFrame& frame : fault_reset_frames(info.id, command_id)) {
    if (!line.send(frame)) return bus_refused("reset-fault", "the bus did not take the command: " + line.problem());
    line.listen(kFaultResetPace_s, {});
  }
  line.listen(0.1, {});  // its self-test, where that had failed
  state = read_drive(line, info.id);
  if (!state) return bus_refused("reset-fault", line.problem());
  print_drive(info.name, *state, request->json);
  return has_fault(*state) ? bus_refused("reset-fault", "the cause is still there: " + drive_words(0x603F, state->error)) : kDone;
}

}  // namespace hoist::tool
