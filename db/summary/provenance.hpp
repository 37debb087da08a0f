// Where a recording comes from, as the exports and REST tell it. What is not known is null.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "db/store/session_types.hpp"

namespace hoist::db {

/// Line ends and backslashes as \n, \r and \\, other control characters as spaces.
std::string on_one_line(std::string_view text);
/// 16 hexadecimal digits, as the status tells its own layout.
std::string layout_text(std::uint64_t layout_hash);
/// [{"name", "product", "revision", "version", "crc", "simulated"}]; product and crc as 8 hexadecimal digits, "revision" as "2.0".
nlohmann::json node_programs_json(std::span<const NodeProgram> nodes);
/// {"user", "role", "origin", "client"}, or null.
nlohmann::json actor_json(const std::optional<Actor>& actor);

}  // namespace hoist::db
