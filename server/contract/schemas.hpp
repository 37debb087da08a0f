// The JSON schemas of requests and answers, as one JSON object by name.
#pragma once
#include <nlohmann/json_fwd.hpp>

namespace hoist::server {

[[nodiscard]] const nlohmann::json& schemas();

}  // namespace hoist::server
