// A validator for the part of JSON Schema that our OpenAPI uses. Independent of the server's code.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace hoist::test {

// Empty when `value` fits `schema`, otherwise where it does not. `document` resolves $ref.
std::string mismatch(const nlohmann::json& document, const nlohmann::json& schema, const nlohmann::json& value,
                     const std::string& where = "$");

}  // namespace hoist::test
