// Reading a request's query fields.
#pragma once
#include <charconv>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "db/store/session_reader.hpp"
#include "server/api/call.hpp"

namespace hoist::server::api {

template <typename T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

inline Problem bad_query(std::string name, std::string message, std::optional<double> min, std::optional<double> max) {
  Problem problem{.status = 422, .name = "invalid", .title = "A value cannot be used", .detail = name + " " + message};
  problem.errors.push_back({std::move(name), std::move(message), std::nullopt, min, max});
  return problem;
}

inline std::optional<std::string> query(const Call& call, const char* name) {
  const auto at = call.request.query.find(name);
  return at == call.request.query.end() ? std::nullopt : std::optional{at->second};
}

// Reads limit and cursor of a list. False: the call has failed.
template <typename Query>
bool read_page(const CallPtr& call, Query& wanted) {
  if (const auto limit = query(*call, "limit")) {
    const auto value = number<std::size_t>(*limit);
    if (!value || *value < 1 || *value > db::kMaxPage) {
      call->fail(
          bad_query("limit", "must be a whole number from 1 to " + std::to_string(db::kMaxPage), 1, static_cast<double>(db::kMaxPage)));
      return false;
    }
    wanted.limit = *value;
  }
  if (const auto cursor = query(*call, "cursor"); cursor && !cursor->empty()) {
    wanted.before = number<std::int64_t>(*cursor);
    if (!wanted.before) {
      call->fail(bad_query("cursor", "must be the `next` of an earlier answer", {}, {}));
      return false;
    }
  }
  return true;
}

inline nlohmann::json next_json(const std::optional<std::int64_t>& next) {
  return next ? nlohmann::json(std::to_string(*next)) : nlohmann::json(nullptr);
}

}  // namespace hoist::server::api
