// Accounts, sign-ins, tokens, roles and the audit log: over real sockets, and by themselves where time must pass.
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <future>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "server/api/download_log.hpp"
#include "server/contract/audit.hpp"
#include "server/contract/jobs.hpp"
#include "server/contract/routes.hpp"
#include "server/http/auth.hpp"
#include "server/http/listener.hpp"
#include "server/people/passwords.hpp"
#include "server/people/people_desk.hpp"
#include "server/people/set_up.hpp"
#include "server/people/sign_in_guard.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

constexpr const char* kPassword = "four words not together";
constexpr const char* kOther = "another row of words";
// For what must happen with the answer, not when the connection is found silent (5 s).
constexpr std::chrono::milliseconds kAtOnce{2000};

// A browser: sends its cookie and the headers that the console sends.
struct Browser {
  std::uint16_t port = 0;
  std::string cookie;
  std::string address_header;

  Answer call(const std::string& method, const std::string& target, const json& body = nullptr, const Headers& more = {}) {
    Headers headers{{"X-Hoist", "1"}, {"Origin", "http://127.0.0.1:" + std::to_string(port)}};
    if (!cookie.empty()) headers.emplace_back("Cookie", cookie);
    add_any_tag(headers, method, more);
    if (!body.is_null()) headers.emplace_back("Content-Type", "application/json");
    headers.insert(headers.end(), more.begin(), more.end());
    Answer answer = http(port, method, target, headers, body.is_null() ? "" : body.dump());
    if (const std::string set = answer.header("set-cookie"); !set.empty()) cookie = set.substr(0, set.find(';'));
    return answer;
  }
  unsigned sign_in(const std::string& user, const std::string& password) {
    return call("POST", "/api/v1/session", {{"user", user}, {"password", password}}).status;
  }
  json who() { return call("GET", "/api/v1/session").json(); }
  std::string ticket() { return call("POST", "/api/v1/ws-ticket", json::object()).json()["ticket"]; }
  std::unique_ptr<Live> live(const std::string& with_ticket) {
    return std::make_unique<Live>(port, Headers{{"Cookie", cookie}, {"Origin", "http://127.0.0.1:" + std::to_string(port)}}, "hoist.v1",
                                  "/ws" + (with_ticket.empty() ? "" : "?ticket=" + with_ticket));
  }
};

// The digest of an audit row as its chain defines it: the digest before and each field, every one with its length in front, through SHA-256.
std::string chained(const json& row, const std::string& before) {
  std::string bytes;
  const auto add = [&bytes](const std::string& text) { bytes += std::to_string(text.size()) + ":" + text; };
  const auto text = [&row](const char* name) { return row[name].get<std::string>(); };
  add(before);
  add(row["utc_ms"].dump());
  add(row["steady_ns"].dump());
  for (const char* name : {"user", "role", "address", "action", "target"}) add(text(name));
  for (const char* name : {"before", "after"}) row[name].is_null() ? void(bytes += "-") : add(text(name));
  add(text("result"));
  return server::digest_of_secret(bytes);
}

class People : public ServerTest {
 protected:
  json audit_rows() { return get("/api/v1/audit?limit=200").json()["items"]; }
  // The newest one of this action; some ask for it without waiting for the answer.
  json audit_row(const std::string& user, const std::string& action) {
    json found;
    EXPECT_TRUE(until([&] {
      for (const json& row : audit_rows()) {
        if (row["user"] != user || row["action"] != action) continue;
        found = row;
        return true;
      }
      return false;
    })) << user
        << " " << action;
    return found;
  }
  Browser browser() { return {port_, "", ""}; }
  void turn_switch(bool on) {
    core_->set([on](contract::TickRecord& record) { record.switches = on ? 2 : 0; });
    ASSERT_TRUE(until([&] { return browser().who()["set_up"]["switch_on"] == on; }));
  }
  // As a person at the hoist, beside the requests of others.
  void turn_switch_here(bool on) {
    elsewhere_ = false;
    turn_switch(on);
  }
  std::string code() {
    const std::lock_guard lock(code_mutex_);
    return code_;
  }
  static json engineer(const std::string& with_code) {
    return {{"code", with_code}, {"user", "erika"}, {"display_name", "Erika E."}, {"password", kPassword}};
  }
  void set_up_engineer() {
    turn_switch(true);
    ASSERT_EQ(browser().call("POST", "/api/v1/setup", engineer(code())).status, 200U);
    turn_switch(false);
  }
  void add_user(const std::string& name, const std::string& role) {
    const Answer added =
        call("POST", "/api/v1/users", {{"user", name}, {"display_name", name + " D."}, {"role", role}, {"password", kPassword}});
    ASSERT_EQ(added.status, 201U) << added.body;
  }
  Browser signed_in(const std::string& name) {
    Browser one = browser();
    EXPECT_EQ(one.sign_in(name, kPassword), 200U);
    return one;
  }
  std::string accounts_bytes() {
    std::string bytes;
    for (const char* suffix : {"", "-wal"}) {
      std::ifstream in(folder_ / ("accounts.db" + std::string(suffix)), std::ios::binary);
      bytes.append(std::istreambuf_iterator<char>(in), {});
    }
    return bytes;
  }
};

TEST_F(People, the_first_engineer_needs_the_switch_and_the_code) {
  EXPECT_EQ(browser().who()["set_up"]["needed"], true);
  EXPECT_EQ(browser().call("POST", "/api/v1/setup", engineer("12345678")).status, 403U);
  turn_switch(true);
  ASSERT_EQ(code().size(), 8U);
  EXPECT_GT(browser().who()["set_up"]["seconds_left"], 500);
  Answer weak = browser().call("POST", "/api/v1/setup",
                               {{"code", code()}, {"user", "erika"}, {"display_name", "E"}, {"password", "passwordpassword"}});
  EXPECT_EQ(weak.status, 422U);
  EXPECT_EQ(weak.json()["errors"][0]["field"], "password");
  // Five wrong codes close it, whatever comes then.
  const std::string right = code();
  for (int i = 0; i < 5; ++i)
    EXPECT_EQ(browser().call("POST", "/api/v1/setup", engineer(right == "00000000" ? "1" : "00000000")).status, 403U);
  EXPECT_EQ(browser().call("POST", "/api/v1/setup", engineer(right)).status, 403U);
  turn_switch(false);
  turn_switch(true);
  ASSERT_NE(code(), right);
  const Answer made = browser().call("POST", "/api/v1/setup", engineer(code()));
  ASSERT_EQ(made.status, 200U) << made.body;
  EXPECT_EQ(browser().call("POST", "/api/v1/setup", engineer(code())).status, 403U) << "the code works once";
  EXPECT_EQ(browser().who()["set_up"]["needed"], false);
  Browser erika = signed_in("erika");
  const json who = erika.who();
  EXPECT_EQ(who["user"], "erika");
  EXPECT_EQ(who["display_name"], "Erika E.");
  EXPECT_EQ(who["role"], "engineer");
}

TEST_F(People, a_lost_password_is_replaced_at_the_switch_and_signs_everybody_out_under_that_name) {
  set_up_engineer();
  Browser before = signed_in("erika");
  turn_switch(true);
  json again = engineer(code());
  again["password"] = kOther;
  ASSERT_EQ(browser().call("POST", "/api/v1/setup", again).status, 200U);
  EXPECT_EQ(before.call("GET", "/api/v1/status").status, 401U);
  EXPECT_EQ(browser().sign_in("erika", kOther), 200U);
  EXPECT_EQ(browser().sign_in("erika", kPassword), 401U);
}

TEST_F(People, signing_in_gives_a_new_secret_and_a_wrong_one_says_nothing) {
  set_up_engineer();
  Browser one = browser();
  one.cookie = "hoist_session=" + std::string(64, 'a');  // put there by somebody else
  const Answer in = one.call("POST", "/api/v1/session", {{"user", "erika"}, {"password", kPassword}});
  ASSERT_EQ(in.status, 200U);
  for (const char* words : {"; HttpOnly", "; SameSite=Strict", "; Path=/"})
    EXPECT_NE(in.header("set-cookie").find(words), std::string::npos) << in.header("set-cookie");
  EXPECT_EQ(one.cookie.find(std::string(64, 'a')), std::string::npos);
  const std::string first = one.cookie;
  ASSERT_EQ(one.sign_in("erika", kPassword), 200U);
  EXPECT_NE(one.cookie, first);
  Browser old{port_, first, ""};
  EXPECT_EQ(old.call("GET", "/api/v1/status").status, 401U) << "a browser has one sign-in";
  EXPECT_EQ(old.call("POST", "/api/v1/stop").status, 200U) << "STOP works with an ended one";
  // Known and unknown names: the same answer.
  const Answer wrong = browser().call("POST", "/api/v1/session", {{"user", "erika"}, {"password", "not the password"}});
  const Answer nobody = browser().call("POST", "/api/v1/session", {{"user", "nobody"}, {"password", "not the password"}});
  EXPECT_EQ(wrong.status, 401U);
  EXPECT_EQ(wrong.body, nobody.body);
  // Neither password nor secrets stand in the file.
  const std::string bytes = accounts_bytes();
  EXPECT_EQ(bytes.find(kPassword), std::string::npos);
  EXPECT_EQ(bytes.find(one.cookie.substr(one.cookie.find('=') + 1)), std::string::npos);
  struct stat info {};
  ASSERT_EQ(::stat((folder_ / "accounts.db").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777U, 0600U);
}

TEST_F(People, pages_of_others_cannot_sign_in_or_act_with_the_cookie) {
  set_up_engineer();
  const std::string body = json{{"user", "erika"}, {"password", kPassword}}.dump();
  const Headers json_type{{"Content-Type", "application/json"}};
  Headers no_header = json_type;
  EXPECT_EQ(http(port_, "POST", "/api/v1/session", no_header, body).status, 403U) << "X-Hoist is missing";
  Headers foreign = {{"Content-Type", "application/json"}, {"X-Hoist", "1"}, {"Origin", "http://evil.example"}};
  EXPECT_EQ(http(port_, "POST", "/api/v1/session", foreign, body).status, 403U);
  for (const char* near : {"http://127.0.0.1", "http://127.0.0.1:1", "null", "https://127.0.0.1"}) {
    foreign.back().second = near;
    EXPECT_EQ(http(port_, "POST", "/api/v1/session", foreign, body).status, 403U) << near;
  }
  Headers other_host = {{"Content-Type", "application/json"}, {"X-Hoist", "1"}, {"Host", "hoist.evil.example"}};
  EXPECT_EQ(http(port_, "POST", "/api/v1/session", other_host, body).status, 421U);
}

TEST_F(People, guessing_is_slowed_for_the_guesser_and_not_for_the_owner) {
  set_up_engineer();
  Browser known = signed_in("erika");
  std::vector<unsigned> got;
  for (int i = 0; i < 8; ++i) got.push_back(browser().sign_in("erika", "wrong password " + std::to_string(i)));
  EXPECT_EQ(got[0], 401U);
  EXPECT_GT(std::count(got.begin(), got.end(), 429U), 4) << "1, 2, 4 … s";
  const Answer told = browser().call("POST", "/api/v1/session", {{"user", "erika"}, {"password", kPassword}});
  EXPECT_EQ(told.status, 429U);
  EXPECT_GE(std::stoi(told.header("retry-after")), 1);
  // The browser on which she has signed in before has a count of its own.
  EXPECT_EQ(known.sign_in("erika", kPassword), 200U);
}

TEST_F(People, a_pin_works_only_where_its_owner_has_been) {
  set_up_engineer();
  add_user("anna", "therapist");
  add_user("bert", "therapist");
  Browser tablet = signed_in("anna");
  ASSERT_EQ(tablet.call("PUT", "/api/v1/session/pin", {{"password", "wrong password"}, {"pin", "4711"}}).status, 422U);
  Browser tablet2 = signed_in("anna");
  EXPECT_EQ(tablet2.call("PUT", "/api/v1/session/pin", {{"password", kPassword}, {"pin", "1234"}}).status, 422U) << "a row of digits";
  ASSERT_EQ(tablet2.call("PUT", "/api/v1/session/pin", {{"password", kPassword}, {"pin", "4711"}}).status, 200U);
  ASSERT_EQ(tablet2.sign_in("bert", kPassword), 200U);
  const auto here = [&] {
    const json who = tablet2.who();
    std::vector<std::string> names;
    for (const json& one : who["here"]) names.push_back(one["user"]);
    return names;
  };
  EXPECT_EQ(here(), std::vector<std::string>{"anna"}) << "bert has no PIN";
  // A PIN of another device counts here, too.
  Browser bert = signed_in("bert");
  for (const json& pin : {json("5822"), json()}) {
    ASSERT_EQ(bert.call("PUT", "/api/v1/session/pin", {{"password", kPassword}, {"pin", pin}}).status, 200U);
    EXPECT_EQ(here().size(), pin.is_null() ? 1U : 2U);
  }
  const Answer back = tablet2.call("POST", "/api/v1/session", {{"user", "anna"}, {"pin", "4711"}});
  ASSERT_EQ(back.status, 200U) << back.body;
  EXPECT_EQ(tablet2.who()["user"], "anna");
  EXPECT_EQ(browser().call("POST", "/api/v1/session", {{"user", "anna"}, {"pin", "4711"}}).status, 403U) << "another device";
  // Five wrong ones, however far apart: then the password.
  Answer wrong = tablet2.call("POST", "/api/v1/session", {{"user", "anna"}, {"pin", "4712"}});
  EXPECT_EQ(wrong.status, 401U);
}

// The device to be kept out has signed in before and has set the PIN itself.
TEST_F(People, a_new_password_ends_the_pin_and_forgets_the_devices) {
  set_up_engineer();
  add_user("anna", "therapist");
  const json by_pin{{"user", "anna"}, {"pin", "4711"}};
  std::string password = kPassword;
  const auto stranger_with_pin = [&] {
    Browser stranger = browser();
    EXPECT_EQ(stranger.sign_in("anna", password), 200U);
    EXPECT_EQ(stranger.call("PUT", "/api/v1/session/pin", {{"password", password}, {"pin", "4711"}}).status, 200U);
    return stranger;
  };
  const auto expect_kept_out = [&](Browser& stranger, const char* how) {
    const Answer refused = stranger.call("POST", "/api/v1/session", by_pin);
    EXPECT_EQ(refused.status, 403U) << how << " " << refused.body;
    EXPECT_EQ(stranger.who()["here"].size(), 0U) << how;
    EXPECT_EQ(stranger.call("POST", "/api/v1/stop").status, 200U) << how << ": STOP works with an ended sign-in";
    stop_server();
    start_server();
    wait_for_core();
    stranger.port = port_;
    EXPECT_EQ(stranger.call("POST", "/api/v1/session", by_pin).status, 403U) << how << ", after a restart";
  };

  Browser stranger = stranger_with_pin();
  Browser anna = signed_in("anna");
  ASSERT_EQ(anna.call("PUT", "/api/v1/session/password", {{"password", password}, {"new_password", kOther}}).status, 200U);
  EXPECT_EQ(anna.who()["has_pin"], false);
  EXPECT_EQ(anna.call("POST", "/api/v1/session", by_pin).status, 401U) << "her own device is known, but the PIN is gone";
  expect_kept_out(stranger, "by herself");

  password = kOther;
  stranger = stranger_with_pin();
  ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"password", kPassword}}).status, 200U);
  expect_kept_out(stranger, "by an engineer");

  password = kPassword;
  stranger = stranger_with_pin();
  turn_switch(true);
  json again = engineer(code());
  again["user"] = "anna";
  ASSERT_EQ(browser().call("POST", "/api/v1/setup", again).status, 200U);
  expect_kept_out(stranger, "at the switch");
}

TEST_F(People, a_socket_needs_a_fresh_ticket_of_its_own_session) {
  set_up_engineer();
  Browser one = signed_in("erika");
  EXPECT_EQ(one.live("")->status(), 403U);
  const std::string ticket = one.ticket();
  auto socket = one.live(ticket);
  ASSERT_EQ(socket->status(), 101U);
  EXPECT_EQ(one.live(ticket)->status(), 403U) << "used up";
  Browser other = signed_in("erika");
  EXPECT_EQ(other.live(one.ticket())->status(), 403U) << "another session's";
}

TEST_F(People, a_changed_role_and_a_disabled_account_hold_at_once) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  auto socket = anna.live(anna.ticket());
  ASSERT_EQ(socket->status(), 101U);
  ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"role", "viewer"}}).status, 200U);
  EXPECT_EQ(socket->wait_close(kAtOnce), 1008U);
  const Answer refused = anna.call("POST", "/api/v1/lease", json::object());
  EXPECT_EQ(refused.status, 403U);
  EXPECT_NE(refused.json()["type"].get<std::string>().find("role"), std::string::npos);
  ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"enabled", false}}).status, 200U);
  EXPECT_EQ(anna.call("GET", "/api/v1/status").status, 401U);
  EXPECT_EQ(anna.call("POST", "/api/v1/stop").status, 200U);
  EXPECT_EQ(browser().sign_in("anna", kPassword), 401U);
  // One engineer remains.
  const Answer last = call("PATCH", "/api/v1/users/erika", {{"role", "viewer"}});
  EXPECT_EQ(last.status, 409U);
  EXPECT_EQ(call("PATCH", "/api/v1/users/nobody", {{"role", "viewer"}}).status, 404U);
}

// The route lets a therapist in; what a kind of job needs stands in its row of jobs.def.
TEST_F(People, a_job_is_started_and_cancelled_by_the_role_of_its_kind) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna"), erika = signed_in("erika");
  const auto by_role = [](const Answer& answer) { return answer.status == 403 && answer.json().value("type", "") == "/problems/role"; };
  std::size_t begun = 0;
  for (const server::JobKindInfo& kind : server::kJobKinds) {
    json wish{{"kind", kind.name}};
    if (kind.name == "restore") wish["backup"] = "none";
    if (kind.name == "preview_retention") wish["rule"] = {{"days", 90}, {"disk_percent", nullptr}, {"needs_backup", false}};
    const Answer answer = anna.call("POST", "/api/v1/jobs", wish);
    EXPECT_EQ(by_role(answer), kind.role == contract::Role::engineer) << kind.name << " " << answer.body;
    begun += answer.status == 202U ? 1 : 0;
  }
  EXPECT_GT(begun, 0U);
  const Answer engineers = erika.call("POST", "/api/v1/jobs", {{"kind", "list_backups"}});
  ASSERT_EQ(engineers.status, 202U) << engineers.body;
  const std::string place = engineers.header("location");
  EXPECT_TRUE(by_role(anna.call("DELETE", place)));
  // By then it may have ended, which is told to those who may cancel it.
  EXPECT_FALSE(by_role(erika.call("DELETE", place)));
  // Nor is the role of a parameter that of its route.
  const auto engineers_own = std::ranges::find(contract::kParams, contract::Role::engineer, &contract::ParamInfo::role);
  ASSERT_NE(engineers_own, contract::kParams.end());
  const std::string parameter = "/api/v1/parameters/" + std::string(engineers_own->name);
  EXPECT_TRUE(by_role(anna.call("PUT", parameter, {{"value", engineers_own->default_value}})));
}

TEST_F(People, who_signs_out_while_driving_leaves_the_lease_and_can_still_stop) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  auto socket = anna.live(anna.ticket());
  ASSERT_EQ(socket->ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_TRUE(until([&] { return get("/api/v1/status").json()["lease"]["holder"] != 0; }));
  ASSERT_EQ(anna.call("DELETE", "/api/v1/session").status, 200U);
  EXPECT_EQ(socket->wait_close(kAtOnce), 1008U);
  EXPECT_TRUE(until([&] { return get("/api/v1/status").json()["lease"]["holder"] == 0; }));
  EXPECT_EQ(anna.call("GET", "/api/v1/status").status, 401U);
  EXPECT_EQ(anna.call("POST", "/api/v1/stop").status, 200U);
}

TEST_F(People, a_token_does_what_its_scope_and_its_owner_may_until_it_is_removed) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  const auto made = [&](const char* scope) {
    const Answer answer = anna.call("POST", "/api/v1/tokens", {{"name", "foxglove"}, {"scope", scope}, {"days", 30}});
    EXPECT_EQ(answer.status, 201U) << answer.body;
    return answer.json();
  };
  const json viewer = made("viewer"), engineer_scope = made("engineer");
  const auto with = [&](const json& token, const std::string& method, const std::string& target, const std::string& body = "") {
    Headers headers{{"Authorization", "Bearer " + token["token"].get<std::string>()}};
    if (!body.empty()) headers.emplace_back("Content-Type", "application/json");
    return http(port_, method, target, headers, body).status;
  };
  EXPECT_EQ(with(viewer, "GET", "/api/v1/status"), 200U);
  EXPECT_EQ(with(viewer, "POST", "/api/v1/lease", "{}"), 403U);
  EXPECT_EQ(with(engineer_scope, "GET", "/api/v1/users"), 403U) << "never more than its owner";
  EXPECT_EQ(Live(port_, {{"Authorization", "Bearer " + viewer["token"].get<std::string>()}}).status(), 101U);
  EXPECT_EQ(anna.call("GET", "/api/v1/tokens").json()["items"].size(), 2U);
  Browser erika = signed_in("erika");
  EXPECT_EQ(erika.call("GET", "/api/v1/tokens").json()["items"].size(), 2U) << "an engineer sees all";
  add_user("bert", "therapist");
  Browser bert = signed_in("bert");
  EXPECT_EQ(bert.call("DELETE", "/api/v1/tokens/" + viewer["id"].dump()).status, 404U) << "another one's";
  EXPECT_EQ(anna.call("DELETE", "/api/v1/tokens/" + viewer["id"].dump()).status, 204U);
  EXPECT_EQ(with(viewer, "GET", "/api/v1/status"), 401U);
}

TEST_F(People, sign_ins_and_tokens_survive_a_restart_and_changes_while_it_ran) {
  set_up_engineer();
  add_user("anna", "therapist");
  add_user("bert", "therapist");
  Browser anna = signed_in("anna"), bert = signed_in("bert");
  const json token = anna.call("POST", "/api/v1/tokens", {{"name", "script"}, {"scope", "viewer"}, {"days", 1}}).json();
  ASSERT_EQ(call("PATCH", "/api/v1/users/bert", {{"enabled", false}}).status, 200U);
  stop_server();
  start_server();
  wait_for_core();
  anna.port = bert.port = port_;
  EXPECT_EQ(anna.call("GET", "/api/v1/status").status, 200U);
  EXPECT_EQ(bert.call("GET", "/api/v1/status").status, 401U);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Authorization", "Bearer " + token["token"].get<std::string>()}}).status, 200U);
}

// Every route with every kind of person: what the table of routes says, holds.
TEST_F(People, every_route_asks_for_its_role) {
  set_up_engineer();
  for (const char* role : {"viewer", "therapist", "engineer"}) add_user("a." + std::string(role), role);
  struct Caller {
    std::string name;
    Headers headers;
    int rank;  // -1 = not signed in
  };
  Headers page{{"X-Hoist", "1"}, {"Origin", origin()}};
  const auto cookie_of = [&](Browser one) {
    Headers headers = page;
    headers.emplace_back("Cookie", one.cookie);
    return headers;
  };
  Browser ended = signed_in("a.engineer");
  ASSERT_EQ(ended.call("DELETE", "/api/v1/session").status, 200U);
  // A sign-in and a token whose time is up, as the server finds them when it starts.
  Browser late = signed_in("a.engineer");
  const json token = late.call("POST", "/api/v1/tokens", {{"name", "old"}, {"scope", "engineer"}, {"days", 1}}).json();
  stop_server();
  const std::string digest = server::digest_of_secret(late.cookie.substr(late.cookie.find('=') + 1));
  sqlite3* file = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "accounts.db").c_str(), &file), SQLITE_OK);
  for (const std::string& sql : {"UPDATE sign_ins SET begun_s = 1, used_s = 1 WHERE secret_sha256 = '" + digest + "'",
                                 std::string("UPDATE tokens SET expires_s = 1")}) {
    ASSERT_EQ(sqlite3_exec(file, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    ASSERT_EQ(sqlite3_changes(file), 1) << sql;
  }
  sqlite3_close(file);
  start_server();
  wait_for_core();
  page = {{"X-Hoist", "1"}, {"Origin", origin()}};
  const Headers expired_token{{"Authorization", "Bearer " + token["token"].get<std::string>()}};
  // The browser of an engineer, on a page of another origin.
  const auto elsewhere = [&] {
    return Headers{{"X-Hoist", "1"}, {"Origin", "http://example.org"}, {"Cookie", signed_in("a.engineer").cookie}};
  };
  Headers unknown = page;
  unknown.emplace_back("Cookie", "hoist_session=" + std::string(64, '0'));
  Headers forged{{"Authorization", "Bearer " + std::string(64, '0')}};
  const auto everybody = [&] {
    return std::vector<Caller>{{"nobody", page, -1},
                               {"unknown cookie", unknown, -1},
                               {"forged token", forged, -1},
                               {"ended", cookie_of(ended), -1},
                               {"expired", cookie_of(late), -1},
                               {"expired token", expired_token, -1},
                               {"another page", elsewhere(), -1},
                               {"viewer", cookie_of(signed_in("a.viewer")), 0},
                               {"therapist", cookie_of(signed_in("a.therapist")), 1},
                               {"engineer", cookie_of(signed_in("a.engineer")), 2}};
  };
  std::vector<Caller> callers = everybody();
  int asked = 0;
  for (const server::Route& route : server::kRoutes) {
    if (route.access == server::Access::open) continue;
    std::string path(route.path);
    for (std::size_t at = path.find('{'); at != std::string::npos; at = path.find('{')) path.replace(at, path.find('}') - at + 1, "0");
    std::string method;
    for (const char c : server::method_name(route.method)) method.push_back(static_cast<char>(std::toupper(c)));
    const int least = static_cast<int>(route.access) - 1;
    // Tools show a token; a cookie does not count for them.
    const bool tool = route.operation == "open_foxglove" || route.operation == "open_rosbridge";
    for (const Caller& caller : callers) {
      const Answer answer = http(port_, method, path, caller.headers);
      ++asked;
      const std::string what = caller.name + ": " + method + " " + path + " answered " + std::to_string(answer.status) + " " + answer.body;
      const bool by_role = answer.status == 403 && answer.body.find("/role\"") != std::string::npos;
      if (route.operation == "stop" && (caller.name == "ended" || caller.name == "expired"))
        EXPECT_EQ(answer.status, 200U) << what;
      else if (caller.name == "another page" && !tool)
        EXPECT_TRUE(answer.status == 403 && answer.body.find("/foreign-origin\"") != std::string::npos) << what;
      else if (caller.rank < 0 || tool)
        EXPECT_EQ(answer.status, 401U) << what;
      else
        EXPECT_EQ(by_role, caller.rank < least) << what;
      if (caller.rank >= 0 && !tool) {
        EXPECT_NE(answer.status, 401U) << what;
      }
    }
    if (route.operation == "sign_out") callers = everybody();
  }
  EXPECT_GT(asked, 300);
}

TEST_F(People, the_audit_log_names_who_did_what_and_finds_changes) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  (void)browser().sign_in("anna", "not the password");
  ASSERT_EQ(anna.call("POST", "/api/v1/lease", json::object()).status, 200U);
  ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"role", "viewer"}}).status, 200U);
  const auto rows = [&] { return get("/api/v1/audit?limit=200").json()["items"]; };
  const auto has = [&](const std::string& user, const std::string& action, const std::string& result) {
    for (const json& row : rows())
      if (row["user"] == user && row["action"] == action && row["result"] == result) return true;
    return false;
  };
  // Who did something finds it there.
  EXPECT_TRUE(has("erika", "set_up", "done"));
  EXPECT_TRUE(has("anna", "sign_in", "done"));
  EXPECT_TRUE(has("anna", "sign_in", "wrong-secret"));
  EXPECT_TRUE(has("anna", "take_lease", "done"));
  EXPECT_TRUE(has("local", "add_user", "done"));
  const json changed = audit_row("local", "change_user");
  EXPECT_EQ(changed["before"], "therapist");
  EXPECT_EQ(changed["after"], "viewer");
  const std::string whole = rows().dump();
  EXPECT_EQ(whole.find(kPassword), std::string::npos);
  for (const char* action : {"add_user", "change_user"})
    EXPECT_EQ(std::ranges::count_if(rows(), [&](const json& row) { return row["action"] == action; }), 1)
        << action << " is one row, not two";
  // Pages.
  const json first = get("/api/v1/audit?limit=2").json();
  ASSERT_EQ(first["items"].size(), 2U);
  const json second = get("/api/v1/audit?limit=2&cursor=" + first["next"].get<std::string>()).json();
  EXPECT_LT(second["items"][0]["id"], first["items"][1]["id"]);

  // Each row by its digest, and by that of the row before.
  const json all = rows();
  std::string before(64, '0');
  for (auto row = all.rbegin(); row != all.rend(); ++row) {
    EXPECT_EQ((*row)["digest"], chained(*row, before)) << *row;
    before = (*row)["digest"];
  }
  const json sound = get("/api/v1/audit/check").json();
  EXPECT_TRUE(sound["first_wrong"].is_null());
  EXPECT_GT(sound["rows"], 4);
  stop_server();
  sqlite3* file = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "accounts.db").c_str(), &file), SQLITE_OK);
  EXPECT_NE(sqlite3_exec(file, "UPDATE audit SET user = 'bert' WHERE id = 2", nullptr, nullptr, nullptr), SQLITE_OK) << "only added to";
  EXPECT_NE(sqlite3_exec(file, "DELETE FROM audit WHERE id = 2", nullptr, nullptr, nullptr), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(file, "DROP TRIGGER audit_keeps_rows; UPDATE audit SET user = 'bert' WHERE id = 3", nullptr, nullptr, nullptr),
            SQLITE_OK);
  sqlite3_close(file);
  start_server();
  wait_for_core();
  EXPECT_EQ(get("/api/v1/audit/check").json()["first_wrong"], 3);
  stop_server();
  ASSERT_EQ(sqlite3_open((folder_ / "accounts.db").c_str(), &file), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(file, "DROP TRIGGER audit_loses_none; DELETE FROM audit WHERE id = 1", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(file);
  start_server();
  wait_for_core();
  EXPECT_EQ(get("/api/v1/audit/check").json()["first_wrong"], 2) << "the one before is missing";
}

// What a therapist asks on a WebSocket stands in the audit log as over REST.
TEST_F(People, every_message_and_tool_writes_the_audit_log) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  auto socket = anna.live(anna.ticket());
  ASSERT_EQ(socket->status(), 101U);
  // Messages that ask nothing of the hoist, and driving, which is in the recording.
  const std::set<std::string> silent{"drive", "stream", "ping"};
  const std::map<std::string, std::string> actions{{"lease_take", "take_lease"},
                                                   {"lease_release", "release_lease"},
                                                   {"lease_ask", "ask_lease"},
                                                   {"lease_keep", "keep_lease"},
                                                   {"lease_hand_over", "hand_over"},
                                                   {"mode", "start_motion"},
                                                   {"stop", "stop"},
                                                   {"acknowledge", "acknowledge"},
                                                   {"pause_alarm", "pause_alarm"},
                                                   {"set", "change_parameters"},
                                                   {"keep_settings", "keep_parameters"},
                                                   {"undo_settings", "undo_parameters"},
                                                   {"preset", "apply_preset"},
                                                   {"choose", "choose_exercise"},
                                                   {"choose_patient", "choose_patient"},
                                                   {"neutral", "set_neutral"},
                                                   {"calibrate", "begin_calibration"},
                                                   {"calibrate_measure", "measure_calibration"},
                                                   {"calibrate_use", "use_calibration"},
                                                   {"calibrate_cancel", "cancel_calibration"},
                                                   {"pose", "set_pose"},
                                                   {"marker", "add_marker"}};
  const std::map<std::string, json> fields{{"lease_hand_over", {{"user", "nobody"}}},
                                           {"mode", {{"mode", "user"}}},
                                           {"pause_alarm", {{"paused", true}}},
                                           {"set", {{"values", {{"lean_tau_normal_s", 0.5}}}}},
                                           {"preset", {{"name", "walk"}}},
                                           {"choose", {{"exercise", {{"shape", "free"}}}}},
                                           {"choose_patient", {{"patient", 4711}}},
                                           {"calibrate", {{"step", "zero"}}},
                                           {"calibrate_measure", {{"figure", 1}}},
                                           {"pose", {{"x_m", 0}, {"y_m", 0}, {"psi_rad", 0}}},
                                           {"marker", {{"text", "here"}}}};
  for (const auto& [type, answered] : std::initializer_list<std::pair<std::string, bool>>{
#define HOIST_IN(type, answered, ...) {#type, (answered) != 0},
#define HOIST_OUT(...)
#define HOIST_FIELD(...)
#include "server/contract/messages.def"
#undef HOIST_IN
#undef HOIST_OUT
#undef HOIST_FIELD
       }) {
    if (silent.contains(type)) continue;
    ASSERT_TRUE(actions.contains(type)) << "a new message: which action is it?";
    json message = fields.contains(type) ? fields.at(type) : json::object();
    message["type"] = type;
    if (answered) {
      const json reply = socket->ask(message);
      EXPECT_NE(reply.value("reason_code", ""), "message") << reply;
      const json row = audit_row("anna", actions.at(type));
      EXPECT_EQ(row["result"] == "done", reply["ok"]) << row << reply;
    } else {
      socket->send(message);
    }
    const json row = audit_row("anna", actions.at(type));
    EXPECT_TRUE(row["target"].get<std::string>().starts_with("hoist.v1")) << row;
    EXPECT_EQ(row["address"], "127.0.0.1") << row;
    EXPECT_EQ(row["role"], "therapist");
  }
  const json set = audit_row("anna", "change_parameters");
  EXPECT_EQ(set["after"], R"({"lean_tau_normal_s":0.5})");
  EXPECT_NE(set["before"].get<std::string>().find("lean_tau_normal_s"), std::string::npos) << set;
  EXPECT_EQ(audit_row("anna", "choose_patient")["target"], "hoist.v1 patient 4711");
  // A role that may not is refused and noted, too.
  add_user("vera", "viewer");
  Browser vera = signed_in("vera");
  auto watching = vera.live(vera.ticket());
  EXPECT_EQ(watching->ask({{"type", "lease_take"}})["reason_code"], "role");
  EXPECT_EQ(audit_row("vera", "take_lease")["result"], "not_allowed");
  // REST: one row per request, not two.
  ASSERT_EQ(anna.call("POST", "/api/v1/lease", json::object()).status, 200U);
  EXPECT_TRUE(until([&] { return audit_row("anna", "take_lease")["target"].get<std::string>().starts_with("rest"); }));
  ASSERT_EQ(anna.call("DELETE", "/api/v1/lease").status, 200U);
  EXPECT_EQ(anna.call("POST", "/api/v1/neutral", json{{"unknown", 1}}).status, 422U);
  ASSERT_TRUE(until([&] { return audit_row("anna", "set_neutral")["result"] == "422"; })) << "refused before it became an action";
  const json rows = audit_rows();
  EXPECT_EQ(std::ranges::count_if(rows, [](const json& row) { return row["user"] == "anna" && row["action"] == "release_lease"; }), 2);
  EXPECT_TRUE(std::ranges::none_of(rows, [](const json& row) { return row["action"] == "take_lease" && row["result"] == "200"; }));
}

TEST_F(People, tools_come_by_a_token_in_the_address_that_no_log_holds) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  const std::string token = anna.call("POST", "/api/v1/tokens", {{"name", "tools"}, {"scope", "therapist"}, {"days", 1}}).json()["token"];
  ASSERT_EQ(call("PUT", "/api/v1/tools", {{"enabled", true}}).status, 200U);
  Live ros(port_, {}, "", "/rosbridge?token=" + token);
  ASSERT_EQ(ros.status(), 101U);
  ros.send({{"op", "call_service"}, {"service", "/hoist/take_control"}});
  json row = audit_row("anna", "take_lease");
  EXPECT_TRUE(row["target"].get<std::string>().starts_with("rosbridge")) << row;
  EXPECT_EQ(row["result"], "done");
  Live studio(port_, {}, "foxglove.websocket.v1", "/foxglove?token=" + token);
  ASSERT_EQ(studio.status(), 101U);
  studio.send_binary(std::string("\x02\x00\x00\x00\x00\x01\x00\x00\x00\x04\x00\x00\x00json", 17));  // the service STOP
  row = audit_row("anna", "stop");
  EXPECT_TRUE(row["target"].get<std::string>().starts_with("foxglove")) << row;
  // Elsewhere a token in the address is nobody's.
  EXPECT_EQ(http(port_, "GET", "/api/v1/status?token=" + token).status, 401U);
  EXPECT_EQ(Live(port_, {}, "hoist.v1", "/ws?token=" + token).status(), 401U);
  // Where seats are scarce, it sits down like every signed-in client.
  std::vector<std::unique_ptr<Raw>> held;
  for (std::size_t i = 0; i < server::kAddressLimit; ++i) held.push_back(std::make_unique<Raw>(port_));
  EXPECT_TRUE(until([&] { return http(port_, "GET", "/").status == 503U; }));
  EXPECT_EQ(Live(port_, {}, "", "/rosbridge?token=" + std::string(64, '0')).status(), 503U);
  EXPECT_EQ(Live(port_, {}, "", "/rosbridge?token=" + token).status(), 101U);
  held.clear();
  EXPECT_EQ(audit_rows().dump().find(token), std::string::npos);
}

TEST_F(People, who_is_in_control_is_told_by_the_present_name_and_role) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  const auto actor = [&] { return get("/api/v1/lease").json()["actor"]; };
  {
    auto socket = anna.live(anna.ticket());
    ASSERT_EQ(socket->ask({{"type", "lease_take"}})["ok"], true);
    ASSERT_TRUE(until([&] { return actor().is_object(); }));
    EXPECT_EQ(actor()["user"], "anna");
    EXPECT_EQ(actor()["name"], "anna D.");
    ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"display_name", "Anna Weber"}}).status, 200U);
    EXPECT_EQ(actor()["name"], "Anna Weber");
    socket->close();
  }
  ASSERT_TRUE(until([&] { return actor().is_null(); }));
  // Over REST the sign-in stays the same client when its role changes.
  ASSERT_EQ(anna.call("POST", "/api/v1/lease", json::object()).status, 200U);
  ASSERT_TRUE(until([&] { return actor().is_object(); }));
  EXPECT_EQ(actor()["role"], "therapist");
  ASSERT_EQ(call("PATCH", "/api/v1/users/anna", {{"role", "engineer"}}).status, 200U);
  EXPECT_TRUE(until([&] { return actor().is_null(); })) << "what was held in the old role is given back";
  ASSERT_EQ(anna.call("POST", "/api/v1/lease", json::object()).status, 200U);
  ASSERT_TRUE(until([&] { return actor().is_object(); }));
  EXPECT_EQ(actor()["role"], "engineer");
  EXPECT_EQ(actor()["name"], "Anna Weber");
}

TEST_F(People, a_rest_client_ends_with_its_sign_in_or_token) {
  set_up_engineer();
  add_user("anna", "therapist");
  Browser anna = signed_in("anna");
  const std::string made = anna.call("POST", "/api/v1/tokens", {{"name", "script"}, {"scope", "therapist"}, {"days", 1}}).body;
  const json token = json::parse(made);
  const Headers script{{"Authorization", "Bearer " + token["token"].get<std::string>()}, {"Content-Type", "application/json"}};
  ASSERT_EQ(anna.call("DELETE", "/api/v1/session").status, 200U);
  // Until its end a token is somebody to hand over to; afterwards nobody.
  ASSERT_EQ(http(port_, "POST", "/api/v1/lease", script, "{}").status, 200U);
  ASSERT_EQ(call("DELETE", "/api/v1/tokens/" + token["id"].dump()).status, 204U);
  const auto began = std::chrono::steady_clock::now();
  ASSERT_TRUE(until([&] { return get("/api/v1/lease").json()["holder"] == 0; }));
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5)) << "at once, not after 10 s of silence";
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  EXPECT_TRUE(until([&] { return driver.ask({{"type", "lease_hand_over"}, {"user", "anna"}})["reason_code"] == "unknown"; }));
}

TEST_F(People, a_wrong_password_costs_the_right_one_a_second) {
  set_up_engineer();
  EXPECT_EQ(browser().sign_in("erika", "not the password"), 401U);
  const auto began = std::chrono::steady_clock::now();
  // Asking meanwhile is refused and puts nothing off.
  EXPECT_EQ(browser().sign_in("erika", kPassword), 429U);
  EXPECT_TRUE(until([&] { return browser().sign_in("erika", kPassword) == 200U; }));
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(2500));
}

// Other devices, before and after the first account.
TEST_F(People, other_devices_reach_the_set_up_only_until_there_is_an_account) {
  const std::string cookie = log_in();  // of this computer's link
  elsewhere_ = true;
  const Headers page{{"X-Hoist", "1"}, {"Origin", origin()}};
  Headers local_cookie = page, local_token = bearer_;
  local_cookie.emplace_back("Cookie", cookie);
  int refused = 0;
  for (const server::Route& route : server::kRoutes) {
    std::string path(route.path);
    for (std::size_t at = path.find('{'); at != std::string::npos; at = path.find('{')) path.replace(at, path.find('}') - at + 1, "0");
    std::string method;
    for (const char c : server::method_name(route.method)) method.push_back(static_cast<char>(std::toupper(c)));
    for (const Headers& headers : {page, local_cookie, local_token}) {
      const Answer answer = http(port_, method, path, headers);
      const bool by_gate = answer.status == 403 && answer.body.find("/set-up-first\"") != std::string::npos;
      const bool open = route.operation == "who_am_i" || route.operation == "set_up" || route.operation == "stop";
      EXPECT_EQ(by_gate, !open) << method << " " << path << ": " << answer.status << " " << answer.body;
      if (route.operation == "stop") {
        EXPECT_EQ(answer.status, headers == page ? 401U : 200U) << "STOP of whoever was ever signed in";
      }
      refused += by_gate ? 1 : 0;
    }
  }
  EXPECT_GT(refused, 200);
  EXPECT_EQ(http(port_, "GET", "/").status, 200U) << "the page of the set-up";
  EXPECT_EQ(http(port_, "GET", link_.substr(link_.find("/?"))).header("set-cookie"), "") << "the link is this computer's";
  turn_switch_here(true);
  elsewhere_ = true;
  EXPECT_EQ(browser().call("POST", "/api/v1/setup", engineer(code())).status, 200U);
  Browser erika = signed_in("erika");
  EXPECT_EQ(erika.call("GET", "/api/v1/status").status, 200U);
  EXPECT_EQ(http(port_, "GET", "/api/docs").status, 200U);
  // The link, its cookie and the token file stay this computer's own.
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", local_token).status, 401U);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", local_cookie).status, 401U);
  elsewhere_ = false;
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", local_token).status, 200U);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", local_cookie).status, 200U);
}

// Written when it is over, with the sum; what could not be told apart is one download.
TEST(DownloadLog, many_parts_of_one_file_are_one_row) {
  std::vector<db::AuditEntry> rows;
  server::DownloadLog log([&](db::AuditEntry entry) { rows.push_back(std::move(entry)); });
  constexpr std::uint64_t kSecond_ns = 1'000'000'000;
  const auto entry = [](const char* user, const char* target) {
    db::AuditEntry one;
    one.user = user;
    one.address = "10.0.0.7";
    one.action = "export_mcap";
    one.target = target;
    return one;
  };
  // Studio reads the end first, then the beginning, some bytes twice, others never.
  log.part(entry("anna", "/3"), "\"a\"", 100, 1000, kSecond_ns);
  for (int i = 0; i < 50; ++i) log.part(entry("anna", "/3"), "\"a\"", 30, 1000, 2 * kSecond_ns);
  log.part(entry("bert", "/3"), "\"a\"", 10, 1000, 2 * kSecond_ns);   // another person
  log.part(entry("anna", "/4"), "\"b\"", 10, 1000, 2 * kSecond_ns);   // another export
  log.part(entry("anna", "/3"), "\"a2\"", 10, 1000, 2 * kSecond_ns);  // of a session that was changed meanwhile
  log.tick(31 * kSecond_ns);
  EXPECT_TRUE(rows.empty()) << "none has rested for half a minute";
  log.part(entry("anna", "/3"), "\"a\"", 30, 1000, 31 * kSecond_ns);
  log.tick(33 * kSecond_ns);
  ASSERT_EQ(rows.size(), 3U);
  for (const db::AuditEntry& row : rows) EXPECT_EQ(row.after, "10 of 1000 bytes in 1 part");
  log.tick(62 * kSecond_ns);
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[3].user, "anna");
  EXPECT_EQ(rows[3].after, "1630 of 1000 bytes in 52 parts");
  // The whole at once is told at once; later parts are another download.
  log.part(entry("anna", "/3"), "\"a\"", 1000, 1000, 63 * kSecond_ns);
  EXPECT_EQ(rows.size(), 5U);
  // Bounded in number and in time, and nothing is lost at the end.
  rows.clear();
  for (std::size_t i = 0; i <= server::DownloadLog::kMost; ++i)
    log.part(entry("anna", std::to_string(i).c_str()), "c", 1, 9, (70 + i) * kSecond_ns / 10 + 64 * kSecond_ns);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].target, "0") << "the one that has rested longest";
  log.flush();
  EXPECT_EQ(rows.size(), server::DownloadLog::kMost + 1);
  rows.clear();
  for (std::uint64_t s = 0; s < 4000; s += 20) log.part(entry("anna", "/5"), "d", 1, 9000, (100 + s) * kSecond_ns);
  EXPECT_EQ(rows.size(), 1U) << "an hour";
}

// Both clocks show this time.
server::Clocks at(std::int64_t s) { return {static_cast<std::uint64_t>(s), s}; }

TEST(Tickets, open_one_socket_of_their_sign_in_within_half_a_minute) {
  std::string error;
  const auto auth = server::Auth::create({.token_file = "", .hosts = {}}, at(1000), error);
  ASSERT_NE(auth, nullptr) << error;
  const auto session = std::make_shared<server::Session>();
  const std::string first = auth->issue_ticket(session, at(1000)), late = auth->issue_ticket(session, at(1000));
  EXPECT_TRUE(auth->use_ticket(first, *session, at(1000 + server::kTicketLife_s)));
  EXPECT_FALSE(auth->use_ticket(first, *session, at(1000))) << "once";
  EXPECT_FALSE(auth->use_ticket(late, *session, at(1000 + server::kTicketLife_s + 1))) << "too late";
  EXPECT_FALSE(auth->use_ticket(late, *session, at(1000))) << "and gone with the attempt";
  const std::string oldest = auth->issue_ticket(session, at(2000));
  for (std::size_t i = 0; i < server::kTicketLimit; ++i) (void)auth->issue_ticket(session, at(2000));
  EXPECT_FALSE(auth->use_ticket(oldest, *session, at(2000))) << "a flood costs bounded memory";
}

TEST(SignInGuard, waits_double_to_a_minute_and_never_lock) {
  constexpr std::uint64_t kSecond_ns = 1'000'000'000;
  server::SignInGuard guard;
  std::uint64_t now_ns = 1000 * kSecond_ns;
  std::vector<std::uint64_t> waits;
  for (int i = 0; i < 9; ++i) {
    guard.failed("anna", "10.0.0." + std::to_string(i), now_ns);
    const std::uint64_t wait_s = guard.wait_s("anna", "10.1.1.1", now_ns);
    waits.push_back(wait_s);
    EXPECT_GT(guard.wait_s("anna", "10.1.1.1", now_ns + wait_s * kSecond_ns - 1), 0U);
    now_ns += wait_s * kSecond_ns;
    EXPECT_EQ(guard.wait_s("anna", "10.1.1.1", now_ns), 0U);
  }
  EXPECT_EQ(waits, (std::vector<std::uint64_t>{1, 2, 4, 8, 16, 32, 60, 60, 60}));
  guard.succeeded("anna", "10.0.0.8");
  EXPECT_EQ(guard.wait_s("anna", "10.1.1.1", now_ns), 0U);
  // Five failures a minute of one address, whatever the names.
  for (int i = 0; i < 5; ++i) guard.failed("name" + std::to_string(i), "10.2.2.2", now_ns);
  EXPECT_EQ(guard.wait_s("other", "10.2.2.2", now_ns), 60U);
  EXPECT_EQ(guard.wait_s("other", "10.2.2.3", now_ns), 0U);
  EXPECT_EQ(guard.wait_s("other", "10.2.2.2", now_ns + 60 * kSecond_ns), 0U);
  guard.take_back("name4", "10.2.2.2");
  EXPECT_EQ(guard.wait_s("other", "10.2.2.2", now_ns), 0U);
  // A row of failures is over after an hour without one; a PIN's few tries are not.
  for (int i = 0; i < 6; ++i) guard.failed("mia", "10.4.4." + std::to_string(i), now_ns);
  for (int i = 0; i < 4; ++i) guard.failed("mia#", "10.4.5." + std::to_string(i), now_ns, false);
  const std::uint64_t later_ns = now_ns + (server::kBackOffForgets_s + 1) * kSecond_ns;
  guard.failed("mia", "10.4.4.9", later_ns);
  guard.failed("mia#", "10.4.5.9", later_ns, false);
  EXPECT_EQ(guard.wait_s("mia", "10.4.4.10", later_ns), 1U);
  EXPECT_EQ(guard.failures("mia#"), 5U);
  // A flood costs bounded memory and still finds the latest name.
  for (int i = 0; i < 5000; ++i)
    guard.failed("flood" + std::to_string(i), "10.3." + std::to_string(i / 250) + "." + std::to_string(i % 250), now_ns + kSecond_ns);
  EXPECT_GT(guard.wait_s("flood4999", "10.9.9.9", now_ns + kSecond_ns), 0U);
}

TEST(Passwords, length_and_common_ones_are_refused_and_nothing_else_is_asked) {
  for (const char* good : {"four words not together", "aaaaaaaaaaab", "Tr0ub4dor&3xyz", "zwölf Zeichen"})
    EXPECT_EQ(server::password_fault(good, "anna"), "") << good;
  for (const std::string& bad :
       {std::string("elevenchars"), std::string(129, 'x'), std::string("passwordpassword"), std::string("Password12345"),
        std::string("aaaaaaaaaaaa"), std::string("123456789012"), std::string("Hoist-Hoist-1"), std::string("anna.anna.anna")})
    EXPECT_NE(server::password_fault(bad, "anna.anna.anna"), "") << bad;
  for (const char* pin : {"4711", "80235917"}) EXPECT_EQ(server::pin_fault(pin), "") << pin;
  for (const char* pin : {"471", "123456789", "47a1", "1111", "1234", "9876", ""}) EXPECT_NE(server::pin_fault(pin), "") << pin;
  const std::string hash = server::hash_secret("a secret", server::HashLimits());
  EXPECT_EQ(hash.rfind("$argon2id$v=19$m=65536,t=2,p=1$", 0), 0U) << hash;
  EXPECT_TRUE(server::secret_matches("a secret", hash));
  EXPECT_FALSE(server::secret_matches("a secreT", hash));
}

TEST(Sessions, an_account_is_over_after_a_quarter_of_an_hour_alone_or_a_working_day) {
  server::Session session;
  session.account = true;
  session.begun_s = session.used_s = 100000;
  using server::Auth;
  EXPECT_FALSE(Auth::over(session, at(100000 + 15 * 60)));
  EXPECT_TRUE(Auth::over(session, at(100000 + 15 * 60 + 1)));
  session.sockets = 1;
  EXPECT_FALSE(Auth::over(session, at(100000 + 8 * 3600 - 1))) << "an open page is a use";
  EXPECT_TRUE(Auth::over(session, at(100000 + 8 * 3600)));
  session.ended = true;
  EXPECT_TRUE(Auth::over(session, at(100001)));
}

// Decision 172. A sign-in lasts as long as time passes, however the wall clock is set meanwhile.
TEST(Sessions, are_counted_on_the_steady_clock) {
  using server::Auth, server::Clocks;
  constexpr std::uint64_t kDay_s = 86400, kToday_s = 20000 * kDay_s, kTomorrow_s = kToday_s + kDay_s, kHour_s = 3600;
  std::string error;
  const auto auth = Auth::create({.token_file = "", .hosts = {}}, {kToday_s, 1000}, error);
  ASSERT_NE(auth, nullptr) << error;
  const auto signed_in = [&](std::uint64_t begun_utc_s, std::uint64_t used_utc_s, Clocks now) {
    const auto session = std::make_shared<server::Session>();
    session->account = true;
    session->device = std::to_string(begun_utc_s + used_utc_s);
    session->begun_utc_s = begun_utc_s;
    session->used_utc_s = used_utc_s;
    auth->add_account(session, now);
    return session;
  };
  // The clock is a day ahead at the sign-in, and then put right.
  const auto early = signed_in(kTomorrow_s, kTomorrow_s, {kTomorrow_s, 1000});
  EXPECT_FALSE(Auth::over(*early, {kToday_s, 1000 + 15 * 60}));
  EXPECT_TRUE(Auth::over(*early, {kToday_s, 1000 + 15 * 60 + 1})) << "alone";
  auth->use(*early, {kToday_s, 1000 + 600});
  EXPECT_FALSE(Auth::over(*early, {kToday_s, 1000 + 600 + 15 * 60}));
  early->sockets = 1;
  EXPECT_TRUE(Auth::over(*early, {kToday_s, 1000 + 8 * 3600})) << "a working day";
  // The clock is set forward: what is signed in stays so.
  const auto before = signed_in(kToday_s, kToday_s, {kToday_s, 2000});
  EXPECT_FALSE(Auth::over(*before, {kTomorrow_s, 2060}));
  const std::string ticket = auth->issue_ticket(before, {kToday_s, 2060});
  EXPECT_TRUE(auth->use_ticket(ticket, *before, {kTomorrow_s, 2065}));
  server::Request request;
  request.from_here = true;
  request.headers["cookie"] = "hoist_session=" + auth->use_link(auth->link_token(), {kToday_s, 2000})->secret;
  EXPECT_TRUE(auth->find(request, {kTomorrow_s, 2060}));
  // Only rows of an earlier run are put in by the wall clock: here the computer has started 50 s ago.
  const Clocks start{kToday_s, 50};
  const auto known = signed_in(kToday_s - 7 * kHour_s, kToday_s - 600, start);
  EXPECT_FALSE(Auth::over(*known, {kTomorrow_s, 50 + 300}));
  EXPECT_TRUE(Auth::over(*known, {kTomorrow_s, 50 + 301}));
  known->sockets = 1;
  EXPECT_FALSE(Auth::over(*known, {kTomorrow_s, 50 + 3599}));
  EXPECT_TRUE(Auth::over(*known, {kTomorrow_s, 50 + 3600}));
  EXPECT_FALSE(Auth::over(*signed_in(kToday_s + 1800, kToday_s + 1800, start), start)) << "a little ahead";
  EXPECT_TRUE(Auth::over(*signed_in(kToday_s + kHour_s + 1, kToday_s, start), start));
  EXPECT_TRUE(Auth::over(*signed_in(kToday_s, kToday_s + kHour_s + 1, start), start));
}

// Rows wait until no request does; a question about the log waits with them.
TEST(PeopleDeskTest, who_did_something_finds_it_in_the_log) {
  const TemporaryFolder folder;
  std::vector<std::function<void()>> answers;
  server::PeopleDesk desk{folder / "accounts.db", {.passes = 1, .memory_bytes = 8192}, [&](std::function<void()> answer) {
                            answers.push_back(std::move(answer));
                          }};
  ASSERT_TRUE(desk.open()) << desk.problem();
  std::vector<std::size_t> rows;
  const auto count = [&](server::Turn turn) {
    return desk.at(turn).ask<std::size_t>([](server::PeopleRoom& room) { return room.accounts.audit(std::nullopt, 10)->size(); },
                                          [&](std::size_t seen) { rows.push_back(seen); });
  };
  db::AuditEntry entry;
  entry.user = "anna";
  desk.log(entry);
  ASSERT_TRUE(count(server::Turn::after_log));
  ASSERT_TRUE(count(server::Turn::first));
  desk.log(entry);
  desk.start();
  desk.stop();
  for (const auto& answer : answers) answer();
  EXPECT_EQ(rows, (std::vector<std::size_t>{0, 1})) << "the question that does not wait is answered first";
}

// More rows than may wait.
TEST(PeopleDeskTest, a_row_tells_how_many_rows_were_lost) {
  const TemporaryFolder folder;
  server::PeopleDesk desk{folder / "accounts.db", {.passes = 1, .memory_bytes = 8192}, [](const std::function<void()>&) {}};
  ASSERT_TRUE(desk.open()) << desk.problem();
  db::AuditEntry entry;
  entry.user = "anna";
  for (std::size_t i = 0; i < server::kAuditWaitLimit + 3; ++i) {
    entry.utc_ms = static_cast<std::int64_t>(i);
    desk.log(entry);
  }
  desk.start();
  desk.stop();
  const auto accounts = db::Accounts::attach(folder / "accounts.db");
  const auto rows = accounts->audit(std::nullopt, 2);
  ASSERT_EQ(rows->size(), 2U);
  const db::AuditEntry& lost = (*rows)[0].entry;
  EXPECT_EQ(lost.action, "lose_rows");
  EXPECT_EQ(lost.after, "3 rows");
  EXPECT_EQ(lost.utc_ms, server::kAuditWaitLimit);
  EXPECT_EQ((*rows)[1].entry.utc_ms, server::kAuditWaitLimit - 1);
}

// A disk that is mended later; one that never is must not delay the end of the server.
TEST(PeopleDeskTest, a_file_that_cannot_be_opened_is_tried_again) {
  const TemporaryFolder folder;
  const auto at_once = [](const std::function<void()>& work) { work(); };
  server::PeopleDesk none{folder / "none" / "accounts.db", {.passes = 1, .memory_bytes = 8192}, at_once};
  EXPECT_FALSE(none.open());
  none.start();
  server::PeopleDesk desk{folder / "later" / "accounts.db", {.passes = 1, .memory_bytes = 8192}, at_once};
  EXPECT_FALSE(desk.open());
  EXPECT_NE(desk.problem(), "");
  EXPECT_EQ(desk.not_stored(), desk.problem());
  std::promise<server::KnownPeople> known;
  desk.set_on_known([&](server::KnownPeople people) { known.set_value(std::move(people)); });
  desk.log({});
  std::filesystem::create_directory(folder / "later");
  desk.start();
  EXPECT_FALSE(known.get_future().get().has_engineer);
  EXPECT_EQ(desk.problem(), "");
  desk.stop();
  EXPECT_EQ(desk.not_stored(), "");
  EXPECT_EQ(db::Accounts::attach(folder / "later" / "accounts.db")->audit(std::nullopt, 10)->size(), 1U);
}

// H24: all that was committed, also what is still in the log whose end was torn by a power cut; and nothing is written.
TEST(AccountsTest, what_is_stored_is_read_from_a_disk_that_takes_no_data) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "full 100%?#");
  const auto file = folder / "accounts.db", copy = folder / "full 100%?#" / "accounts.db";
  const auto contents = [&] {
    std::map<std::string, std::string> bytes;
    for (const auto& entry : std::filesystem::directory_iterator(copy.parent_path())) {
      std::ifstream in(entry.path(), std::ios::binary);
      bytes[entry.path().filename()].assign(std::istreambuf_iterator<char>(in), {});
    }
    return bytes;
  };
  const auto is_known = [&](bool ended) {
    const auto before = contents();
    {
      auto read = db::Accounts::read(copy);
      ASSERT_TRUE(read.ok()) << read.error().message;
      EXPECT_TRUE(*read->has_engineer());
      ASSERT_EQ(read->sign_ins()->size(), 1U);
      EXPECT_EQ(read->sign_ins()->front().user, "erika");
      EXPECT_EQ(read->sign_ins()->front().ended, ended);
      EXPECT_FALSE(read->log({}).ok());
    }
    EXPECT_EQ(contents(), before);
  };
  {
    auto accounts = db::Accounts::open(file);
    db::User erika{
        .id = 0, .name = "erika", .display_name = "E", .role = "engineer", .enabled = true, .password_hash = "-", .pin_hash = {}};
    ASSERT_TRUE(accounts->add(erika, 1).ok());
    db::SignIn sign_in;
    sign_in.secret_sha256 = db::sha256_hex("secret");
    sign_in.user = "erika";
    ASSERT_TRUE(accounts->begin_sign_in(sign_in).ok());
    std::filesystem::copy_file(file, copy);
    std::filesystem::copy_file(file.string() + "-wal", copy.string() + "-wal");
    ASSERT_TRUE(accounts->end_sign_ins_of("erika", "").ok());
    // Of the next change half has come.
    const std::string whole = [&] {
      std::ifstream in(file.string() + "-wal", std::ios::binary);
      return std::string(std::istreambuf_iterator<char>(in), {});
    }();
    const auto known = std::filesystem::file_size(copy.string() + "-wal");
    ASSERT_GT(whole.size(), known);
    std::ofstream(copy.string() + "-wal", std::ios::binary | std::ios::app) << whole.substr(known, (whole.size() - known) / 2);
    is_known(false);
    std::filesystem::copy_file(file.string() + "-shm", copy.string() + "-shm");
    is_known(false);
    std::filesystem::remove(copy.string() + "-shm");
  }
  std::filesystem::remove(copy.string() + "-wal");
  std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing);
  is_known(true);
  std::ofstream(copy, std::ios::trunc) << "";
  EXPECT_EQ(db::Accounts::read(copy).error().kind, db::ErrorKind::wrong_state);
}

TEST(SetUpTest, the_code_lasts_ten_minutes_and_ends_with_the_switch) {
  std::string shown;
  server::SetUp set_up([] { return std::string("12345678"); }, [&](const std::string& code) { shown = code; });
  const auto same = [](const std::string& a, const std::string& b) { return a == b; };
  set_up.poll(0, std::nullopt);
  EXPECT_FALSE(set_up.open());
  set_up.poll(10, true);
  EXPECT_EQ(shown, "12345678");
  EXPECT_TRUE(set_up.try_code("12345678", same));
  EXPECT_FALSE(set_up.try_code("12345678", same)) << "once";
  set_up.poll(11, false);
  set_up.poll(12, true);
  set_up.poll(12 + server::kSetUp_ns, true);
  EXPECT_FALSE(set_up.try_code("12345678", same)) << "ten minutes";
  set_up.poll(20 + server::kSetUp_ns, false);
  set_up.poll(30 + server::kSetUp_ns, true);
  EXPECT_TRUE(set_up.open());
  set_up.poll(40 + server::kSetUp_ns, false);
  EXPECT_FALSE(set_up.try_code("12345678", same));
  set_up.poll(50 + server::kSetUp_ns, std::nullopt);
  EXPECT_FALSE(set_up.open()) << "no core, no set-up";
}

}  // namespace
}  // namespace hoist::test
