// The requests and answers of REST as types of the console: from the routes and schemas that OpenAPI is made of.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "deploy/tools/gen/generate.hpp"
#include "server/contract/openapi.hpp"

namespace hoist::gen {
namespace {

using nlohmann::json;

std::string type_of(const json& schema, const std::string& indent);

std::string doc_of(const json& schema, const std::string& indent) {
  const auto text = schema.find("description");
  return text == schema.end() ? "" : indent + "/** " + text->get<std::string>() + ". */\n";
}

bool is_required(const json& schema, const std::string& name) {
  const auto list = schema.find("required");
  return list != schema.end() && std::find(list->begin(), list->end(), name) != list->end();
}

std::string object_type(const json& schema, const std::string& indent) {
  const std::string inner = indent + "  ";
  const json properties = schema.value("properties", json::object());
  const auto more = schema.find("additionalProperties");
  const bool named = more != schema.end() && more->is_object();
  if (properties.empty()) return named ? "Record<string, " + type_of(*more, indent) + ">" : "Record<string, never>";
  std::string out = "{\n";
  for (const auto& [name, member] : properties.items())
    out += doc_of(member, inner) + inner + name + (is_required(schema, name) ? ": " : "?: ") + type_of(member, inner) + ";\n";
  if (named) out += inner + "[name: string]: " + type_of(*more, inner) + " | undefined;\n";
  return out + indent + "}";
}

std::string array_type(const json& schema, const std::string& indent) {
  const std::string item = schema.contains("items") ? type_of(schema["items"], indent) : "unknown";
  return item.find(" | ") == std::string::npos ? "readonly " + item + "[]" : "readonly (" + item + ")[]";
}

std::string plain_type(const std::string& type, const json& schema, const std::string& indent) {
  if (type == "object") return object_type(schema, indent);
  if (type == "array") return array_type(schema, indent);
  return type == "integer" ? "number" : type;
}

std::string literal(const json& value) { return value.is_string() ? gen::quoted(value.get<std::string>()) : value.dump(); }

// The choices of a list, each turned to text.
std::string choice(const json& list, const auto& text) {
  std::string out;
  for (const json& one : list) out += (out.empty() ? "" : " | ") + text(one);
  return out;
}

std::string type_of(const json& schema, const std::string& indent) {
  if (const auto at = schema.find("$ref"); at != schema.end()) {
    const auto path = at->get<std::string>();
    return path.substr(path.rfind('/') + 1);
  }
  if (const auto at = schema.find("const"); at != schema.end()) return literal(*at);
  if (const auto at = schema.find("enum"); at != schema.end()) return choice(*at, literal);
  if (const auto at = schema.find("anyOf"); at != schema.end()) return choice(*at, [&](const json& one) { return type_of(one, indent); });
  const auto type = schema.find("type");
  if (type == schema.end()) return "unknown";
  if (type->is_array()) return choice(*type, [&](const json& one) { return plain_type(one.get<std::string>(), schema, indent); });
  return plain_type(type->get<std::string>(), schema, indent);
}

std::string inputs(const json& operation, std::string_view where, const char* member) {
  std::string out;
  bool required = false;
  for (const json& input : operation.value("parameters", json::array())) {
    if (input["in"] != where) continue;
    required = required || input["required"];
    out += (out.empty() ? "" : "; ") + input["name"].get<std::string>() + (input["required"] ? ": " : "?: ") + type_of(input["schema"], "");
  }
  return out.empty() ? "" : std::string("    ") + member + (required ? ": { " : "?: { ") + out + " };\n";
}

// The JSON of a body or an answer; "" without one, `never` for what is no JSON.
std::string content_type(const json& place) {
  const auto content = place.find("content");
  if (content == place.end()) return "";
  const auto as_json = content->find("application/json");
  return as_json == content->end() || !(*as_json)["schema"].contains("$ref") ? "never" : type_of((*as_json)["schema"], "");
}

std::string route_type(const std::string& method, const std::string& path, const json& operation) {
  std::string out = "  /** " + operation["summary"].get<std::string>() + ". */\n  '" + method + " " + path + "': {\n";
  out += inputs(operation, "path", "path") + inputs(operation, "query", "query");
  if (const auto body = operation.find("requestBody"); body != operation.end())
    out += std::string("    body") + ((*body)["required"] ? ": " : "?: ") + content_type(*body) + ";\n";
  for (const json& input : operation.value("parameters", json::array()))
    if (input["name"] == "If-Match") out += "    etag: string | null;\n";
  const json& responses = operation["responses"];
  const auto good = std::find_if(responses.items().begin(), responses.items().end(), [](const auto& row) { return row.key()[0] == '2'; });
  const std::string answer = good == responses.items().end() ? "never" : content_type(good.value());
  return out + "    answer: " + (answer.empty() ? "null" : answer) + ";\n  };\n";
}

std::string upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

}  // namespace

GeneratedFile rest_file() {
  const json document = server::openapi_document();
  std::string out = "// " + made_from("server/contract/api.def and schemas.cpp") + "\n\n";
  for (const auto& [name, schema] : document["components"]["schemas"].items())
    out += doc_of(schema, "") + "export type " + name + " = " + type_of(schema, "") + ";\n\n";
  out +=
      "/** Every route under /api/v1, with what it takes and what it answers: `never` where that is no JSON. */\nexport interface Routes "
      "{\n";
  for (const auto& [path, methods] : document["paths"].items())
    if (path.rfind("/api/v1/", 0) == 0)
      for (const auto& [method, operation] : methods.items()) out += route_type(upper(method), path, operation);
  return {"web/src/contract/rest.gen.ts", out + "}\n"};
}

}  // namespace hoist::gen
