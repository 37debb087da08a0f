// The REST interface as OpenAPI 3.1, made from api.def and the schemas beside it.
#pragma once
#include <nlohmann/json_fwd.hpp>

namespace hoist::server {

[[nodiscard]] nlohmann::json openapi_document();

}  // namespace hoist::server
