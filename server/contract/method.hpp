// The methods of HTTP that the server knows.
#pragma once
#include <cstdint>
#include <string_view>

namespace hoist::server {

enum class Method : std::uint8_t { get, head, post, put, patch, del, other };
[[nodiscard]] std::string_view method_name(Method method);
[[nodiscard]] Method parse_method(std::string_view text);

}  // namespace hoist::server
