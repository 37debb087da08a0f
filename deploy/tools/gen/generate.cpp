#include "deploy/tools/gen/generate.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>

namespace hoist::gen {

std::string number_text(double value) {
  std::array<char, 40> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return error == std::errc{} ? std::string(buffer.data(), end) : std::string("0");
}

std::string hex_text(unsigned value, int digits) {
  std::array<char, 16> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "0x%0*X", digits, value);
  return buffer.data();
}

std::string hex64(std::uint64_t value) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string out;
  for (int shift = 60; shift >= 0; shift -= 4) out += kDigits[(value >> shift) & 0xFU];
  return out;
}

std::string made_from(std::string_view table) { return "Made by `deploy/dev gen` from " + std::string(table) + "; do not edit."; }

std::vector<GeneratedFile> generate_all() {
  std::vector<GeneratedFile> files;
  for (auto&& some : {typescript_files(), markdown_files(), eds_files()}) files.insert(files.end(), some.begin(), some.end());
  files.push_back(audit_file());
  files.push_back(messages_file());
  files.push_back(dbc_file());
  files.push_back(openapi_file());
  files.push_back(rest_file());
  std::sort(files.begin(), files.end(), [](const GeneratedFile& a, const GeneratedFile& b) { return a.path < b.path; });
  return files;
}

}  // namespace hoist::gen
