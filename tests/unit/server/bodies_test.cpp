// Bodies that break one rule of their schema each, made from the schemas themselves: every route refuses every one before it does anything.
#include <string>
#include <vector>

#include "server/contract/routes.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

struct Attack {
  json body;
  std::string field;  // that the refusal must name
  std::string rule;
};

// Makes bodies out of the schemas of an OpenAPI document.
class Maker {
 public:
  explicit Maker(const json& document) : document_(document) {}

  // A value that the schema allows, with everything in it that may be left out.
  json valid(const json& schema) const {
    const json& s = resolved(schema);
    if (s.contains("anyOf")) return valid(s["anyOf"][0]);
    if (s.contains("const")) return s["const"];
    if (s.contains("enum")) return s["enum"][0];
    const std::string type = types(s)[0];
    if (type == "boolean") return true;
    if (type == "integer") return s.value("minimum", 1);
    if (type == "number") return s.value("minimum", s.value("maximum", 0.0));
    if (type == "string") return std::string(s.value("minLength", std::size_t{1}), 'x');
    if (type == "array") return std::vector<json>(s.value("minItems", std::size_t{1}), valid(s["items"]));
    json object = json::object();
    const json members = s.value("properties", json::object());
    for (const auto& [name, member] : members.items()) object[name] = valid(member);
    if (const json more = s.value("additionalProperties", json(false)); more.is_object()) object["any"] = valid(more);
    return object;
  }

  // Every way to break one rule of the schema, the rest of the value valid.
  std::vector<Attack> attacks(const json& schema, const std::string& where = "") const {
    std::vector<Attack> all;
    const json& s = resolved(schema);
    const json good = valid(s);
    const auto add = [&](json value, const std::string& rule, std::string field) {
      all.push_back({std::move(value), field.empty() ? "body" : std::move(field), rule});
    };
    if (s.contains("anyOf")) {
      add(wrong_type(s), "anyOf", where);
      for (const json& choice : s["anyOf"])
        for (Attack& attack : attacks(choice, where))
          // A value of no choice's type is what the line above asks; another type may be another choice's.
          if (attack.rule != "type" || attack.field != where) all.push_back(std::move(attack));
      return all;
    }
    for (const auto& [rule, limit] : s.items()) {
      if (rule == "type") {
        add(wrong_type(s), rule, where);
      } else if (rule == "enum" || rule == "const") {
        add("none of these", rule, where);
      } else if (rule == "minimum") {
        add(limit.is_number_integer() ? json(limit.get<std::int64_t>() - 1) : json(limit.get<double>() - 1), rule, where);
      } else if (rule == "maximum") {
        add(limit.is_number_integer() ? json(limit.get<std::int64_t>() + 1) : json(limit.get<double>() + 1), rule, where);
      } else if (rule == "minLength") {
        add(std::string(limit.get<std::size_t>() - 1, 'x'), rule, where);
      } else if (rule == "maxLength") {
        add(std::string(limit.get<std::size_t>() + 1, 'x'), rule, where);
      } else if (rule == "minItems") {
        add(std::vector<json>(limit.get<std::size_t>() - 1, valid(s["items"])), rule, where);
      } else if (rule == "maxItems") {
        add(std::vector<json>(limit.get<std::size_t>() + 1, valid(s["items"])), rule, where);
      } else if (rule == "minProperties") {
        add(json::object(), rule, where);
      } else if (rule == "maxProperties") {
        json all_of_them = json::object();
        if (s.contains("properties")) {
          for (const auto& [name, member] : s["properties"].items()) all_of_them[name] = valid(resolved(member));
        } else {
          for (std::size_t i = 0; i <= limit.get<std::size_t>(); ++i)
            all_of_them["any" + std::to_string(i)] = valid(s["additionalProperties"]);
        }
        add(std::move(all_of_them), rule, where);
      } else if (rule == "required") {
        for (const json& name : limit) add(without(good, name), rule, below(where, name));
      } else if (rule == "properties") {
        for (const auto& [name, member] : limit.items()) put_in(all, good, name, attacks(member, below(where, name)));
      } else if (rule == "additionalProperties" && limit == false) {
        add(with(good, "unlisted", 1), rule, below(where, "unlisted"));
      } else if (rule == "additionalProperties") {
        put_in(all, good, "any", attacks(limit, below(where, "any")));
      } else if (rule == "items") {
        for (Attack& attack : attacks(limit, below(where, "0"))) add(json::array({attack.body}), attack.rule, attack.field);
      } else {
        EXPECT_EQ(rule, "description") << "no attack is known for this rule: is it checked at all?";
      }
    }
    return all;
  }

 private:
  const json& resolved(const json& schema) const {
    return schema.contains("$ref") ? resolved(document_.at(json::json_pointer(schema["$ref"].get<std::string>().substr(1)))) : schema;
  }
  std::vector<std::string> types(const json& schema) const {
    const json& s = resolved(schema);
    std::vector<std::string> all;
    for (const json& choice : s.value("anyOf", json::array()))
      for (std::string& type : types(choice)) all.push_back(std::move(type));
    if (s.contains("type")) {
      if (s["type"].is_string()) return {s["type"]};
      return s["type"];
    }
    return all;
  }
  // Not of a type that the schema allows, and no text, which a choice of texts would refuse as another rule.
  json wrong_type(const json& schema) const {
    const std::vector<std::string> allowed = types(schema);
    return std::ranges::find(allowed, "boolean") == allowed.end() ? json(true) : json(7.5);
  }
  static std::string below(const std::string& where, const std::string& name) { return where.empty() ? name : where + "." + name; }
  static json without(json object, const std::string& name) {
    object.erase(name);
    return object;
  }
  static json with(json object, const std::string& name, json value) {
    object[name] = std::move(value);
    return object;
  }
  static void put_in(std::vector<Attack>& all, const json& good, const std::string& name, std::vector<Attack> inner) {
    for (Attack& attack : inner) all.push_back({with(good, name, std::move(attack.body)), attack.field, attack.rule});
  }
  const json& document_;
};

class Bodies : public ServerTest {
 protected:
  json state() {
    const json status = get("/api/v1/status").json();
    return {status["lease"], status["recording"], get("/api/v1/walk").json()["exercise"], get("/api/v1/sessions").json()["total"],
            get("/api/v1/parameters").json()["version"]};
  }
};

// A hoist.v1 message is held against the schema of its row.
TEST_F(Bodies, EachBrokenRuleOfAMessageIsRefusedByName) {
  document_ = http(port_, "GET", "/api/openapi.json").json();
  const Maker maker(document_);
  struct Row {
    std::string_view type, schema;
    bool answered;
  };
  constexpr std::array kMessages{
#define HOIST_IN(type, answered, role, schema, doc) Row{#type, #schema, (answered) != 0},
#define HOIST_OUT(...)
#define HOIST_FIELD(...)
#include "server/contract/messages.def"
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD
  };
  std::size_t refused = 0;
  for (const Row& row : kMessages) {
    // What is not answered is counted (live_test.cpp).
    if (!row.answered) continue;
    Live live(port_, bearer_);
    std::size_t sent = 0;
    for (const Attack& attack : maker.attacks(document_["components"]["schemas"].at(std::string{row.schema}))) {
      // 60 messages a second are allowed; a field that is null is left out.
      if (!attack.body.is_object() || sent == 55) continue;
      json message = attack.body;
      message["type"] = row.type;
      const json reply = live.ask(message);
      ++sent;
      ASSERT_EQ(reply["ok"], false) << message;
      bool named = false;
      for (const json& error : reply["errors"]) named = named || error["field"] == attack.field;
      EXPECT_TRUE(named) << attack.field << " is not named: " << message << " -> " << reply;
    }
    refused += sent;
  }
  EXPECT_GT(refused, 100U);
  EXPECT_TRUE(core_->commands().empty()) << "the core was asked for something";
}

TEST_F(Bodies, EachBrokenRuleOfASchemaIsRefusedByNameAndChangesNothing) {
  document_ = http(port_, "GET", "/api/openapi.json").json();
  const Maker maker(document_);
  const json before = state();
  const std::size_t asked = core_->commands().size();
  std::map<std::string, int> rules;
  std::size_t routes = 0;
  for (const server::Route& route : server::kRoutes) {
    if (!server::takes_body(route) || route.request.find('/') != std::string_view::npos) continue;
    ++routes;
    std::string path{route.path};
    if (const auto at = path.find("{name}"); at != std::string::npos)
      path.replace(at, 6, route.operation == "apply_preset" ? "gentle" : "speed_m_s_max");
    if (const auto at = path.find("{id}"); at != std::string::npos) path.replace(at, 4, "1");
    const json& schema = document_["components"]["schemas"][std::string{route.request}];
    for (const Attack& attack : maker.attacks(schema)) {
      // A body that is no object is not JSON for these routes (400).
      if (!attack.body.is_object()) continue;
      const Answer answer = call(std::string{server::method_name(route.method)}, path, attack.body);
      const auto say = [&] { return std::string{route.operation} + ", " + attack.rule + ": " + attack.body.dump() + " -> " + answer.body; };
      ASSERT_EQ(answer.status, 422) << say();
      bool named = false;
      const json errors = answer.json()["errors"];
      for (const json& error : errors) named = named || error["field"] == attack.field;
      EXPECT_TRUE(named) << attack.field << " is not named by " << say();
      ++rules[attack.rule];
    }
  }
  EXPECT_EQ(core_->commands().size(), asked) << "the core was asked for something";
  EXPECT_EQ(state(), before);
  EXPECT_GE(routes, 17U);
  for (const char* rule : {"type", "required", "additionalProperties", "minimum", "maximum", "enum", "const", "minLength", "maxLength",
                           "minItems", "maxItems", "minProperties", "anyOf"})
    EXPECT_GT(rules[rule], 0) << rule;
}

}  // namespace
}  // namespace hoist::test
