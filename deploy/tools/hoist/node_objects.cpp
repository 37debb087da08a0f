#include "deploy/tools/hoist/node_objects.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace hoist::tool {

using contract::Node;
using contract::ObjectInfo;
using contract::ObjectType;

namespace {

std::optional<std::uint32_t> whole_number(std::string_view text, int base) {
  std::uint32_t value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (problem != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

}  // namespace

std::optional<Node> parse_node(std::string_view text, std::string& error) {
  const bool hexadecimal = text.starts_with("0x");
  const auto id = whole_number(hexadecimal ? text.substr(2) : text, hexadecimal ? 16 : 10);
  std::string names;
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) {
    const contract::NodeInfo& node = contract::kNodes[i];
    if (node.name == text || (id && *id == node.id)) return static_cast<Node>(i);
    names += (names.empty() ? "" : ", ") + std::string(node.name) + " (" + std::to_string(node.id) + ")";
  }
  error = "there is no node \"" + std::string(text) + "\"; there are " + names;
  return std::nullopt;
}

const ObjectInfo* parse_object(Node node, std::string_view text, std::string& error) {
  const contract::NodeKind kind = contract::kNodes[static_cast<std::size_t>(node)].kind;
  for (const ObjectInfo& object : contract::kObjects)
    if (contract::object_applies(object, kind) && object.name == text) return &object;
  const auto colon = text.find(':');
  std::string_view index_text = text.substr(0, colon);
  const std::string_view sub_text = colon == std::string_view::npos ? std::string_view("0") : text.substr(colon + 1);
  if (index_text.starts_with("0x")) index_text.remove_prefix(2);
  if (index_text.ends_with('h')) index_text.remove_suffix(1);
  const auto index = whole_number(index_text, 16), sub = whole_number(sub_text, 10);
  if (index && sub && *index <= 0xFFFF && *sub <= 0xFF) {
    const ObjectInfo* found = contract::find_object(kind, static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub));
    if (found != nullptr) return found;
  }
  error = std::string(contract::kNodes[static_cast<std::size_t>(node)].name) + " has no object \"" + std::string(text) +
          "\" in the table; write INDEX:SUB, for example 2200:1, or a name of control/contract/can_dictionary.gen.md";
  return nullptr;
}

std::string object_text(const ObjectInfo& object) {
  char address[24];
  std::snprintf(address, sizeof address, "%04Xh:%u ", object.index, object.sub);
  return address + std::string(object.name);
}

double physical_value(const ObjectInfo& object, std::uint32_t raw) {
  switch (object.type) {
    case ObjectType::f32:
      return static_cast<double>(std::bit_cast<float>(raw)) * object.scale;
    case ObjectType::i8:
      return static_cast<std::int8_t>(raw) * object.scale;
    case ObjectType::i16:
      return static_cast<std::int16_t>(raw) * object.scale;
    case ObjectType::i32:
      return static_cast<std::int32_t>(raw) * object.scale;
    default:
      return raw * object.scale;
  }
}

std::string value_text(const ObjectInfo& object, std::uint32_t raw) {
  const double value = physical_value(object, raw);
  // Seven digits are what a float has; more of them would only show its binary nature.
  char text[40];
  std::snprintf(text, sizeof text, object.type == ObjectType::f32 ? "%.7g" : "%.10g", value);
  std::string out = text;
  if (!object.unit.empty()) out += " " + std::string(object.unit);
  const bool plain = object.unit.empty() && object.type != ObjectType::f32 && value > 9;
  if (plain) {
    std::snprintf(text, sizeof text, " (0x%X)", raw);
    out += text;
  }
  return out;
}

std::string range_text(const ObjectInfo& object) {
  return number(object.min * object.scale) + " to " + number(object.max * object.scale) +
         (object.unit.empty() ? "" : " " + std::string(object.unit));
}

std::optional<std::uint32_t> parse_value(const ObjectInfo& object, std::string_view text, std::string& error) {
  const std::string name = object_text(object);
  if (object.access != contract::Access::rw) {
    error = name + " can only be read";
    return std::nullopt;
  }
  const std::size_t bits = 8 * contract::object_bytes(object.type);
  double value = 0;  // in steps
  if (text.starts_with("0x")) {
    const auto raw = whole_number(text.substr(2), 16);
    if (!raw || (bits < 32 && *raw >> bits != 0)) {
      error = name + ": \"" + std::string(text) + "\" is no hexadecimal number of " + std::to_string(bits) + " bits";
      return std::nullopt;
    }
    value = physical_value(object, *raw) / object.scale;
  } else {
    double physical = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), physical);
    if (problem != std::errc{} || end != text.data() + text.size() || !std::isfinite(physical)) {
      error = name + ": \"" + std::string(text) + "\" is no number; expected " + range_text(object);
      return std::nullopt;
    }
    value = physical / object.scale;
  }
  if (object.type != ObjectType::f32) {
    const double whole = std::round(value);
    if (std::fabs(value - whole) > 1e-6 * std::fmax(1.0, std::fabs(value))) {
      error = name + ": " + std::string(text) + " lies between two steps of " + number(object.scale) +
              (object.unit.empty() ? "" : " " + std::string(object.unit));
      return std::nullopt;
    }
    value = whole;
  }
  // NaN fails both comparisons.
  if (!(value >= object.min && value <= object.max)) {
    error = name + ": " + std::string(text) + " is outside of " + range_text(object);
    return std::nullopt;
  }
  if (object.type == ObjectType::f32) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const auto raw = static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
  return bits == 32 ? raw : raw & ((1U << bits) - 1U);
}

}  // namespace hoist::tool
