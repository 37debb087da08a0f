#include "server/text/json_text.hpp"

#include <nlohmann/json.hpp>
#include <set>
#include <vector>

namespace hoist::server {

std::optional<nlohmann::json> parse_json(std::string_view text, JsonError& error) {
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    // The parser takes a zero byte for the end of the text and would not look at what follows.
    if (c == '\0') {
      error = {i + 1, "not valid JSON"};
      return std::nullopt;
    }
    if (in_string) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kJsonDepthLimit) {
        error = {i + 1, "nested deeper than " + std::to_string(kJsonDepthLimit) + " levels"};
        return std::nullopt;
      }
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  try {
    return nlohmann::json::parse(text.begin(), text.end());
  } catch (const nlohmann::json::parse_error& e) {
    error = {e.byte, "not valid JSON"};
  } catch (const nlohmann::json::exception&) {
    error = {0, "a number is too large"};
  }
  return std::nullopt;
}

std::optional<std::string> repeated_name(std::string_view text) {
  using nlohmann::json;
  std::optional<std::string> repeated;
  std::vector<std::set<std::string>> names;
  [[maybe_unused]] const json read = json::parse(text.begin(), text.end(), [&](int, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start) names.emplace_back();
    if (event == json::parse_event_t::object_end) names.pop_back();
    if (event == json::parse_event_t::key && !names.back().insert(value.get<std::string>()).second && !repeated)
      repeated = value.get<std::string>();
    return true;
  });
  return repeated;
}

std::string dump_json(const nlohmann::json& value) { return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace); }

}  // namespace hoist::server
