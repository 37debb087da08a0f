#include "server/contract/openapi.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "server/contract/routes.hpp"
#include "server/contract/schemas.hpp"
#include "server/contract/status_phrase.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
json reference(std::string_view name) { return {{"$ref", "#/components/schemas/" + std::string{name}}}; }

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
  return out;
}

// Every status that a route may answer besides its own success, see api.def.
std::set<std::string> errors_of(const Route& route) {
  std::set<std::string> codes{"400", "405", "408", "421", "431", "500"};
  std::string_view rest = route.errors;
  while (!rest.empty()) {
    const std::size_t space = rest.find(' ');
    codes.emplace(rest.substr(0, space));
    rest = space == std::string_view::npos ? std::string_view{} : rest.substr(space + 1);
  }
  if (route.access != Access::open) codes.insert({"401", "403"});
  if (takes_body(route)) codes.insert({"413", "415", "422"});
  if (route.operation == "stop") codes.insert("413");
  return codes;
}

// "1..200" = least and most, "a|b" = the choices.
json input_schema(const RouteInput& input) {
  json schema{{"type", input.type.empty() ? "string" : input.type}};
  std::string_view allowed = input.allowed;
  if (const std::size_t dots = allowed.find(".."); dots != std::string_view::npos) {
    schema["minimum"] = std::stoi(std::string{allowed.substr(0, dots)});
    schema["maximum"] = std::stoi(std::string{allowed.substr(dots + 2)});
  } else if (!allowed.empty()) {
    for (std::size_t bar = allowed.find('|'); bar != std::string_view::npos; bar = allowed.find('|')) {
      schema["enum"].push_back(allowed.substr(0, bar));
      allowed.remove_prefix(bar + 1);
    }
    schema["enum"].push_back(allowed);
  }
  return schema;
}

json parameters_of(const Route& route) {
  json list = json::array();
  std::string_view rest = route.path;
  for (std::size_t open = rest.find('{'); open != std::string_view::npos; open = rest.find('{')) {
    const std::size_t close = rest.find('}', open);
    const std::string name{rest.substr(open + 1, close - open - 1)};
    list.push_back({{"name", name},
                    {"in", "path"},
                    {"required", true},
                    {"schema", {{"type", name == "id" || name == "number" ? "integer" : "string"}}}});
    rest = rest.substr(close + 1);
  }
  for (const RouteInput& input : kRouteInputs) {
    if (input.operation != route.operation) continue;
    const bool header = input.type.empty();
    list.push_back({{"name", input.name},
                    {"in", header ? "header" : "query"},
                    {"required", input.required},
                    {"description", input.summary},
                    {"schema", input_schema(input)}});
  }
  return list;
}

// Of a row that can be edited and of the parameters: with every good answer. Of files: with those that can be read in parts.
json tag_header(const Route& route) {
  static const json all = schemas();
  const json properties = all.value(std::string{route.response}, json::object()).value("properties", json::object());
  const bool edited = properties.contains("etag") || route.response == "Parameter" || route.response == "ParameterList" ||
                      route.response == "ParameterResult";
  if (!edited && route.errors.find("206") == route.errors.npos) return nullptr;
  return {{"description",
           edited ? "Of the state that this answer shows, for If-Match" : "Of the file, for If-Match, If-Range and If-None-Match"},
          {"required", edited},
          {"schema", {{"type", "string"}}}};
}

json operation_of(const Route& route) {
  json operation{{"operationId", route.operation}, {"summary", route.summary}};
  operation["x-role"] = access_name(route.access);
  if (route.access == Access::open) operation["security"] = json::array();
  if (json inputs = parameters_of(route); !inputs.empty()) operation["parameters"] = std::move(inputs);
  if (route.request.find('/') != std::string_view::npos)
    operation["requestBody"] = {{"required", true}, {"content", {{std::string{route.request}, json::object()}}}};
  else if (takes_body(route))
    operation["requestBody"] = {{"required", !body_may_be_empty(route)},
                                {"content", {{"application/json", {{"schema", reference(route.request)}}}}}};
  json success{{"description", route.success == 101 ? "The connection is a WebSocket from here" : "Done"}};
  if (route.operation == "export_session") {
    for (const db::ExportFormatInfo& format : db::kExportFormats) {
      const std::string_view type = format.media_type.substr(0, format.media_type.find(';'));
      success["content"][std::string{type}] = {{"schema", {{"type", type == "application/json" ? "object" : "string"}}}};
    }
  } else if (route.operation == "get_job_file") {
    for (const db::BundleLayoutInfo& layout : db::kBundleLayouts)
      success["content"][std::string{layout.media_type}] = {{"schema", {{"type", "string"}}}};
  } else if (route.response.find('/') != std::string_view::npos) {
    success["content"][std::string{route.response}] = {{"schema", {{"type", "string"}}}};
  } else if (!route.response.empty()) {
    success["content"]["application/json"] = {{"schema", reference(route.response)}};
  }
  if (json tag = tag_header(route); !tag.is_null()) success["headers"]["ETag"] = std::move(tag);
  json responses{{std::to_string(route.success), std::move(success)}};
  for (const std::string& code : errors_of(route)) {
    json answer{{"description", reason_phrase(static_cast<unsigned>(std::stoul(code)))}};
    if (code == "206")
      for (const char* part : {"content", "headers"}) answer[part] = responses[std::to_string(route.success)][part];
    else if (code != "304")
      answer["content"]["application/problem+json"] = {{"schema", reference("Problem")}};
    responses[code] = std::move(answer);
  }
  operation["responses"] = std::move(responses);
  return operation;
}
}  // namespace

json openapi_document() {
  json document{{"openapi", "3.1.0"},
                {"info",
                 {{"title", "Hoist"},
                  {"version", "1"},
                  {"description",
                   "Control system of a motorised walking-rehabilitation aid. SI units; a name ends with its unit. Frames: x forward, y "
                   "left, z up. Errors are problem+json (RFC 9457). "
                   "GET routes also answer HEAD. Unsafe methods by cookie need the header X-Hoist: 1."}}},
                {"servers", json::array({{{"url", "/"}}})},
                {"security", json::array({{{"bearer", json::array()}}, {{"cookie", json::array()}}})}};
  json paths = json::object();
  for (const Route& route : kRoutes) paths[std::string{route.path}][lower(method_name(route.method))] = operation_of(route);
  document["paths"] = std::move(paths);
  document["components"] = {{"schemas", schemas()},
                            {"securitySchemes",
                             {{"bearer", {{"type", "http"}, {"scheme", "bearer"}, {"description", "The token of --token-file"}}},
                              {"cookie",
                               {{"type", "apiKey"},
                                {"in", "cookie"},
                                {"name", "hoist_session"},
                                {"description", "Set by opening the link that the terminal shows"}}}}}};
  return document;
}

}  // namespace hoist::server
