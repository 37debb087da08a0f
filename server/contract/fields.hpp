// What a request's body may hold, from the same schemas that describe it: the only check of types, ranges and choices before a handler.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

#include "server/text/field_error.hpp"

namespace hoist::server {

// Everything in which `body` differs from the schema of that name (schemas.hpp), each field by its path ("path.side_m", "seen.0"; "body" for
// the whole) with the range it may have. Lengths of texts are counted in characters. Empty for an unknown schema and for a body that fits.
[[nodiscard]] std::vector<FieldError> wrong_fields(std::string_view schema, const nlohmann::json& body);

}  // namespace hoist::server
