// What a refusal says: which field, what was given, what is allowed (RFC 9457 for REST, the same fields in a WebSocket reply).
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/exchange.hpp"

namespace hoist::server {

struct FieldError {
  std::string field;
  std::string message;
  std::optional<double> value = {};
  std::optional<double> min = {};
  std::optional<double> max = {};
};

struct Problem {
  unsigned status = 500;
  std::string name;  // the last part of `type`, for programs
  std::string title;
  std::string detail;  // what to do next, for people
  std::vector<FieldError> errors = {};
  std::vector<std::string> refusals = {};
};

[[nodiscard]] nlohmann::json to_json(const std::vector<FieldError>& errors);
[[nodiscard]] Response problem_response(const Problem& problem, std::string_view instance);
[[nodiscard]] Response json_response(const nlohmann::json& value, unsigned status = 200);

}  // namespace hoist::server
