#include "db/summary/provenance.hpp"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "control/contract/can_dictionary.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

std::string hex8(std::uint32_t value) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08x", static_cast<unsigned>(value));
  return text.data();
}
std::string revision_text(std::uint32_t value) { return std::to_string(value >> 16) + '.' + std::to_string(value & 0xFFFFU); }
std::string version_text(std::uint32_t value) {
  return std::to_string(value >> 16) + '.' + std::to_string((value >> 8) & 0xFFU) + '.' + std::to_string(value & 0xFFU);
}
// A node whose program knows nothing of its version answers 0.
std::optional<std::uint32_t> told(const std::optional<std::uint32_t>& value) { return value.value_or(0) == 0 ? std::nullopt : value; }

}  // namespace

std::string on_one_line(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\n')
      out += "\\n";
    else if (c == '\r')
      out += "\\r";
    else if (c == '\\')
      out += "\\\\";
    else
      out += (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F ? ' ' : c;
  }
  return out;
}

std::string layout_text(std::uint64_t layout_hash) {
  return hex8(static_cast<std::uint32_t>(layout_hash >> 32)) + hex8(static_cast<std::uint32_t>(layout_hash));
}

json node_programs_json(std::span<const NodeProgram> nodes) {
  const auto or_null = [](const std::optional<std::uint32_t>& value, auto text) { return value ? json(text(*value)) : json(nullptr); };
  json rows = json::array();
  for (const NodeProgram& node : nodes)
    rows.push_back({{"name", node.name},
                    {"product", or_null(node.product, hex8)},
                    {"revision", or_null(node.revision, revision_text)},
                    {"version", or_null(told(node.version), version_text)},
                    {"crc", or_null(told(node.crc), hex8)},
                    {"simulated", node.product ? json((*node.product & contract::canopen::kSimulatedProduct) != 0) : json(nullptr)}});
  return rows;
}

nlohmann::json actor_json(const std::optional<Actor>& actor) {
  if (!actor) return nullptr;
  return {{"user", actor->user}, {"role", actor->role}, {"origin", actor->origin}, {"client", actor->client}};
}

}  // namespace hoist::db
