#include "control/bus/object_words.hpp"

#include <array>
#include <span>

#include "control/contract/emergencies.hpp"

namespace hoist::bus {

using contract::NodeKind;
namespace canopen = contract::canopen;

namespace {

using Words = std::span<const std::string_view>;

void add(std::string& text, std::string_view word) {
  if (!text.empty()) text += ", ";
  text += word;
}
// Names of the set bits; bits without a name are left out.
std::string bits(std::uint32_t raw, Words words, std::string_view none) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (((raw >> i) & 1U) != 0 && !words[i].empty()) add(text, words[i]);
  return text.empty() ? std::string(none) : text;
}
std::string one_of(std::uint32_t raw, Words words) { return raw < words.size() ? std::string(words[raw]) : "unknown"; }

// CiA 402, table of the statusword. Meaning of the other bits: firmware/nodes/drive/drive_node.hpp, publish().
std::string status_word(std::uint32_t raw) {
  constexpr std::array<std::string_view, 8> kStates{"not ready",         "switch-on disabled", "ready to switch on", "switched on",
                                                    "operation enabled", "quick stop active",  "fault reaction",     "fault"};
  constexpr std::array<std::string_view, 13> kBits{
      "", "", "", "", "supply", "", "", "warning: current limit reduced", "", "remote", "target reached", "current limited", "at rest"};
  std::string text(kStates[static_cast<std::size_t>(canopen::drive::state(static_cast<std::uint16_t>(raw)))]);
  if (const std::string more = bits(raw, kBits, ""); !more.empty()) add(text, more);
  return text;
}

// CiA 402, table of the commands in the controlword.
std::string control_word(std::uint32_t raw) {
  std::string text;
  if ((raw & 0x80U) != 0)
    text = "fault reset";
  else if ((raw & 0x02U) == 0)
    text = "disable voltage";
  else if ((raw & 0x04U) == 0)
    text = "quick stop";
  else if ((raw & 0x01U) == 0)
    text = "shutdown";
  else
    text = (raw & 0x08U) == 0 ? "switch on" : "enable operation";
  if ((raw & 0x100U) != 0) add(text, "halt");
  return text;
}

std::string error_code(std::uint32_t code) {
  return code == 0 ? "none" : std::string(contract::emergency_info(static_cast<std::uint16_t>(code)).text_en);
}

std::string common_words(std::uint16_t index, std::uint8_t sub, std::uint32_t raw) {
  // CiA 301, table of the error register.
  constexpr std::array<std::string_view, 6> kErrors{"error", "current", "voltage", "temperature", "communication", "profile"};
  constexpr std::array<std::string_view, 4> kResets{"power", "pin", "watchdog", "software"};
  constexpr std::array<std::string_view, 4> kCan{"active", "warning", "passive", "bus off"};
  constexpr std::array<std::string_view, 3> kBehaviour{"pre-operational", "no change", "stopped"};
  if (index == 0x1001) return bits(raw, kErrors, "no error");
  if (index == 0x1003 && sub > 0) return error_code(raw & 0xFFFFU);
  if (index == 0x1017 && raw == 0) return "off";
  if (index == 0x1029) return one_of(raw, kBehaviour);
  if (index == 0x2221) return one_of(raw, kResets);
  if (index == 0x2300 && sub == 1) return one_of(raw, kCan);
  return {};
}

std::string drive_words(std::uint16_t index, std::uint8_t sub, std::uint32_t raw) {
  constexpr std::array<std::string_view, 7> kSelfTest{"under way", "current sensor", "readings", "bridge driver",
                                                      "encoder",   "parameters",     "watchdog"};
  if (index == 0x6041) return status_word(raw);
  if (index == 0x6040) return control_word(raw);
  if (index == 0x603F || (index == 0x2240 && sub == 1)) return error_code(raw);
  if (index == 0x605A) return raw == 6 ? "ramp, then hold" : "ramp, then off";
  if (index == 0x6060 || index == 0x6061) return raw == 3 ? "profile velocity" : "";
  if (index == 0x2251) return bits(raw, kSelfTest, "passed");
  return {};
}

std::string tilt_words(std::uint16_t index, std::uint32_t raw) {
  constexpr std::array<std::string_view, 6> kStatus{"valid",          "converged",        "acceleration out of range",
                                                    "gyro saturated", "self-test failed", "sensor missing"};
  if (index != 0x2120) return {};
  const std::string text = bits(raw, kStatus, "");
  return (raw & 1U) != 0 ? text : text.empty() ? "not valid" : "not valid, " + text;
}

std::string io_words(std::uint16_t index, std::uint8_t sub, std::uint32_t raw) {
  constexpr std::array<std::string_view, 4> kBumpers{"front", "rear", "left", "right"};
  constexpr std::array<std::string_view, 4> kSwitches{"emergency stop open", "switch 1", "switch 2", "switch 3"};
  if (index == 0x6000 && sub == 1) return bits(raw, kBumpers, "none pressed");
  if (index == 0x6000 && sub == 2) return bits(raw, kSwitches, "none");
  return {};
}

}  // namespace

std::string_view nmt_state_words(std::uint8_t state) {
  switch (static_cast<canopen::NmtState>(state)) {
    case canopen::NmtState::boot_up:
      return "boot-up";
    case canopen::NmtState::stopped:
      return "stopped";
    case canopen::NmtState::operational:
      return "operational";
    case canopen::NmtState::pre_operational:
      return "pre-operational";
  }
  return "unknown";
}

std::string_view nmt_command_words(std::uint8_t command) {
  switch (static_cast<canopen::NmtCommand>(command)) {
    case canopen::NmtCommand::start:
      return "start";
    case canopen::NmtCommand::stop:
      return "stop";
    case canopen::NmtCommand::pre_operational:
      return "pre-operational";
    case canopen::NmtCommand::reset_node:
      return "reset node";
    case canopen::NmtCommand::reset_communication:
      return "reset communication";
  }
  return "unknown";
}

std::string object_words(NodeKind kind, std::uint16_t index, std::uint8_t sub, std::uint32_t raw) {
  if (std::string text = common_words(index, sub, raw); !text.empty()) return text;
  switch (kind) {
    case NodeKind::drive:
      return drive_words(index, sub, raw);
    case NodeKind::tilt:
      return tilt_words(index, raw);
    case NodeKind::io:
      return io_words(index, sub, raw);
    case NodeKind::host:
      break;
  }
  return {};
}

}  // namespace hoist::bus
