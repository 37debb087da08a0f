// What a request's body may hold, from the same schemas that describe it.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace hoist::server {

// The fields of `body`, at any depth ("path.sped"), that a schema of that name does not know.
[[nodiscard]] std::vector<std::string> unknown_fields(std::string_view schema, const nlohmann::json& body);

}  // namespace hoist::server
