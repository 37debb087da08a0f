#include "server/http/problem.hpp"

#include <nlohmann/json.hpp>

#include "server/http/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

json to_json(const std::vector<FieldError>& errors) {
  json list = json::array();
  for (const FieldError& e : errors) {
    json row{{"field", e.field}, {"message", e.message}};
    if (e.value) row["value"] = *e.value;
    if (e.min) row["min"] = *e.min;
    if (e.max) row["max"] = *e.max;
    list.push_back(std::move(row));
  }
  return list;
}

Response problem_response(const Problem& problem, std::string_view instance) {
  json body{{"type", "/problems/" + problem.name},
            {"title", problem.title},
            {"status", problem.status},
            {"detail", problem.detail},
            {"instance", instance}};
  if (!problem.errors.empty()) body["errors"] = to_json(problem.errors);
  if (!problem.refusals.empty()) body["refusals"] = problem.refusals;
  Response response;
  response.status = problem.status;
  response.content_type = "application/problem+json";
  response.body = dump_json(body);
  return response;
}

Response json_response(const json& value, unsigned status) {
  Response response;
  response.status = status;
  response.content_type = "application/json";
  response.body = dump_json(value);
  return response;
}

}  // namespace hoist::server
