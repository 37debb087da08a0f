// Rows of the file of accounts as what a request shows: sign-ins and tokens.
#pragma once
#include <algorithm>
#include <memory>
#include <string_view>

#include "db/accounts/accounts.hpp"
#include "server/http/auth.hpp"

namespace hoist::server {

[[nodiscard]] constexpr contract::Role role_of_name(std::string_view name) {
  return name == "engineer" ? contract::Role::engineer : name == "therapist" ? contract::Role::therapist : contract::Role::viewer;
}

[[nodiscard]] inline SessionPtr session_of(const db::SignIn& row) {
  auto session = std::make_shared<Session>();
  session->account = true;
  session->digest = row.secret_sha256;
  session->role = role_of_name(row.role);
  session->user = row.user;
  session->display_name = row.display_name;
  session->device = row.device;
  session->begun_utc_s = static_cast<std::uint64_t>(row.begun_s);
  session->used_utc_s = static_cast<std::uint64_t>(row.used_s);
  session->ended = row.ended;
  session->has_pin = row.has_pin;
  return session;
}

[[nodiscard]] inline SessionPtr session_of(const db::Token& row) {
  auto session = std::make_shared<Session>();
  session->account = session->bearer = true;
  session->digest = row.secret_sha256;
  session->scope = role_of_name(row.scope);
  session->role = std::min(session->scope, role_of_name(row.role));
  session->user = row.user;
  session->display_name = row.display_name;
  session->token_id = row.id;
  session->begun_utc_s = static_cast<std::uint64_t>(row.created_s);
  session->expires_utc_s = static_cast<std::uint64_t>(row.expires_s);
  return session;
}

}  // namespace hoist::server
