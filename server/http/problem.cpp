#include "server/http/problem.hpp"

#include <nlohmann/json.hpp>

#include "server/text/json_text.hpp"

namespace hoist::server {

using nlohmann::json;

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
