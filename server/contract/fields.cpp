#include "server/contract/fields.hpp"

#include <nlohmann/json.hpp>

#include "server/contract/schemas.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
const json& schemas() {
  static const json kSchemas = json::parse(schemas_text());
  return kSchemas;
}

// The part of a schema that speaks of objects: behind its reference, and of several choices the one with fields.
const json& object_part(const json& schema) {
  if (const auto at = schema.find("$ref"); at != schema.end()) {
    const auto& path = at->get_ref<const std::string&>();
    return object_part(schemas().at(path.substr(path.rfind('/') + 1)));
  }
  if (const auto at = schema.find("anyOf"); at != schema.end())
    for (const json& choice : *at)
      if (const json& part = object_part(choice); part.contains("properties")) return part;
  return schema;
}

void collect(const json& schema, const json& value, const std::string& where, std::vector<std::string>& unknown) {
  if (!value.is_object()) return;
  const json& part = object_part(schema);
  const auto properties = part.find("properties");
  const auto more = part.find("additionalProperties");
  for (const auto& [name, member] : value.items()) {
    if (properties != part.end() && properties->contains(name))
      collect(properties->at(name), member, where + name + ".", unknown);
    else if (more != part.end() && *more == false)
      unknown.push_back(where + name);
  }
}
}  // namespace

std::vector<std::string> unknown_fields(std::string_view schema, const json& body) {
  std::vector<std::string> unknown;
  if (const auto at = schemas().find(schema); at != schemas().end()) collect(*at, body, "", unknown);
  return unknown;
}

}  // namespace hoist::server
