// Names for values of objects: states, status bits, error codes. For tools only.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "control/contract/can_dictionary.hpp"

namespace hoist::bus {

/// State in a heartbeat: "operational"; "unknown" for a value that CiA 301 does not have.
[[nodiscard]] std::string_view nmt_state_words(std::uint8_t state);
/// NMT command: "reset node".
[[nodiscard]] std::string_view nmt_command_words(std::uint8_t command);

/// Words for the raw value of an object: "operation enabled, supply, at rest". Empty where the number is enough.
[[nodiscard]] std::string object_words(contract::NodeKind kind, std::uint16_t index, std::uint8_t sub, std::uint32_t raw);

}  // namespace hoist::bus
