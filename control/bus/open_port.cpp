// From words to a back end.
#include <charconv>
#include <utility>

#include "control/bus/can_port.hpp"
#include "control/bus/replay.hpp"
#include "control/bus/slcan.hpp"
#include "control/bus/socketcan.hpp"

namespace hoist::bus {
namespace {

std::unique_ptr<CanPort> open_slcan(std::string_view rest, std::string& error) {
  std::uint32_t baud = SlcanPort::kDefaultBaud;
  if (const std::size_t at = rest.rfind('@'); at != std::string_view::npos) {
    const std::string_view rate = rest.substr(at + 1);
    const auto [end, problem] = std::from_chars(rate.data(), rate.data() + rate.size(), baud);
    if (problem != std::errc{} || end != rate.data() + rate.size() || !SlcanPort::valid_baud(baud)) {
      error = "slcan: the rate of the serial line must be one of " + SlcanPort::baud_list() + ", not \"" + std::string(rate) + "\"";
      return nullptr;
    }
    rest = rest.substr(0, at);
  }
  if (rest.empty()) {
    error = "slcan: needs a device, for example slcan:/dev/ttyUSB0";
    return nullptr;
  }
  return std::make_unique<SlcanPort>(std::string(rest), baud);
}

std::unique_ptr<CanPort> open_socketcan(std::string_view rest, PortUse use, std::string& error) {
  if (!SocketCanPort::valid_interface_name(rest)) {
    error = "socketcan: needs the name of an interface, 1 to 15 characters, for example socketcan:can0";
    return nullptr;
  }
  error = SocketCanPort::kernel_problem();
  return error.empty() ? std::make_unique<SocketCanPort>(rest, use) : nullptr;
}

std::unique_ptr<CanPort> open_replay(std::string_view rest, std::string& error) {
  std::vector<LogEntry> entries;
  error = rest.empty() ? "replay: needs a file in candump's log format" : read_log(std::string(rest), entries);
  return error.empty() ? std::make_unique<ReplayPort>(std::move(entries)) : nullptr;
}

}  // namespace

std::unique_ptr<CanPort> open_port(std::string_view address, std::string& error, PortUse use) {
  const std::size_t colon = address.find(':');
  const std::string_view kind = address.substr(0, colon);
  const std::string_view rest = colon == std::string_view::npos ? std::string_view{} : address.substr(colon + 1);
  if (colon != std::string_view::npos) {
    if (kind == "slcan") return open_slcan(rest, error);
    if (kind == "socketcan") return open_socketcan(rest, use, error);
    if (kind == "replay") return open_replay(rest, error);
    if (kind == "sim") {
      error = "sim: is lock-step with hoist-sim, whose steps only hoist-control takes";
      return nullptr;
    }
  }
  error = "unknown bus \"" + std::string(address) +
          "\": use socketcan:INTERFACE (socketcan:can0), slcan:DEVICE (slcan:/dev/ttyUSB0) or replay:FILE";
  return nullptr;
}

}  // namespace hoist::bus
