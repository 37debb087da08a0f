// What the sub-commands that read a recording share.
#pragma once

#include <charconv>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "db/store/database.hpp"
#include "db/store/session_types.hpp"
#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

/// A session's number: digits only, above 0.
inline std::optional<db::SessionId> parse_session(std::string_view text) {
  db::SessionId session = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), session);
  if (error != std::errc() || end != text.data() + text.size() || session <= 0) return std::nullopt;
  return session;
}

/// Prints the sentence of a refusal; returns the exit code.
inline int refuse(std::string_view command, const db::Error& error) {
  std::fprintf(stderr, "hoist %s: %s\n", std::string(command).c_str(), error.message.c_str());
  return kRefused;
}
inline int bad_usage(std::string_view command, std::string_view sentence) {
  std::fprintf(stderr, "hoist %s: %s (see hoist %s --help)\n", std::string(command).c_str(), std::string(sentence).c_str(),
               std::string(command).c_str());
  return kBadUsage;
}

}  // namespace hoist::tool
