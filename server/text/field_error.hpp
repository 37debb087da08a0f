// What is wrong with one field of a request: which one, what was given, what is allowed. The same in REST and over the WebSocket.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace hoist::server {

struct FieldError {
  std::string field;
  std::string message;
  std::optional<double> value = {};
  std::optional<double> min = {};
  std::optional<double> max = {};
};

[[nodiscard]] nlohmann::json to_json(const std::vector<FieldError>& errors);

}  // namespace hoist::server
