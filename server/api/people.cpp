// Signing in and out, set-up, accounts, tokens, audit log. Every hash and every use of the file is work for the people's thread.
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "db/store/edit_tag.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/contract/audit.hpp"
#include "server/people/passwords.hpp"
#include "server/people/sessions.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {

constexpr std::size_t kSecretBytes = 32, kDeviceBytes = 8;
constexpr std::uint64_t kPinTries = 5;

std::uint64_t utc_s(const Call& call) { return static_cast<std::uint64_t>(call.services.utc_ns() / 1'000'000'000); }
Clocks clocks(const Call& call) { return clocks_of(call.services.utc_ns(), call.services.now_ns()); }

// The row of this call; the router writes no second one.
void log(const Call& call, std::string user, std::string_view role, AuditName action, std::string target, std::string result,
         std::optional<std::string> before = {}, std::optional<std::string> after = {}) {
  call.logged = std::make_shared<bool>(true);
  call.services.people.log({.utc_ms = call.services.utc_ns() / 1'000'000,
                            .steady_ns = call.services.now_ns(),
                            .user = std::move(user),
                            .role = std::string{role},
                            .address = call.request.address,
                            .action = std::string{action.text},
                            .target = std::move(target),
                            .before = std::move(before),
                            .after = std::move(after),
                            .result = std::move(result)});
}

Problem problem_of(const db::Error& error) {
  switch (error.kind) {
    case db::ErrorKind::bad_value:
      return {.status = 422,
              .name = "invalid",
              .title = "A field cannot be used",
              .detail = error.message + "; nothing was done.",
              .errors = {{error.field, error.message}}};
    case db::ErrorKind::not_found:
      return {.status = 404, .name = "not-found", .title = "There is no such account or token", .detail = error.message};
    case db::ErrorKind::changed:
      return {.status = 412, .name = "changed-meanwhile", .title = "This was changed meanwhile", .detail = error.message};
    case db::ErrorKind::wrong_state:
      return {.status = 409, .name = "refused", .title = "Refused", .detail = error.message};
    default:
      return {.status = 503, .name = "accounts", .title = "The accounts cannot be used", .detail = error.message};
  }
}

Problem bad_field(std::string field, std::string message) {
  return problem_of({db::ErrorKind::bad_value, field + " " + message, std::move(field)});
}
Problem too_soon(std::uint64_t wait_s) {
  return {
      .status = 429, .name = "too-soon", .title = "Too many attempts", .detail = "Wait " + std::to_string(wait_s) + " s and try again."};
}
void fail_too_soon(const CallPtr& call, std::uint64_t wait_s) {
  Response response = problem_response(too_soon(wait_s), call->request.path);
  response.set("Retry-After", std::to_string(wait_s));
  call->respond(std::move(response));
}
Problem wrong_secret() {
  return {.status = 401,
          .name = "wrong-secret",
          .title = "The password or PIN does not belong to this name",
          .detail = "Check it and try again."};
}
Problem no_account() {
  return {.status = 409,
          .name = "no-account",
          .title = "This is no account",
          .detail = "Sign in with a name first: whoever opened the link of this computer has no password."};
}

std::string token_tag(const db::Token& token) {
  return db::edit_tag({token.user, token.name, token.scope, std::to_string(token.created_s), std::to_string(token.expires_s)});
}
std::string user_tag(const db::User& user) { return db::edit_tag({user.display_name, user.role, user.enabled ? "1" : "0"}); }

json user_json(const db::User& user) {
  return {{"user", user.name},       {"display_name", user.display_name},    {"role", user.role},
          {"enabled", user.enabled}, {"has_pin", user.pin_hash.has_value()}, {"etag", user_tag(user)}};
}

// What this hoist is called and speaks; language null: as the browser asks.
json device_names(const Services& services) {
  const db::DeviceSettings& device = services.state.device();
  return {{"name", device.name.empty() ? services.computer_name : device.name},
          {"language", device.language ? json(*device.language) : json(nullptr)}};
}

json who_json(const Call& call, const Session* session, std::string_view device) {
  const Auth& auth = call.rest.auth;
  json here = json::array();
  for (const SessionPtr& one : auth.users_of(device))
    if (one->has_pin) here.push_back({{"user", one->user}, {"display_name", one->display_name}});
  const SetUp& set_up = call.services.set_up;
  json who{{"signed_in", session != nullptr},
           {"user", nullptr},
           {"display_name", nullptr},
           {"role", nullptr},
           {"has_pin", nullptr},
           {"seconds_left", nullptr},
           {"here", std::move(here)},
           {"set_up",
            {{"needed", call.services.needs_set_up},
             {"switch_on", set_up.switch_on()},
             {"seconds_left", set_up.seconds_left(call.services.now_ns())}}},
           {"device", device_names(call.services)},
           {"problem", nullptr}};
  if (const std::string problem = call.services.people.problem(); !problem.empty()) who["problem"] = problem;
  if (session == nullptr) return who;
  who["user"] = session->user;
  if (!session->display_name.empty()) who["display_name"] = session->display_name;
  who["role"] = access_role(session->role);
  if (session->account && !session->bearer) {
    who["has_pin"] = session->has_pin;
    who["seconds_left"] = std::max<std::int64_t>(session->begun_s + kAccountLife_s - clocks(call).steady_s, 0);
  }
  return who;
}

// Asks the store, and answers a failure: `then` gets the value, or nothing where there is none.
template <typename Work, typename Then>
void ask_store(const CallPtr& call, Work work, Then then, Turn turn = Turn::first) {
  using Outcome = std::invoke_result_t<Work&, PeopleRoom&>;
  ask_people<Outcome>(
      call, std::move(work),
      [call, then = std::move(then)](const Outcome& outcome) mutable {
        if (!outcome)
          call->fail(problem_of(outcome.error()));
        else if constexpr (std::is_same_v<Outcome, db::Status>)
          then();
        else
          then(*outcome);
      },
      turn);
}

// The hash of a new password or PIN.
db::Result<std::string> hash_of(PeopleRoom& room, const std::string& secret) {
  std::string hash = hash_secret(secret, room.limits);
  if (hash.empty()) return db::Error{db::ErrorKind::busy, "There is no memory for the password; try again.", {}};
  return hash;
}

// The account behind a name if the secret is its own: the same work for every name.
std::optional<db::User> checked(PeopleRoom& room, const std::string& name, const std::string& secret, bool pin) {
  const auto found = room.accounts.find(name);
  const db::User* user = found && *found ? &**found : nullptr;
  const std::string* hash = user == nullptr ? nullptr : pin ? (user->pin_hash ? &*user->pin_hash : nullptr) : &user->password_hash;
  const bool matches = secret_matches(secret, hash == nullptr ? room.nobody_hash : *hash);
  return matches && hash != nullptr && user->enabled ? std::optional(*user) : std::nullopt;
}

}  // namespace

void who_am_i(const CallPtr& call) {
  Auth& auth = call->rest.auth;
  const SessionPtr session = auth.find(call->request, clocks(*call));
  const std::string device = auth.device_of(call->request);
  call->respond(who_json(*call, session.get(), device));
}

void sign_in(const CallPtr& call) {
  const json& body = *call->body;
  const std::string name = body.at("user");
  const bool pin = body.contains("pin");
  if (pin == body.contains("password")) {
    call->fail(bad_field("password", "or pin must be given, one of the two"));
    return;
  }
  const std::string secret = body.at(pin ? "pin" : "password");
  Auth& auth = call->rest.auth;
  std::string device = auth.device_of(call->request);
  const auto here = auth.users_of(device);
  const bool known = std::any_of(here.begin(), here.end(), [&](const SessionPtr& one) { return one->user == name; });
  if (pin && !known) {
    call->fail({.status = 403,
                .name = "pin-not-here",
                .title = "The PIN is for devices on which you have signed in before",
                .detail = "Sign in with your password."});
    return;
  }
  // Attempts with this name from elsewhere do not delay its owner.
  const std::string account = name + (known ? "@" + device : "") + (pin ? "#" : "");
  SignInGuard& guard = call->services.guard;
  if (pin && guard.failures(account) >= kPinTries) {
    call->fail({.status = 403, .name = "pin-blocked", .title = "The PIN was wrong too often", .detail = "Sign in with your password."});
    return;
  }
  if (const std::uint64_t wait_s = guard.wait_s(account, call->request.address, call->services.now_ns()); wait_s > 0) {
    fail_too_soon(call, wait_s);
    return;
  }
  // Counted before it is tried: many at once are many failures until one of them has turned out right.
  guard.failed(account, call->request.address, call->services.now_ns(), !pin);
  if (device.empty()) device = random_hex(kDeviceBytes);
  const std::string fresh = random_hex(kSecretBytes);
  struct Found {
    std::optional<db::User> user;
    std::optional<db::Error> error;
    bool exists = false;
  };
  db::SignIn row{.secret_sha256 = digest_of_secret(fresh),
                 .user = name,
                 .display_name = {},
                 .role = {},
                 .device = device,
                 .begun_s = static_cast<std::int64_t>(utc_s(*call)),
                 .used_s = static_cast<std::int64_t>(utc_s(*call)),
                 .ended = false};
  const bool asked = ask_people<Found>(
      call,
      [name, secret, pin, row](PeopleRoom& room) {
        Found found{checked(room, name, secret, pin), std::nullopt, false};
        if (!found.user) {
          const auto known_name = room.accounts.find(name);
          found.exists = known_name && known_name->has_value();
          return found;
        }
        if (const db::Status begun = room.accounts.begin_sign_in(row); !begun) found.error = begun.error();
        return found;
      },
      [call, row, account, fresh, name, pin](const Found& found) mutable {
        if (!found.user) {
          // What is no name may be a password in the wrong field.
          log(*call, found.exists ? name : "", "", "sign_in", pin ? "pin" : "password", "wrong-secret");
          call->fail(wrong_secret());
          return;
        }
        SignInGuard& guard_then = call->services.guard;
        if (found.error) {
          // The secret was right: nothing to wait for.
          guard_then.take_back(account, call->request.address);
          call->fail(problem_of(*found.error));
          return;
        }
        guard_then.succeeded(account, call->request.address);
        if (!pin) guard_then.forget(found.user->name + "@" + row.device + "#");
        row.has_pin = found.user->pin_hash.has_value();
        row.display_name = found.user->display_name;
        row.role = found.user->role;
        const SessionPtr session = session_of(row);
        Auth& auth_then = call->rest.auth;
        auth_then.add_account(session, clocks(*call));
        // A browser has one sign-in: sockets of the one before go with it.
        call->services.close_sockets([&](const Session& other) { return other.ended && other.device == session->device; }, "signed out");
        log(*call, session->user, access_role(session->role), "sign_in", pin ? "pin" : "password", "done");
        Response response = json_response(who_json(*call, session.get(), session->device));
        response.set("Set-Cookie", auth_then.cookie_of(fresh));
        call->respond(std::move(response));
      });
  if (!asked) guard.take_back(account, call->request.address);
}

void sign_out(const CallPtr& call) {
  const SessionPtr session = call->session;
  if (!session->account || session->bearer) {
    call->fail(no_account());
    return;
  }
  session->ended = true;
  call->services.close_sockets([&](const Session& other) { return &other == session.get(); }, "signed out");
  ask_store(
      call, [digest = session->digest](PeopleRoom& room) { return room.accounts.end_sign_in(digest); },
      [call] {
        call->respond(json{{"ok", true}});
      });
}

namespace {
// Changes one's own account after its password was given once more.
void change_own(const CallPtr& call, std::function<db::Result<db::UserChange>(PeopleRoom&)> make, bool sign_others_out) {
  const SessionPtr session = call->session;
  if (!session->account || session->bearer) {
    call->fail(no_account());
    return;
  }
  const std::string account = session->user + "@" + session->device;
  SignInGuard& guard = call->services.guard;
  if (const std::uint64_t wait_s = guard.wait_s(account, call->request.address, call->services.now_ns()); wait_s > 0) {
    fail_too_soon(call, wait_s);
    return;
  }
  guard.failed(account, call->request.address, call->services.now_ns());
  const bool asked = ask_people<db::Status>(
      call,
      [user = session->user, digest = session->digest, secret = call->body->at("password").get<std::string>(), make = std::move(make),
       sign_others_out](PeopleRoom& room) -> db::Status {
        if (!checked(room, user, secret, false)) return db::Error{db::ErrorKind::bad_value, "password is not the present one", "password"};
        const auto change = make(room);
        if (!change) return change.error();
        const db::Status done = room.accounts.change(user, *change);
        return done && sign_others_out ? room.accounts.end_sign_ins_of(user, digest) : done;
      },
      [call, session, account, sign_others_out](const db::Status& done) {
        if (!done) {
          // What failed after the password was found right is no guess.
          if (done.error().field != "password") call->services.guard.take_back(account, call->request.address);
          call->fail(problem_of(done.error()));
          return;
        }
        call->services.guard.succeeded(account, call->request.address);
        // A new password takes the PIN away.
        const auto& body = *call->body;
        call->rest.auth.set_pin(session->user, body.contains("pin") && body.at("pin").is_string());
        if (sign_others_out) {
          call->rest.auth.end_accounts(session->user, session.get());
          call->services.close_sockets([&](const Session& other) { return other.ended && other.user == session->user; }, "signed out");
        }
        call->respond(json{{"ok", true}});
      });
  if (!asked) guard.take_back(account, call->request.address);
}
}  // namespace

void change_password(const CallPtr& call) {
  const std::string fresh = call->body->at("new_password");
  if (const std::string fault = password_fault(fresh, call->session->user); !fault.empty()) {
    call->fail(bad_field("new_password", fault));
    return;
  }
  change_own(
      call,
      [fresh](PeopleRoom& room) -> db::Result<db::UserChange> {
        const auto hash = hash_of(room, fresh);
        if (!hash) return hash.error();
        return db::UserChange{.display_name = {}, .role = {}, .password_hash = *hash, .enabled = {}, .pin_hash = {}};
      },
      true);
}

void change_pin(const CallPtr& call) {
  const json& pin = call->body->at("pin");
  if (pin.is_string())
    if (const std::string fault = pin_fault(pin.get<std::string>()); !fault.empty()) {
      call->fail(bad_field("pin", fault));
      return;
    }
  const std::optional<std::string> fresh = pin.is_null() ? std::nullopt : std::optional(pin.get<std::string>());
  change_own(
      call,
      [fresh](PeopleRoom& room) -> db::Result<db::UserChange> {
        db::UserChange change{.display_name = {}, .role = {}, .password_hash = {}, .enabled = {}, .pin_hash = std::optional<std::string>{}};
        if (!fresh) return change;
        const auto hash = hash_of(room, *fresh);
        if (!hash) return hash.error();
        change.pin_hash = *hash;
        return change;
      },
      false);
}

void open_ticket(const CallPtr& call) { call->respond(json{{"ticket", call->rest.auth.issue_ticket(call->session, clocks(*call))}}); }

void set_up(const CallPtr& call) {
  const json& body = *call->body;
  const db::User user{.id = 0,
                      .name = body.at("user"),
                      .display_name = body.at("display_name"),
                      .role = "engineer",
                      .enabled = true,
                      .password_hash = {},
                      .pin_hash = {}};
  const std::string password = body.at("password");
  SetUp& set_up = call->services.set_up;
  if (!set_up.open()) {
    call->fail(
        {.status = 403,
         .name = "set-up-closed",
         .title = "The set-up is closed",
         .detail = "Turn the configuration switch of the hoist on (off and on again if it is on), and read the code within 10 minutes."});
    return;
  }
  if (const std::string fault = password_fault(password, user.name); !fault.empty()) {
    call->fail(bad_field("password", fault));
    return;
  }
  if (!set_up.try_code(body.at("code"), same_secret)) {
    log(*call, user.name, "", "set_up", "", "wrong-code");
    call->fail({.status = 403,
                .name = "wrong-code",
                .title = "This is not the code",
                .detail = set_up.open() ? "Read it once more from the hoist."
                                        : "Too many attempts: turn the configuration switch off and on for a new code."});
    return;
  }
  ask_people<db::Status>(
      call,
      [user, password, now = static_cast<std::int64_t>(utc_s(*call))](PeopleRoom& room) -> db::Status {
        const auto hash = hash_of(room, password);
        if (!hash) return hash.error();
        db::User made = user;
        made.password_hash = *hash;
        const auto found = room.accounts.find(user.name);
        if (!found) return found.error();
        if (!*found) return room.accounts.add(made, now);
        // After a lost password the person at the switch sets a new one, and every sign-in under this name ends.
        const db::Status done = room.accounts.change(
            user.name,
            {.display_name = made.display_name, .role = made.role, .password_hash = made.password_hash, .enabled = true, .pin_hash = {}});
        return done ? room.accounts.end_sign_ins_of(user.name, "") : done;
      },
      [call, user](const db::Status& done) {
        log(*call, user.name, "engineer", "set_up", "", done ? "done" : "failed");
        if (!done) {
          call->fail(problem_of(done.error()));
          return;
        }
        call->services.needs_set_up = false;
        call->rest.auth.end_accounts(user.name, nullptr);
        call->services.close_sockets([&](const Session& other) { return other.ended; }, "signed out");
        call->respond(json{{"ok", true}});
      });
}

void list_users(const CallPtr& call) {
  ListPage page;
  if (!read_limit(call, page.limit, db::kMaxPage)) return;
  const std::string after = query(*call, "cursor").value_or("");
  if (!after.empty() && !db::is_user_name(after)) return call->fail(bad_query("cursor", "must be the `next` of an earlier answer", {}, {}));
  ask_store(
      call, [after, limit = page.limit](PeopleRoom& room) { return room.accounts.users(after, limit + 1); },
      [call, limit = page.limit](const std::vector<db::User>& users) {
        call->respond(page_json(users, limit, user_json, [](const db::User& user) { return user.name; }));
      });
}

void add_user(const CallPtr& call) {
  const json& body = *call->body;
  db::User user{.id = 0,
                .name = body.at("user"),
                .display_name = body.at("display_name"),
                .role = body.at("role"),
                .enabled = true,
                .password_hash = {},
                .pin_hash = {}};
  const std::string password = body.at("password");
  if (const std::string fault = password_fault(password, user.name); !fault.empty()) {
    call->fail(bad_field("password", fault));
    return;
  }
  ask_store(
      call,
      [user, password, now = static_cast<std::int64_t>(utc_s(*call))](PeopleRoom& room) -> db::Status {
        const auto hash = hash_of(room, password);
        if (!hash) return hash.error();
        db::User made = user;
        made.password_hash = *hash;
        return room.accounts.add(made, now);
      },
      [call, user] {
        log(*call, call->session->user, access_role(call->session->role), "add_user", user.name, "done", std::nullopt, user.role);
        // One enabled engineer always remains: it is never false again.
        if (user.role == "engineer") call->services.needs_set_up = false;
        call->respond(row_response(user_json(user), 201));
      });
}

void change_user(const CallPtr& call) {
  const json& body = *call->body;
  const std::string name = call->path_values[0];
  std::optional<std::string> password;
  db::UserChange change;
  if (body.contains("display_name")) change.display_name = body.at("display_name");
  if (body.contains("role")) change.role = body.at("role");
  if (body.contains("enabled")) change.enabled = body.at("enabled");
  if (body.contains("password")) {
    password = body.at("password");
    if (const std::string fault = password_fault(*password, name); !fault.empty()) {
      call->fail(bad_field("password", fault));
      return;
    }
  }
  struct Changed {
    db::User before, after;
  };
  const bool signs_out = password || !change.enabled.value_or(true);
  ask_store(
      call,
      [name, change, password, signs_out, tag = given_tag(*call)](PeopleRoom& room) mutable -> db::Result<Changed> {
        if (password) {
          const auto hash = hash_of(room, *password);
          if (!hash) return hash.error();
          change.password_hash = *hash;
        }
        const auto before = room.accounts.find(name);
        if (!before) return before.error();
        if (*before)
          if (const db::Status same = db::check_tag(tag, user_tag(**before)); !same) return same.error();
        if (const db::Status done = room.accounts.change(name, change); !done) return done.error();
        if (signs_out)
          if (const db::Status done = room.accounts.end_sign_ins_of(name, ""); !done) return done.error();
        const auto after = room.accounts.find(name);
        if (!after) return after.error();
        return Changed{**before, **after};
      },
      [call, name, signs_out](const Changed& changed) {
        const db::User& user = changed.after;
        const bool role_changed = changed.before.role != user.role;
        if (user.role == "engineer" && user.enabled) call->services.needs_set_up = false;
        Auth& auth = call->rest.auth;
        auth.apply(name, role_of_name(user.role), user.display_name, user.enabled);
        if (signs_out) auth.end_accounts(name, nullptr);
        call->services.actors.rename(name, user.display_name);
        auth.each_session([&](const Session& other) {
          if (other.user == name) tell_actor(call->services, other);
        });
        // A socket knows its role since its handshake: with another one it is opened anew.
        call->services.close_sockets(
            [&](const Session& other) { return other.user == name && other.account && (other.ended || role_changed); },
            role_changed ? "role changed" : "signed out");
        log(*call, call->session->user, access_role(call->session->role), "change_user", name, "done",
            changed.before.role + (changed.before.enabled ? "" : ", disabled"), user.role + (user.enabled ? "" : ", disabled"));
        call->respond(row_response(user_json(user)));
      });
}

namespace {
json token_json(const db::Token& token) {
  return {{"id", token.id},
          {"user", token.user},
          {"name", token.name},
          {"scope", token.scope},
          {"created_utc_s", token.created_s},
          {"expires_utc_s", token.expires_s},
          {"etag", token_tag(token)}};
}
// Whose tokens this person sees and removes; empty: everybody's.
std::string token_owner(const Call& call) { return call.session->role == contract::Role::engineer ? "" : call.session->user; }
}  // namespace

void list_tokens(const CallPtr& call) {
  ListPage page;
  if (!read_page(call, page)) return;
  ask_store(
      call,
      [page, user = token_owner(*call)](PeopleRoom& room) { return room.accounts.tokens(user, page.last.value_or(0), page.limit + 1); },
      [call, limit = page.limit](const std::vector<db::Token>& tokens) {
        call->respond(page_json(tokens, limit, token_json, [](const db::Token& token) { return std::to_string(token.id); }));
      });
}

void add_token(const CallPtr& call) {
  const SessionPtr owner = call->session;
  if (!owner->account || owner->bearer) {
    call->fail(no_account());
    return;
  }
  const json& body = *call->body;
  const std::string text = random_hex(kSecretBytes);
  db::Token token{.id = 0,
                  .secret_sha256 = digest_of_secret(text),
                  .user = owner->user,
                  .display_name = owner->display_name,
                  .role = {},
                  .name = body.at("name"),
                  .scope = body.at("scope"),
                  .created_s = static_cast<std::int64_t>(utc_s(*call)),
                  .expires_s = 0};
  token.expires_s = token.created_s + body.at("days").get<std::int64_t>() * 86400;
  ask_store(
      call, [token](PeopleRoom& room) { return room.accounts.add_token(token); },
      [call, owner, token, text](std::int64_t id) {
        if (owner->ended) {
          call->fail(problem_of(db::Error{db::ErrorKind::wrong_state, "The account was signed out meanwhile.", {}}));
          return;
        }
        db::Token made = token;
        made.id = id;
        made.role = std::string{access_role(owner->role)};
        call->rest.auth.add_token(session_of(made));
        log(*call, owner->user, access_role(owner->role), "add_token", token.name, "done", std::nullopt, token.scope);
        call->respond(json{{"id", id}, {"token", text}}, 201);
      });
}

void remove_token(const CallPtr& call) {
  std::int64_t id = 0;
  const std::string& text = call->path_values[0];
  if (std::from_chars(text.data(), text.data() + text.size(), id).ptr != text.data() + text.size() || id <= 0) {
    call->fail(problem_of(db::Error{db::ErrorKind::not_found, "there is no token " + text, {}}));
    return;
  }
  ask_store(
      call,
      [id, user = token_owner(*call), tag = given_tag(*call)](PeopleRoom& room) -> db::Status {
        if (!tag.empty()) {
          const auto found = room.accounts.tokens(user, id - 1, 1);
          if (!found) return found.error();
          // One that is not there, or not this person's, is told by the removal.
          if (!found->empty() && found->front().id == id)
            if (const db::Status same = db::check_tag(tag, token_tag(found->front())); !same) return same;
        }
        return room.accounts.remove_token(id, user);
      },
      [call, id] {
        call->services.close_sockets([id](const Session& other) { return other.token_id == id; }, "token removed");
        (void)call->rest.auth.remove_token(id);
        Response response;
        response.status = 204;
        call->respond(std::move(response));
      });
}

namespace {
json audit_json(const db::AuditRow& row) {
  const auto& [id, entry, digest] = row;
  const auto text = [](const std::optional<std::string>& value) { return value ? json(*value) : json(); };
  return {{"id", id},
          {"utc_ms", entry.utc_ms},
          {"steady_ns", entry.steady_ns},
          {"user", entry.user},
          {"role", entry.role},
          {"address", entry.address},
          {"action", entry.action},
          {"target", entry.target},
          {"before", text(entry.before)},
          {"after", text(entry.after)},
          {"result", entry.result},
          {"digest", digest}};
}
}  // namespace

void get_audit(const CallPtr& call) {
  ListPage page;
  if (!read_page(call, page)) return;
  ask_store(
      call, [page](PeopleRoom& room) { return room.accounts.audit(page.last, page.limit + 1); },
      [call, limit = page.limit](const std::vector<db::AuditRow>& rows) {
        call->respond(page_json(rows, limit, audit_json, [](const db::AuditRow& row) { return std::to_string(row.id); }));
      },
      Turn::after_log);
}

void check_audit(const CallPtr& call) {
  ask_store(
      call, [](PeopleRoom& room) { return room.accounts.check_audit(); },
      [call](const db::AuditCheck& check) {
        call->respond(
            json{{"rows", check.rows}, {"first_wrong", check.first_wrong ? json(*check.first_wrong) : json()}, {"head", check.head}});
      },
      Turn::after_log);
}

}  // namespace hoist::server::api
