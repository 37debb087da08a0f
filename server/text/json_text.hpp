// JSON from outside: bounded in size by the caller, in depth here, before the parser sees it.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace hoist::server {

// Deeper than any message of ours. A parsed value nested 100 000 deep would overflow the stack when copied, so it is never built.
inline constexpr std::size_t kJsonDepthLimit = 8;

struct JsonError {
  std::size_t position = 0;  // byte in the text, from 1
  std::string message;
};

// The value, or nothing with the reason in `error`. NaN, infinities, numbers beyond double and invalid UTF-8 are refused.
[[nodiscard]] std::optional<nlohmann::json> parse_json(std::string_view text, JsonError& error);
// The first name that an object of this text gives twice, of which a parser silently keeps one. For text that `parse_json` has read.
[[nodiscard]] std::optional<std::string> repeated_name(std::string_view text);
// Compact text. Bytes that are not UTF-8 become U+FFFD instead of an exception.
[[nodiscard]] std::string dump_json(const nlohmann::json& value);

}  // namespace hoist::server
