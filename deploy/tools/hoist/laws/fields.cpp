#include "deploy/tools/hoist/laws/fields.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

namespace hoist::tool {

using nlohmann::json;

namespace {

std::string shown(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return json(value).dump();
}

std::string shown(const Range& range) {
  std::ostringstream text;
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  if (!low && !high) return "a finite number";
  if (low && high) {
    text << "within " << (range.low_open ? "(" : "[") << shown(range.low) << ", " << shown(range.high) << (range.high_open ? ")" : "]");
  } else if (low) {
    text << (range.low_open ? "> " : ">= ") << shown(range.low);
  } else {
    text << (range.high_open ? "< " : "<= ") << shown(range.high);
  }
  if (!range.infinite_ok) text << " and finite";
  return text.str();
}

double checked_number(const std::string& name, const json& value, const Range& range) {
  double number = 0.0;
  if (value.is_number()) {
    number = value.get<double>();
  } else if (value.is_string() && (value == "inf" || value == "-inf")) {
    number = value == "inf" ? HUGE_VAL : -HUGE_VAL;
  } else if (value.is_null()) {
    throw Refusal(name + ": null (not a number); must be " + shown(range));
  } else {
    throw Refusal(name + ": is " + value.type_name() + ", must be a number " + shown(range));
  }
  const bool finite_ok = std::isfinite(number) || (range.infinite_ok && !std::isnan(number));
  const bool low_ok = range.low_open ? number > range.low : number >= range.low;
  const bool high_ok = range.high_open ? number < range.high : number <= range.high;
  if (!finite_ok || !low_ok || !high_ok) throw Refusal(name + ": " + shown(number) + ", must be " + shown(range));
  return number;
}

std::int32_t checked_integer(const std::string& name, const json& value) {
  static constexpr Range kInt32{.low = std::numeric_limits<std::int32_t>::min(), .high = std::numeric_limits<std::int32_t>::max()};
  const double number = checked_number(name, value, kInt32);
  if (number != std::floor(number)) throw Refusal(name + ": " + shown(number) + ", must be a whole number of counts");
  return static_cast<std::int32_t>(number);
}

std::string element(const std::string& name, std::size_t index) { return name + "[" + std::to_string(index) + "]"; }

const json& checked_array(const std::string& name, const json& value) {
  if (!value.is_array()) throw Refusal(name + ": is " + value.type_name() + ", must be an array");
  return value;
}

}  // namespace

Fields::Fields(const json& object, std::string what) : object_(object) {
  if (!object.is_object()) throw Refusal(what + ": is " + object.type_name() + ", must be an object");
}

const json* Fields::raw(const std::string& name) {
  asked_.insert(name);
  const auto found = object_.find(name);
  return found == object_.end() ? nullptr : &*found;
}

const json& Fields::required(const std::string& name) {
  const json* value = raw(name);
  if (value == nullptr) throw Refusal(name + ": missing");
  return *value;
}

bool Fields::has(const std::string& name) {
  const json* value = raw(name);
  return value != nullptr && !value->is_null();
}

double Fields::number(const std::string& name, const Range& range) { return checked_number(name, required(name), range); }

double Fields::number_or(const std::string& name, double fallback, const Range& range) {
  const json* value = raw(name);
  return value == nullptr ? fallback : checked_number(name, *value, range);
}

std::optional<double> Fields::optional_number(const std::string& name, const Range& range) {
  if (!has(name)) return std::nullopt;
  return checked_number(name, *raw(name), range);
}

std::vector<double> Fields::numbers(const std::string& name, const Range& range) {
  const json& array = checked_array(name, required(name));
  std::vector<double> out;
  out.reserve(array.size());
  for (std::size_t i = 0; i < array.size(); ++i) out.push_back(checked_number(element(name, i), array[i], range));
  return out;
}

std::int32_t Fields::integer(const std::string& name) { return checked_integer(name, required(name)); }

std::vector<std::int32_t> Fields::integers(const std::string& name) {
  const json& array = checked_array(name, required(name));
  std::vector<std::int32_t> out;
  out.reserve(array.size());
  for (std::size_t i = 0; i < array.size(); ++i) out.push_back(checked_integer(element(name, i), array[i]));
  return out;
}

std::string Fields::text(const std::string& name) {
  const json& value = required(name);
  if (!value.is_string()) throw Refusal(name + ": is " + value.type_name() + ", must be a string");
  return value.get<std::string>();
}

std::string Fields::text_or(const std::string& name, const std::string& fallback) { return raw(name) == nullptr ? fallback : text(name); }

bool Fields::flag_or(const std::string& name, bool fallback) {
  const json* value = raw(name);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) throw Refusal(name + ": is " + value->type_name() + ", must be true or false");
  return value->get<bool>();
}

std::vector<std::vector<std::optional<double>>> Fields::optional_table(const std::string& name) {
  const json& table = checked_array(name, required(name));
  std::vector<std::vector<std::optional<double>>> out;
  for (std::size_t row = 0; row < table.size(); ++row) {
    const json& cells = checked_array(element(name, row), table[row]);
    auto& target = out.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i].is_null()) {
        target.emplace_back();
      } else {
        target.emplace_back(checked_number(element(element(name, row), i), cells[i], kAny));
      }
    }
    same_length(element(name, row), target.size(), element(name, 0), out.front().size());
  }
  return out;
}

void Fields::refuse_unknown() const {
  for (const auto& [name, value] : object_.items()) {
    if (!asked_.contains(name)) throw Refusal(name + ": unknown here");
  }
}

void same_length(const std::string& name, std::size_t length, const std::string& other, std::size_t other_length) {
  if (length == other_length) return;
  throw Refusal(name + ": has " + std::to_string(length) + " elements, must have as many as " + other + ": " +
                std::to_string(other_length));
}

json number_out(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

}  // namespace hoist::tool
