// Compact JSON straight into one string, for answers that are asked for often: no tree in between.
#pragma once
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "server/text/json_text.hpp"

namespace hoist::server {

class JsonWriter {
 public:
  explicit JsonWriter(std::size_t expected_bytes) { out_.reserve(expected_bytes); }

  JsonWriter& begin(char bracket) {
    separate();
    out_.push_back(bracket);
    first_ = true;
    return *this;
  }
  JsonWriter& end(char bracket) {
    out_.push_back(bracket);
    first_ = false;
    return *this;
  }
  // A name of ours: letters, digits, underscores.
  JsonWriter& key(std::string_view name) {
    separate();
    out_.append("\"").append(name).append("\":");
    first_ = true;
    return *this;
  }
  JsonWriter& value(std::string_view text) { return plain(text, 0x7F) ? quoted(text) : escaped(text); }
  // Out of a table of ours, which is UTF-8 already.
  JsonWriter& table_text(std::string_view text) { return plain(text, 0x100) ? quoted(text) : escaped(text); }
  JsonWriter& value(const std::string& text) { return value(std::string_view{text}); }
  JsonWriter& value(const char* text) { return value(std::string_view{text}); }
  JsonWriter& value(std::same_as<bool> auto yes) { return literal(yes ? "true" : "false"); }
  JsonWriter& value(std::nullptr_t) { return literal("null"); }
  // The shortest decimal that reads as this number; JSON knows no NaN and no infinity.
  JsonWriter& value(std::floating_point auto number) { return std::isfinite(number) ? print(number) : literal("null"); }
  template <std::integral Number>
  requires(!std::same_as<Number, bool>) JsonWriter& value(Number number) { return print(number); }
  // What is a tree already.
  template <std::same_as<nlohmann::json> Tree>
  JsonWriter& value(const Tree& tree) {
    separate();
    return raw(dump_json(tree));
  }
  template <typename Value>
  JsonWriter& field(std::string_view name, const Value& value_of) {
    return key(name).value(value_of);
  }
  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  // Nothing to escape, and every byte below `end`.
  static bool plain(std::string_view text, unsigned end) {
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte < 0x20 || byte >= end || c == '"' || c == '\\') return false;
    }
    return true;
  }
  JsonWriter& quoted(std::string_view text) {
    separate();
    out_.append("\"").append(text).append("\"");
    return *this;
  }
  JsonWriter& escaped(std::string_view text) { return literal(dump_json(text)); }
  void separate() {
    if (!first_) out_.push_back(',');
    first_ = false;
  }
  JsonWriter& raw(std::string_view text) {
    out_.append(text);
    return *this;
  }
  JsonWriter& literal(std::string_view text) {
    separate();
    return raw(text);
  }
  JsonWriter& print(auto number) {
    separate();
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, number).ptr;
    return raw({text, end});
  }

  std::string out_;
  bool first_ = true;
};

}  // namespace hoist::server
