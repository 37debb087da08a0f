#include "tests/unit/server/schema.hpp"

#include <nlohmann/json.hpp>

namespace hoist::test {

using nlohmann::json;

namespace {
bool is_type(const json& value, const std::string& type) {
  if (type == "object") return value.is_object();
  if (type == "array") return value.is_array();
  if (type == "string") return value.is_string();
  if (type == "boolean") return value.is_boolean();
  if (type == "null") return value.is_null();
  if (type == "integer") return value.is_number_integer();
  return type == "number" && value.is_number();
}
}  // namespace

std::string mismatch(const json& document, const json& schema, const json& value, const std::string& where) {
  if (schema.contains("$ref")) {
    const std::string path = schema["$ref"].get<std::string>().substr(1);
    return mismatch(document, document.at(json::json_pointer(path)), value, where);
  }
  if (schema.contains("const") && schema["const"] != value) return where + " is not " + schema["const"].dump();
  if (schema.contains("enum")) {
    bool found = false;
    for (const json& allowed : schema["enum"]) found = found || allowed == value;
    if (!found) return where + " is not one of " + schema["enum"].dump();
  }
  if (schema.contains("anyOf")) {
    std::string last;
    bool found = false;
    for (const json& option : schema["anyOf"]) {
      last = mismatch(document, option, value, where);
      found = found || last.empty();
    }
    if (!found) return last;
  }
  if (schema.contains("type")) {
    const json types = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
    bool found = false;
    for (const json& type : types) found = found || is_type(value, type.get<std::string>());
    if (!found) return where + " is not of type " + types.dump() + ": " + value.dump();
  }
  if (value.is_object()) {
    static const json kNone = json::object();
    const json& required = schema.contains("required") ? schema["required"] : kNone;
    const json& properties = schema.contains("properties") ? schema["properties"] : kNone;
    for (const json& name : required)
      if (!value.contains(name.get<std::string>())) return where + " lacks " + name.get<std::string>();
    for (const auto& [name, member] : value.items()) {
      if (properties.contains(name)) {
        if (std::string why = mismatch(document, properties[name], member, where + "." + name); !why.empty()) return why;
      } else if (schema.contains("additionalProperties")) {
        const json& more = schema["additionalProperties"];
        if (more == false) return where + " has an unlisted member " + name;
        if (more.is_object())
          if (std::string why = mismatch(document, more, member, where + "." + name); !why.empty()) return why;
      }
    }
  }
  if (value.is_array() && schema.contains("items")) {
    std::size_t i = 0;
    for (const json& item : value)
      if (std::string why = mismatch(document, schema["items"], item, where + "[" + std::to_string(i++) + "]"); !why.empty()) return why;
  }
  return "";
}

}  // namespace hoist::test
