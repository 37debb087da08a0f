// How REST tells a refusal (RFC 9457).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/exchange.hpp"
#include "server/text/field_error.hpp"

namespace hoist::server {

struct Problem {
  unsigned status = 500;
  std::string name;  // the last part of `type`, for programs
  std::string title;
  std::string detail;  // what to do next, for people
  std::vector<FieldError> errors = {};
  std::vector<std::string> refusals = {};
};

[[nodiscard]] Response problem_response(const Problem& problem, std::string_view instance);
[[nodiscard]] Response json_response(const nlohmann::json& value, unsigned status = 200);

}  // namespace hoist::server
