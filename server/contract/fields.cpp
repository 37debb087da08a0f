#include "server/contract/fields.hpp"

#include <nlohmann/json.hpp>

#include "server/contract/schemas.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
// Whether an object has the fixed values of a schema, such as its shape.
bool has_constants(const json& part, const json& object) {
  for (const auto& [name, member] : part.at("properties").items())
    if (const auto fixed = member.find("const"); fixed != member.end() && object.value(name, json()) != *fixed) return false;
  return true;
}

// The part of a schema that speaks of this object: behind its reference, and of several choices the one whose fixed values it has.
const json& object_part(const json& schema, const json& object) {
  if (const auto at = schema.find("$ref"); at != schema.end()) {
    const auto& path = at->get_ref<const std::string&>();
    return object_part(schemas().at(path.substr(path.rfind('/') + 1)), object);
  }
  if (const auto at = schema.find("anyOf"); at != schema.end())
    for (const json& choice : *at)
      if (const json& part = object_part(choice, object); part.contains("properties") && has_constants(part, object)) return part;
  return schema;
}

void collect(const json& schema, const json& value, const std::string& where, std::vector<std::string>& unknown) {
  if (!value.is_object()) return;
  const json& part = object_part(schema, value);
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
