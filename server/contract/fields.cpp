#include "server/contract/fields.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/contract/schemas.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
std::optional<double> number_of(const json& schema, const char* keyword) {
  const auto at = schema.find(keyword);
  return at == schema.end() ? std::nullopt : std::optional{at->get<double>()};
}

// "a, b or c".
std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + words[i];
  return text;
}

std::string plain(const json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

// Behind references, one schema per choice.
std::vector<const json*> choices_of(const json& schema) {
  if (const auto at = schema.find("$ref"); at != schema.end()) {
    const auto& path = at->get_ref<const std::string&>();
    return choices_of(schemas().at(path.substr(path.rfind('/') + 1)));
  }
  const auto at = schema.find("anyOf");
  if (at == schema.end()) return {&schema};
  std::vector<const json*> all;
  for (const json& choice : *at)
    for (const json* one : choices_of(choice)) all.push_back(one);
  return all;
}

struct TypeName {
  std::string_view type, words;
  bool (*has)(const json&);
};
constexpr TypeName kTypes[] = {
    {"object", "an object", [](const json& v) { return v.is_object(); }},
    {"array", "a list", [](const json& v) { return v.is_array(); }},
    {"string", "text", [](const json& v) { return v.is_string(); }},
    {"boolean", "true or false", [](const json& v) { return v.is_boolean(); }},
    {"integer", "a whole number", [](const json& v) { return v.is_number_integer(); }},
    {"number", "a number", [](const json& v) { return v.is_number(); }},
    {"null", "null", [](const json& v) { return v.is_null(); }},
};

// "a number" and so on, of the types that a schema allows; empty for one without a type.
std::string types_in_words(const json& schema) {
  const auto at = schema.find("type");
  if (at == schema.end()) return {};
  std::vector<std::string> words;
  for (const json& type : at->is_array() ? *at : json::array({*at}))
    for (const TypeName& row : kTypes)
      if (type == row.type) words.emplace_back(row.words);
  return listed(words);
}

// A schema without a type allows every one.
bool has_type(const json& schema, const json& value) {
  const auto at = schema.find("type");
  if (at == schema.end()) return true;
  const auto fits = [&value](const json& type) {
    return std::ranges::any_of(kTypes, [&](const TypeName& row) { return type == row.type && row.has(value); });
  };
  return at->is_array() ? std::ranges::any_of(*at, fits) : fits(*at);
}

class Checker {
 public:
  std::vector<FieldError> errors;

  void check(const json& schema, const json& value, const std::string& where) {
    const std::vector<const json*> choices = choices_of(schema);
    if (choices.size() == 1) return check_one(*choices.front(), value, where);
    std::vector<const json*> typed;
    for (const json* choice : choices)
      if (has_type(*choice, value)) typed.push_back(choice);
    if (typed.size() == 1) return check_one(*typed.front(), value, where);
    if (typed.empty()) return add(where, "must be " + types_in_words(*choices.front()), *choices.front());
    check_kinds(typed, value, where);
  }

 private:
  void add(const std::string& where, std::string message, const json& schema = json::object(), std::optional<double> value = {}) {
    errors.push_back(
        {where.empty() ? "body" : where, std::move(message), value, number_of(schema, "minimum"), number_of(schema, "maximum")});
  }
  static std::string below(const std::string& where, const std::string& name) { return where.empty() ? name : where + "." + name; }

  // Several kinds of one object differ in the fixed value of one member, such as its shape: that of the value decides.
  void check_kinds(const std::vector<const json*>& kinds, const json& value, const std::string& where) {
    std::string member;
    std::vector<std::string> known;
    for (const json* kind : kinds) {
      const auto properties = kind->find("properties");
      if (properties == kind->end()) continue;
      for (const auto& [name, property] : properties->items()) {
        const auto fixed = property.find("const");
        if (fixed == property.end()) continue;
        if (value.value(name, json()) == *fixed) return check_one(*kind, value, where);
        member = name;
        known.push_back(plain(*fixed));
      }
    }
    add(below(where, member), "must be " + listed(known));
  }

  void check_one(const json& schema, const json& value, const std::string& where) {
    if (!has_type(schema, value)) return add(where, "must be " + types_in_words(schema), schema);
    if (const auto at = schema.find("enum"); at != schema.end() && std::ranges::find(*at, value) == at->end()) {
      std::vector<std::string> words;
      for (const json& word : *at) words.push_back(plain(word));
      return add(where, "must be " + listed(words), schema);
    }
    if (const auto at = schema.find("const"); at != schema.end() && *at != value) return add(where, "must be " + plain(*at));
    if (value.is_number()) check_range(schema, value.get<double>(), where);
    if (value.is_string()) {
      const auto& text = value.get_ref<const std::string&>();
      const auto characters = std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
      check_count(schema, "minLength", "maxLength", static_cast<double>(characters), " characters", where);
    }
    if (value.is_array()) {
      check_count(schema, "minItems", "maxItems", static_cast<double>(value.size()), " entries", where);
      if (const auto items = schema.find("items"); items != schema.end())
        for (std::size_t i = 0; i < value.size(); ++i) check(*items, value[i], below(where, std::to_string(i)));
    }
    if (value.is_object()) check_members(schema, value, where);
  }

  void check_range(const json& schema, double number, const std::string& where) {
    if (number < number_of(schema, "minimum").value_or(number) || number > number_of(schema, "maximum").value_or(number))
      add(where, "is outside its range", schema, number);
  }

  // min and max of the refusal are the number of characters or entries.
  void check_count(const json& schema, const char* least_name, const char* most_name, double count, const char* of,
                   const std::string& where) {
    const std::optional<double> least = number_of(schema, least_name), most = number_of(schema, most_name);
    if (count >= least.value_or(count) && count <= most.value_or(count)) return;
    const auto whole = [](double limit) { return std::to_string(static_cast<std::size_t>(limit)); };
    const std::string allowed = least && most ? "must have " + whole(*least) + " to " + whole(*most) + of
                                : most        ? "must have at most " + whole(*most) + of
                                : *least > 1  ? "must have at least " + whole(*least) + of
                                              : "must not be empty";
    errors.push_back({where.empty() ? "body" : where, allowed, std::nullopt, least, most});
  }

  void check_members(const json& schema, const json& value, const std::string& where) {
    for (const json& name : schema.value("required", json::array()))
      if (!value.contains(name.get_ref<const std::string&>())) add_missing(schema, name.get<std::string>(), where);
    const auto properties = schema.find("properties");
    const auto more = schema.find("additionalProperties");
    for (const auto& [name, member] : value.items()) {
      if (properties != schema.end() && properties->contains(name))
        check(properties->at(name), member, below(where, name));
      else if (more != schema.end() && *more == false)
        add(below(where, name), "is not known here");
      else if (more != schema.end() && more->is_object())
        check(*more, member, below(where, name));
    }
    check_count(schema, "minProperties", "maxProperties", static_cast<double>(value.size()), " fields", where);
  }

  void add_missing(const json& schema, const std::string& name, const std::string& where) {
    const auto properties = schema.find("properties");
    const json none = json::object();
    const json& property = *choices_of(properties != schema.end() && properties->contains(name) ? properties->at(name) : none).front();
    const std::string words = types_in_words(property);
    add(below(where, name), words.empty() ? "is missing" : "is missing; it must be " + words, property);
  }
};
}  // namespace

std::vector<FieldError> wrong_fields(std::string_view schema, const json& body) {
  Checker checker;
  if (const auto at = schemas().find(schema); at != schemas().end()) checker.check(*at, body, "");
  return std::move(checker.errors);
}

}  // namespace hoist::server
