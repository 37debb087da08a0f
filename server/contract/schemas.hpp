// The JSON schemas of requests and answers, as one JSON object by name.
#pragma once
#include <string_view>

namespace hoist::server {

[[nodiscard]] std::string_view schemas_text();

}  // namespace hoist::server
