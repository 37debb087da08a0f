// Two writers with the same calls: CDR ignores the names, JSON writes them.
// A message is written by calls in the order of its definition.
#pragma once
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

namespace hoist::db::ros {

static_assert(std::endian::native == std::endian::little, "CDR is written as the machine holds it");

/// XCDR1, little endian. Alignment counts from the end of the four-byte header.
class CdrWriter {
 public:
  explicit CdrWriter(std::string& out) : out_(out) {
    out_.append("\0\1\0\0", 4);
    origin_ = out_.size();
  }
  void begin(std::string_view) {}
  void end() {}
  void begin_list(std::string_view, std::size_t count) { put(static_cast<std::uint32_t>(count)); }
  void begin_item() {}
  void end_list() {}
  void number(std::string_view, double value) { put(value); }
  void single(std::string_view, double value) { put(static_cast<float>(value)); }
  void integer(std::string_view, std::int32_t value) { put(value); }
  void natural(std::string_view, std::uint32_t value) { put(value); }
  void byte(std::string_view, std::uint8_t value) { put(value); }
  void truth(std::string_view, bool value) { put(static_cast<std::uint8_t>(value)); }
  void text(std::string_view, std::string_view value) {
    put(static_cast<std::uint32_t>(value.size() + 1));
    out_ += value;
    out_ += '\0';
  }
  void fixed(std::string_view, std::span<const double> values) {
    for (const double value : values) put(value);
  }
  void numbers(std::string_view, std::span<const double> values) {
    put(static_cast<std::uint32_t>(values.size()));
    fixed({}, values);
  }
  void singles(std::string_view, std::span<const double> values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const double value : values) put(static_cast<float>(value));
  }
  void texts(std::string_view, std::span<const std::string_view> values) {
    put(static_cast<std::uint32_t>(values.size()));
    for (const std::string_view value : values) text({}, value);
  }

 private:
  template <typename Value>
  void put(Value value) {
    while ((out_.size() - origin_) % sizeof value != 0) out_ += '\0';
    std::array<char, sizeof value> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    out_.append(bytes.data(), bytes.size());
  }
  std::string& out_;
  std::size_t origin_;
};

class JsonMessage {
 public:
  explicit JsonMessage(std::string& out) : out_(out) { out_ += '{'; }
  ~JsonMessage() { out_ += '}'; }
  JsonMessage(const JsonMessage&) = delete;
  JsonMessage& operator=(const JsonMessage&) = delete;
  void begin(std::string_view name) {
    key(name);
    out_ += '{';
  }
  void end() { out_ += '}'; }
  void begin_list(std::string_view name, std::size_t) {
    key(name);
    out_ += '[';
  }
  void begin_item() {
    comma();
    out_ += '{';
  }
  void end_list() { out_ += ']'; }
  void number(std::string_view name, double value) {
    key(name);
    print(value);
  }
  void single(std::string_view name, double value) { number(name, value); }
  void integer(std::string_view name, std::int32_t value) {
    key(name);
    out_ += std::to_string(value);
  }
  void natural(std::string_view name, std::uint32_t value) {
    key(name);
    out_ += std::to_string(value);
  }
  void byte(std::string_view name, std::uint8_t value) { natural(name, value); }
  void truth(std::string_view name, bool value) {
    key(name);
    out_ += value ? "true" : "false";
  }
  void text(std::string_view name, std::string_view value) {
    key(name);
    quote(value);
  }
  void numbers(std::string_view name, std::span<const double> values) {
    begin_list(name, 0);
    for (const double value : values) {
      comma();
      print(value);
    }
    end_list();
  }
  void fixed(std::string_view name, std::span<const double> values) { numbers(name, values); }
  void singles(std::string_view name, std::span<const double> values) { numbers(name, values); }
  void texts(std::string_view name, std::span<const std::string_view> values) {
    begin_list(name, 0);
    for (const std::string_view value : values) {
      comma();
      quote(value);
    }
    end_list();
  }

 private:
  void comma() {
    if (out_.back() != '{' && out_.back() != '[') out_ += ',';
  }
  void key(std::string_view name) {
    comma();
    quote(name);
    out_ += ':';
  }
  // Texts are names from our own tables: ASCII without control characters.
  void quote(std::string_view value) {
    out_ += '"';
    for (const char c : value) {
      if (c == '"' || c == '\\') out_ += '\\';
      out_ += c;
    }
    out_ += '"';
  }
  void print(double value) {
    if (!std::isfinite(value)) {
      out_ += "null";
      return;
    }
    std::array<char, 32> digits;
    out_.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  }
  std::string& out_;
};

}  // namespace hoist::db::ros
