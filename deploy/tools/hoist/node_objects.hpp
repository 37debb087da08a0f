// Objects of nodes as a person writes and reads them: names or numbers, units, ranges. No bus in here.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "control/contract/can_dictionary.hpp"

namespace hoist::tool {

/// "drive_left", "1", "0x11": a node of the table, not the control computer. Empty with a sentence in `error`.
[[nodiscard]] std::optional<contract::Node> parse_node(std::string_view text, std::string& error);

/// "velocity_gain", "2200:1", "2200h:1", "0x2200:1", "6041": an object of this node's kind.
[[nodiscard]] const contract::ObjectInfo* parse_object(contract::Node node, std::string_view text, std::string& error);

/// "2200h:1 velocity_gain".
[[nodiscard]] std::string object_text(const contract::ObjectInfo& object);

/// The value in the object's unit; raw is what travels, zero extended. NaN and infinities stay what they are.
[[nodiscard]] double physical_value(const contract::ObjectInfo& object, std::uint32_t raw);
/// "0.12 V s/rad"; whole numbers that are identifiers or bit fields as they are.
[[nodiscard]] std::string value_text(const contract::ObjectInfo& object, std::uint32_t raw);
/// "0 to 5 V s/rad".
[[nodiscard]] std::string range_text(const contract::ObjectInfo& object);

/// A decimal number in the object's unit, or a hexadecimal raw value (0x...). Refused: not a number, out of the table's range, or between
/// two steps.
[[nodiscard]] std::optional<std::uint32_t> parse_value(const contract::ObjectInfo& object, std::string_view text, std::string& error);

/// Whether the node has it for others to write back: parameters, not commands and not process data.
[[nodiscard]] inline bool is_parameter(const contract::ObjectInfo& object) { return contract::is_stored(object); }

}  // namespace hoist::tool
