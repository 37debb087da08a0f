// Routes, sessions, refusals, parameters and motion over REST. Every answer is checked against OpenAPI by the fixture.
#include <atomic>
#include <ctime>
#include <thread>

#include "control/contract/calibration.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"
#include "server/contract/routes.hpp"
#include "server/http/auth.hpp"
#include "server/http/static_files.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::CommandKind;
using contract::Mode;
class Rest : public ServerTest {};

TEST_F(Rest, EveryGetRouteAnswersAsDescribed) {
  for (const server::Route& route : server::kRoutes) {
    if (route.method != server::Method::get || route.success == 101) continue;
    std::string path{route.path};
    if (const auto at = path.find("{name}"); at != std::string::npos) path.replace(at, 6, "speed_m_s_max");
    if (const auto at = path.find("{id}"); at != std::string::npos) path.replace(at, 4, "1");
    const Answer answer = get(path);
    EXPECT_TRUE(answer.status == 200 || answer.status == 404 || answer.status == 422) << path << " " << answer.body;
    const Answer head = call("HEAD", path);
    EXPECT_EQ(head.status, answer.status) << path;
    EXPECT_TRUE(head.body.empty());
  }
}

TEST_F(Rest, HealthNamesTheNodeThatLosesAndTheOneThatIsSilent) {
  core_->set([](contract::TickRecord& record) {
    record.tilt_left_nmt_state = record.tilt_right_nmt_state = record.tilt_base_nmt_state = 5;
    record.drive_left_nmt_state = record.drive_right_nmt_state = 5;
    record.io_nmt_state = 127;
    record.io_age_ticks = 255;
    record.tilt_right_lost_10s = 7;
    record.tilt_right_lost_frames = 70;
    record.drive_left_age_ticks = 90;
    record.drive_left_heartbeats_missed = 8;
    record.drive_left_emcy_code = 0x8250;
    record.drive_left_emcy_count = 2;
    record.bus_up = 1;
    record.bus_state = 2;
    record.bus_load_norm = 0.41F;
    record.babbling_id = 0xFFFF;
  });
  contract::Event event;
  event.kind = contract::EventKind::emergency;
  event.item = static_cast<std::uint32_t>(contract::Node::drive_left);
  event.code = 0x8250;
  event.bits = 0x11;
  core_->publish_event(event);
  json health;
  ASSERT_TRUE(until([&] {
    health = get("/api/v1/health").json();
    return !health["emergencies"].empty() && health["bus"]["state"] == "passive";
  }));
  const auto state = [&](const char* name) {
    for (const json& node : health["nodes"])
      if (node["name"] == name) return node["state"].get<std::string>();
    return std::string{};
  };
  EXPECT_EQ(health["nodes"].size(), contract::kRemoteNodeCount);
  EXPECT_EQ(state("tilt_left"), "working");
  EXPECT_EQ(state("tilt_right"), "losing");
  EXPECT_EQ(state("drive_left"), "silent");
  EXPECT_EQ(state("io"), "waiting");
  EXPECT_TRUE(health["bus"]["duplicate_id"].is_null());
  EXPECT_TRUE(health["bus"]["babbling_id"].is_null());
  EXPECT_NEAR(health["bus"]["load_norm"].get<double>(), 0.41, 1e-6);
  const json& told = health["emergencies"][0];
  EXPECT_EQ(told["node"], "drive_left");
  EXPECT_EQ(told["emergency"]["name"], "rpdo_timeout");
  EXPECT_EQ(told["error_register"], 0x11);
}

TEST_F(Rest, TheLoopTellsHowPunctualItIs_H22) {
  contract::LoopReport report;
  report.steps = 3;
  report.ever[0] = 1;
  report.ever[contract::lateness_bucket(300'000)] = 2;
  report.lately[contract::kLatenessBuckets - 1] = 1;
  report.latest_ever_ns = 310'000;
  core_->publish_loop(report);
  core_->set([](contract::TickRecord& record) {
    record.missed_ticks = 7;
    record.lateness_p99_s = 3e-4F;
    record.loop_priority = 49;
    record.loop_cpu = 255;
  });
  json loop;
  ASSERT_TRUE(until([&] {
    loop = get("/api/v1/loop").json();
    return loop.value("missed", 0) == 7;
  }));
  EXPECT_EQ(loop["steps"], 3);
  ASSERT_EQ(loop["ever"].size(), 2U) << "empty buckets are left out";
  EXPECT_EQ(loop["ever"][0]["from_s"], 0.0);
  EXPECT_EQ(loop["ever"][1]["count"], 2);
  EXPECT_LE(loop["ever"][1]["from_s"].get<double>(), 300e-6);
  EXPECT_GT(loop["ever"][1]["to_s"].get<double>(), 300e-6);
  EXPECT_TRUE(loop["lately"][0]["to_s"].is_null()) << "the last one has no end";
  EXPECT_EQ(loop["priority"], 49);
  EXPECT_TRUE(loop["cpu"].is_null());
}

TEST_F(Rest, NothingWithoutASession_H28) {
  for (const server::Route& route : server::kRoutes) {
    if (route.access == server::Access::open) continue;
    std::string path{route.path};
    for (const char* mark : {"{name}", "{id}", "{node}"})
      if (const auto at = path.find(mark); at != std::string::npos) path.replace(at, std::string(mark).size(), "1");
    const Answer answer = http(port_, std::string{server::method_name(route.method)}, path, {{"Content-Type", "application/json"}},
                               route.method == server::Method::get ? "" : "{}");
    EXPECT_EQ(answer.status, 401) << path;
    EXPECT_EQ(answer.header("content-type"), "application/problem+json");
  }
  EXPECT_TRUE(core_->commands().empty()) << "nothing may reach the core without a session";
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Authorization", "Bearer 00"}}).status, 401);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Cookie", "hoist_session=00"}}).status, 401);
}

TEST_F(Rest, TheLinkWorksOnce) {
  const std::string target = link_.substr(link_.find("/?"));
  const std::string cookie = log_in();
  ASSERT_TRUE(cookie.starts_with("hoist_session="));
  const Answer again = http(port_, "GET", target);
  EXPECT_EQ(again.status, 401);
  EXPECT_NE(again.body.find("terminal"), std::string::npos);
  EXPECT_EQ(again.header("set-cookie"), "");
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Cookie", cookie}}).status, 200);
}

TEST_F(Rest, ForeignPagesAreRefused_H29) {
  const std::string cookie = log_in();
  const auto post = [&](Headers headers, const std::string& body = "{}") {
    headers.emplace_back("Cookie", cookie);
    return http(port_, "POST", "/api/v1/neutral", headers, body).status;
  };
  const Headers own{{"Origin", origin()}, {"X-Hoist", "1"}, {"Content-Type", "application/json"}};
  EXPECT_EQ(post(own), 200);
  EXPECT_EQ(post({{"Origin", origin()}, {"Content-Type", "application/json"}}), 403) << "without X-Hoist";
  for (const char* foreign : {"http://evil.example", "null", "http://127.0.0.1:1", "http://localhost.evil"})
    EXPECT_EQ(post({{"Origin", foreign}, {"X-Hoist", "1"}, {"Content-Type", "application/json"}}), 403) << foreign;
  EXPECT_EQ(post({{"Origin", origin()}, {"X-Hoist", "1"}, {"Content-Type", "text/plain"}}), 415);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Host", "evil.example"}, {"Cookie", cookie}}).status, 421) << "DNS rebinding";
  EXPECT_EQ(http(port_, "GET", "/", {{"Host", "evil.example"}}).status, 421);
  std::size_t neutrals = 0;
  for (const auto& command : core_->commands()) neutrals += command.kind == CommandKind::set_neutral;
  EXPECT_EQ(neutrals, 1U) << "what was refused must not reach the core";
}

TEST_F(Rest, UnknownRouteAndMethod) {
  EXPECT_EQ(get("/api/v1/nothing").status, 404);
  EXPECT_EQ(get("/api/v1/sessions/").status, 404);
  const Answer wrong = call("DELETE", "/api/v1/parameters");
  EXPECT_EQ(wrong.status, 405);
  EXPECT_EQ(wrong.header("allow"), "GET, HEAD, PATCH");
  EXPECT_EQ(http(port_, "POST", "/", {}, "x").status, 405);
  EXPECT_EQ(http(port_, "BREW", "/api/v1/status", bearer_).status, 405);
}

TEST_F(Rest, StaticFiles) {
  const Answer page = http(port_, "GET", "/");
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.header("content-security-policy").find("default-src 'self'"), std::string::npos);
  EXPECT_NE(page.header("content-security-policy").find("frame-ancestors 'none'"), std::string::npos);
  EXPECT_EQ(page.header("x-content-type-options"), "nosniff");
  EXPECT_EQ(page.header("cache-control"), "no-cache");
  EXPECT_EQ(http(port_, "GET", "/", {{"If-None-Match", page.header("etag")}}).status, 304);
  const Answer plain = http(port_, "GET", "/assets/app-12ab.js");
  EXPECT_EQ(plain.body, "plain");
  EXPECT_NE(plain.header("cache-control").find("immutable"), std::string::npos);
  const Answer squeezed = http(port_, "GET", "/assets/app-12ab.js", {{"Accept-Encoding", "gzip, deflate"}});
  EXPECT_EQ(squeezed.body, "squeezed");
  EXPECT_EQ(squeezed.header("content-encoding"), "gzip");
  EXPECT_NE(squeezed.header("etag"), plain.header("etag"));
  for (const char* bad : {"/secret.html", "/../secret.html", "/%2e%2e/secret.html", "/assets/../../secret.html", "/link.html",
                          "/.hidden.html", "/assets", "/token", "//secret.html", "/assets/%2e%2e%2fsecret.html"})
    EXPECT_EQ(http(port_, "GET", bad).status, 404) << bad;
}

TEST_F(Rest, PagesAreReadOnceAtTheStart) {
  std::filesystem::remove_all(folder_ / "web");
  EXPECT_EQ(http(port_, "GET", "/").body, "<!doctype html><title>console</title>");
  stop_server();
  std::filesystem::create_directories(folder_ / "web");
  std::ofstream(folder_ / "web" / "index.html") << "<!doctype html><title>another build</title>";
  start_server();
  const Answer page = http(port_, "GET", "/");
  EXPECT_EQ(page.body, "<!doctype html><title>another build</title>");
  stop_server();
  std::ofstream(folder_ / "web" / "film.txt").flush();
  std::filesystem::resize_file(folder_ / "web" / "film.txt", server::kPagesLimit_bytes);
  start_server();
  EXPECT_EQ(http(port_, "GET", "/").status, 404) << "too much to be the console";
  std::filesystem::resize_file(folder_ / "web" / "film.txt", 1);
  stop_server();
  start_server();
  EXPECT_EQ(http(port_, "GET", "/", {{"If-None-Match", page.header("etag")}}).status, 304) << "the same bytes, the same tag";
}

// RFC 9110, 8.8.3: a strong entity tag is of one sequence of bytes.
TEST_F(Rest, GzipHasAnEntityTagOfItsOwn) {
  const auto list = [&](const Headers& more) {
    Headers headers = bearer_;
    headers.insert(headers.end(), more.begin(), more.end());
    return http(port_, "GET", "/api/v1/parameters", headers);
  };
  const std::pair<std::string, std::string> gzip{"Accept-Encoding", "gzip"};
  const Answer plain = list({}), squeezed = list({gzip});
  ASSERT_EQ(squeezed.header("content-encoding"), "gzip");
  const std::string plain_tag = plain.header("etag"), gzip_tag = squeezed.header("etag");
  EXPECT_NE(plain_tag, gzip_tag);
  EXPECT_EQ(list({{"If-None-Match", plain_tag}}).status, 304);
  EXPECT_EQ(list({{"If-None-Match", gzip_tag}}).status, 200);
  EXPECT_EQ(list({gzip, {"If-None-Match", plain_tag}}).status, 200);
  const Answer same = list({gzip, {"If-None-Match", "\"other\", W/" + gzip_tag}});
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.header("etag"), gzip_tag);
  EXPECT_EQ(same.header("vary"), "Accept-Encoding");
  const json change{{"value", 40.0}};
  EXPECT_EQ(call("PUT", "/api/v1/parameters/lean_gain_filtered_units", change, {{"If-Match", gzip_tag}}).status, 200);
  EXPECT_EQ(call("PUT", "/api/v1/parameters/lean_gain_filtered_units", change, {{"If-Match", gzip_tag}}).status, 412) << "outdated";
}

TEST_F(Rest, ParametersAreChangedThroughTheCore) {
  const Answer list = get("/api/v1/parameters");
  ASSERT_EQ(list.status, 200);
  EXPECT_EQ(list.json()["items"].size(), contract::kParamCount);
  EXPECT_EQ(call("GET", "/api/v1/parameters", nullptr, {{"If-None-Match", list.header("etag")}}).status, 304);
  const Answer changed = call("PUT", "/api/v1/parameters/lean_gain_filtered_units", {{"value", 40.0}});
  ASSERT_EQ(changed.status, 200) << changed.body;
  EXPECT_EQ(changed.json()["values"]["lean_gain_filtered_units"], 40.0);
  EXPECT_EQ(get("/api/v1/parameters/lean_gain_filtered_units").json()["value"], 40.0);
  EXPECT_EQ(call("PUT", "/api/v1/parameters/lean_gain_filtered_units", {{"value", 41.0}}, {{"If-Match", list.header("etag")}}).status, 412);
  EXPECT_EQ(call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.1}, {"turn_dead_band_norm", 0.2}}).status, 200);
  EXPECT_EQ(get("/api/v1/parameters/turn_dead_band_norm").json()["value"], 0.2);
}

TEST_F(Rest, AChangeIsMadeForTheParametersThatWereLookedAt_H27) {
  const json higher{{"value", 40.0}};
  const auto put = [&](const std::string& etag) {
    return call("PUT", "/api/v1/parameters/lean_gain_filtered_units", higher, {{"If-Match", etag}});
  };
  const std::string etag = get("/api/v1/parameters").header("etag");
  ASSERT_EQ(put(etag).status, 200);
  EXPECT_EQ(core_->commands().back().bits >> 32U, 1U) << "the version travels to the core";
  ASSERT_EQ(put("*").status, 200);
  EXPECT_EQ(core_->commands().back().bits >> 32U, 0U) << "whichever is in force";
  // Another client is faster than this server hears: the core refuses.
  const std::string newest = get("/api/v1/parameters").header("etag");
  core_->set([](contract::TickRecord& r) { r.parameter_version += 1; });
  const Answer late = put(newest);
  EXPECT_EQ(late.status, 412) << late.body;

  core_->set([](contract::TickRecord& r) { r.parameter_version -= 1; });
  ASSERT_EQ(call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.1}, {"revert_after_s", 20}}).status, 200);
  const auto version = get("/api/v1/parameters").json()["version"].get<std::uint32_t>();
  for (const json& wrong : {json(0), json(-1), json(1.5), json("2"), json(1ULL << 32U)})
    EXPECT_EQ(call("POST", "/api/v1/parameters/confirm", {{"version", wrong}}).status, 422) << wrong;
  const Answer old = call("POST", "/api/v1/parameters/confirm", {{"version", version - 1}});
  EXPECT_EQ(old.status, 409);
  EXPECT_EQ(old.json()["refusals"][0], "set_outdated");
  EXPECT_EQ(call("POST", "/api/v1/parameters/confirm", {{"version", version}}).status, 200);
}

TEST_F(Rest, ParametersOnTrialAreKeptOrTakenBack) {
  EXPECT_EQ(call("POST", "/api/v1/parameters/confirm").status, 409) << "nothing is on trial";
  ASSERT_EQ(call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.1}, {"revert_after_s", 20}}).status, 200);
  EXPECT_EQ(core_->commands().back().v0, 20.0);
  EXPECT_NE(core_->commands().back().bits, 0U) << "sealed on the way";
  EXPECT_EQ(call("POST", "/api/v1/parameters/confirm").status, 200);
  EXPECT_EQ(core_->commands().back().kind, contract::CommandKind::confirm_parameters);
  ASSERT_EQ(call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.2}, {"revert_after_s", 5}}).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/parameters/revert").status, 200);
  EXPECT_EQ(core_->commands().back().kind, contract::CommandKind::revert_parameters);
  const std::size_t asked = core_->commands().size();
  for (const json& wrong : {json(0), json(121), json("20"), json(true)}) {
    const Answer refused = call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.1}, {"revert_after_s", wrong}});
    EXPECT_EQ(refused.status, 422) << wrong;
  }
  const Answer stopped = call("PATCH", "/api/v1/parameters", {{"lean_range_rad", 0.15}, {"revert_after_s", 20}});
  EXPECT_EQ(stopped.status, 422);
  EXPECT_EQ(stopped.json()["errors"][0]["field"], "lean_range_rad");
  EXPECT_EQ(core_->commands().size(), asked) << "what cannot be is not even asked";
}

TEST_F(Rest, OneParameterOnTrial) {
  ASSERT_EQ(call("PUT", "/api/v1/parameters/lean_dead_band_norm", {{"value", 0.1}, {"revert_after_s", 20}}).status, 200);
  EXPECT_EQ(core_->commands().back().v0, 20.0);
  const Answer wrong = call("PUT", "/api/v1/parameters/lean_dead_band_norm", {{"value", 0.1}, {"revert_after_s", "x"}});
  EXPECT_EQ(wrong.status, 422);
  EXPECT_EQ(wrong.json()["errors"][0]["field"], "revert_after_s");
}

TEST_F(Rest, RefusedParametersNameFieldAndRangeAndChangeNothing) {
  const Answer high = call("PUT", "/api/v1/parameters/lean_gain_filtered_units", {{"value", 1000.0}});
  EXPECT_EQ(high.status, 422);
  EXPECT_EQ(high.json()["errors"][0]["field"], "lean_gain_filtered_units");
  EXPECT_EQ(high.json()["errors"][0]["min"], 0.0);
  EXPECT_EQ(high.json()["errors"][0]["max"], 100.0);
  const Answer text = call("PUT", "/api/v1/parameters/lean_gain_filtered_units", {{"value", "NaN"}});
  EXPECT_EQ(text.status, 422);
  EXPECT_EQ(text.json()["detail"], "value must be a number; nothing was done.");
  const Answer empty = call("PUT", "/api/v1/parameters/lean_gain_filtered_units", json::object());
  EXPECT_EQ(empty.json()["detail"], "value is missing; it must be a number; nothing was done.");
  EXPECT_EQ(empty.json()["errors"][0]["field"], "value");
  EXPECT_EQ(get("/api/v1/sessions?limit=201").json()["errors"][0]["message"], "must be a whole number from 1 to 200");
  EXPECT_EQ(call("PUT", "/api/v1/parameters/lean_gain_filtered_units", {{"value", nullptr}}).status, 422);
  EXPECT_EQ(call("PUT", "/api/v1/parameters/lean_gain_filtered_units", json::object()).status, 422);
  EXPECT_EQ(call("PUT", "/api/v1/parameters/nothing", {{"value", 1}}).status, 404);
  // One bad row spoils the set.
  EXPECT_EQ(call("PATCH", "/api/v1/parameters", {{"lean_dead_band_norm", 0.1}, {"turn_dead_band_norm", 9}}).status, 422);
  EXPECT_EQ(call("PATCH", "/api/v1/parameters", json::object()).status, 422);
  EXPECT_EQ(get("/api/v1/parameters/lean_dead_band_norm").json()["value"], 0.05);
  EXPECT_TRUE(core_->commands().empty()) << "what is out of range is not even asked";
  // Only when stopped: the core's own rule.
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  const Answer moving = call("PUT", "/api/v1/parameters/lean_range_rad", {{"value", 0.1}});
  EXPECT_EQ(moving.status, 409) << moving.body;
  EXPECT_EQ(moving.json()["refusals"][0], "only_when_stopped");
  EXPECT_EQ(moving.json()["errors"][0]["field"], "lean_range_rad");
}

// A change is acknowledged when it is on the disk, not when it is in force.
TEST_F(Rest, AChangeOfSettingsIsAnsweredWhenItIsStored) {
  core_->hold_store(true);
  std::atomic<bool> released{false};
  std::atomic<bool> early{false};
  Answer answer;
  std::thread asking([&] {
    Headers headers = bearer_;
    headers.emplace_back("Content-Type", "application/json");
    headers.emplace_back("If-Match", "*");
    answer = http(port_, "PUT", "/api/v1/parameters/speed_cap_norm", headers, R"({"value": 0.5})");
    early = !released;
  });
  EXPECT_TRUE(until([&] { return get("/api/v1/parameters/speed_cap_norm").json()["value"] == 0.5; })) << "in force at once";
  released = true;
  core_->hold_store(false);
  asking.join();
  EXPECT_FALSE(early);
  EXPECT_EQ(answer.status, 200);
  check_described("PUT", "/api/v1/parameters/speed_cap_norm", answer);
  EXPECT_EQ(answer.json()["stored"], true);
  EXPECT_TRUE(get("/api/v1/status").json()["notices"].empty());
}

TEST_F(Rest, WhatTheDiskRefusesIsInForceAndSaidToBeNotStored) {
  const auto stored = [this](const std::string& method, const std::string& target, const json& body) {
    const Answer answer = call(method, target, body);
    EXPECT_EQ(answer.status, 200) << target << ": " << answer.body;
    return answer.json()["stored"];
  };
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  core_->hold_store(true, contract::StoreProblem::disk_full);
  EXPECT_EQ(stored("PUT", "/api/v1/parameters/speed_cap_norm", {{"value", 0.5}}), false);
  EXPECT_EQ(get("/api/v1/parameters/speed_cap_norm").json()["value"], 0.5);
  const json notices = get("/api/v1/status").json()["notices"];
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0]["name"], "settings_not_stored");
  EXPECT_EQ(notices[0]["detail"], "The disk of the settings is full.");
  // Whatever else the next start begins with.
  EXPECT_EQ(stored("PATCH", "/api/v1/parameters", {{"speed_cap_norm", 0.6}}), false);
  EXPECT_EQ(stored("PATCH", "/api/v1/parameters", {{"speed_cap_norm", 0.7}, {"revert_after_s", 60}}), false);
  EXPECT_EQ(stored("POST", "/api/v1/parameters/confirm", json::object()), false);
  EXPECT_EQ(stored("POST", "/api/v1/presets/paper/apply", json::object()), false);
  EXPECT_EQ(stored("POST", "/api/v1/neutral", json::object()), false);
  ASSERT_EQ(call("POST", "/api/v1/calibration", {{"step", "wheel_radius"}}).status, 200);
  EXPECT_EQ(stored("POST", "/api/v1/calibration/use", json::object()), false);
  core_->hold_store(false);
  EXPECT_TRUE(until([&] { return get("/api/v1/status").json()["notices"].empty(); })) << "the notice ends with its cause";
  EXPECT_EQ(stored("PUT", "/api/v1/parameters/speed_cap_norm", {{"value", 0.8}}), true);
}

TEST_F(Rest, ADiskThatDoesNotAnswerIsToldAfterASecond) {
  core_->hold_store(true);
  const Answer answer = call("PUT", "/api/v1/parameters/speed_cap_norm", {{"value", 0.5}});
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.json()["stored"], false);
  EXPECT_EQ(get("/api/v1/status").json()["notices"][0]["name"], "settings_not_stored");
}

// H22: a hoist that is switched off before its third stop is stored walks again.
TEST_F(Rest, H22StopsThatTheDiskRefusesAreSaid) {
  const auto notices = [this] { return get("/api/v1/status").json()["notices"]; };
  core_->refuse_stops(contract::StoreProblem::disk_full);
  ASSERT_EQ(notices().size(), 1U);
  EXPECT_EQ(notices()[0]["name"], "stops_not_stored");
  EXPECT_EQ(notices()[0]["detail"], "The disk of the settings is full.");
  core_->refuse_stops(contract::StoreProblem::none);
  EXPECT_TRUE(notices().empty());
}

TEST_F(Rest, Presets) {
  EXPECT_EQ(get("/api/v1/presets").json()["items"].size(), contract::kPresets.size());
  EXPECT_EQ(call("POST", "/api/v1/presets/paper/apply", json::object()).status, 200);
  EXPECT_EQ(get("/api/v1/parameters/speed_per_unit_m_s").json()["value"], 0.0086);
  EXPECT_EQ(call("POST", "/api/v1/presets/none/apply", json::object()).status, 404);
}

TEST_F(Rest, BodiesThatCannotBeUsed_H30) {
  const auto put = [&](const std::string& body, const char* type = "application/json") {
    Headers headers = bearer_;
    headers.emplace_back("Content-Type", type);
    headers.emplace_back("If-Match", "*");
    const Answer answer = http(port_, "PUT", "/api/v1/parameters/lean_gain_filtered_units", headers, body);
    check_described("PUT", "/api/v1/parameters/lean_gain_filtered_units", answer);
    return answer;
  };
  EXPECT_EQ(put("{\"value\": ").status, 400);
  EXPECT_NE(put("{\"value\": x}").body.find("At byte"), std::string::npos);
  EXPECT_EQ(put("{\"value\": NaN}").status, 400);
  EXPECT_EQ(put("[1]").status, 400);
  EXPECT_EQ(put("{\"value\": 1}", "text/plain").status, 415);
  EXPECT_EQ(put(std::string(60000, '[')).status, 400);
  EXPECT_EQ(put("{\"value\": 1e999}").status, 400);
  EXPECT_TRUE(core_->commands().empty());
  EXPECT_EQ(get("/api/v1/status").status, 200) << "and it goes on serving";
}

TEST_F(Rest, StartNeedsTheLease) {
  const json start{{"mode", "user"}, {"exercise", {{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}}}};
  EXPECT_EQ(call("POST", "/api/v1/mode", start).status, 409) << "no lease header";
  const Answer lease = call("POST", "/api/v1/lease", json::object());
  ASSERT_EQ(lease.status, 200) << lease.body;
  const std::string epoch = std::to_string(lease.json()["epoch"].get<int>());
  EXPECT_EQ(call("POST", "/api/v1/mode", start, {{"X-Hoist-Lease", "0"}}).status, 409) << "an old epoch";
  EXPECT_EQ(core_->mode(), Mode::standby);
  EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "fly"}}, {{"X-Hoist-Lease", epoch}}).status, 422);
  EXPECT_EQ(
      call("POST", "/api/v1/mode", {{"mode", "user"}, {"exercise", {{"shape", "square"}, {"side_m", -1}}}}, {{"X-Hoist-Lease", epoch}})
          .status,
      422);
  ASSERT_EQ(call("POST", "/api/v1/mode", start, {{"X-Hoist-Lease", epoch}}).status, 200);
  EXPECT_EQ(core_->mode(), Mode::user);
  // The pose was set to the start of the figure before the mode was asked for.
  const auto commands = core_->commands();
  std::size_t pose = commands.size(), mode = commands.size();
  for (std::size_t i = 0; i < commands.size(); ++i) {
    if (commands[i].kind == CommandKind::set_pose) pose = i;
    if (commands[i].kind == CommandKind::request_mode && commands[i].a == static_cast<std::uint32_t>(Mode::user)) mode = i;
  }
  ASSERT_LT(pose, mode);
  EXPECT_NEAR(commands[pose].v2, 0.9272952180016122, 1e-12);
  EXPECT_EQ(get("/api/v1/mode").json()["mode"], "user");
  // Ending motion is never refused for the form of what does not matter to it.
  const json end{{"mode", "standby"}, {"path", {{"shape", "spiral"}}}, {"exercise", {{"shape", "square"}, {"side_m", -1}}}};
  ASSERT_EQ(call("POST", "/api/v1/mode", end, {{"X-Hoist-Lease", epoch}}).status, 200);
  EXPECT_EQ(core_->mode(), Mode::standby);
}

// Its sender may have gone while the request was on its way: the age counts from the first byte, on the clock of the core.
TEST_F(Rest, ARequestThatTookLongerThanASecondBeginsNoMotionAndLeavesNoStop_H17) {
  const std::string epoch = std::to_string(call("POST", "/api/v1/lease", json::object()).json()["epoch"].get<int>());
  // `late`: the body comes 1.5 s after the header. `gone`: with the end of the connection.
  const auto post = [&](const std::string& target, json body, bool late, bool gone = false) {
    const std::string text = body.dump();
    Raw raw(port_);
    raw.send("POST " + target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\nAuthorization: " + bearer_[0].second +
             "\r\nX-Hoist-Lease: " + epoch + "\r\nContent-Type: application/json\r\nExpect: 100-continue\r\nConnection: close" +
             "\r\nContent-Length: " + std::to_string(text.size()) + "\r\n\r\n");
    EXPECT_EQ(raw.read(25), "HTTP/1.1 100 Continue\r\n\r\n");
    if (late) core_->skip(150);
    if (gone) raw.hold();
    raw.send(text);
    if (gone) raw.end();
    const std::string answer = raw.read_to_end();
    return std::pair(answer.substr(9, 3), answer);
  };
  const json start{{"mode", "user"}, {"exercise", {{"shape", "free"}}}}, end{{"mode", "standby"}}, acknowledge = json::object();
  for (const bool gone : {false, true}) {
    const auto [status, answer] = post("/api/v1/mode", start, !gone, gone);
    EXPECT_EQ(status, "409") << answer;
    EXPECT_NE(answer.find("\"stale_command\""), std::string::npos) << answer;
    EXPECT_EQ(core_->mode(), Mode::standby);
  }
  json seen = start;
  seen["echo"] = core_->published().back().time_ns - 1'500'000'000;
  EXPECT_EQ(post("/api/v1/mode", seen, false).first, "409") << "its sender had seen no newer step";
  seen["echo"] = core_->published().back().time_ns;
  EXPECT_EQ(post("/api/v1/mode", seen, false).first, "200");
  EXPECT_EQ(post("/api/v1/mode", end, true, true).first, "200") << "ending motion has no age";
  EXPECT_EQ(post("/api/v1/stop", json::object(), true, true).first, "200");
  ASSERT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(post("/api/v1/acknowledge", acknowledge, true).first, "409");
  EXPECT_EQ(post("/api/v1/acknowledge", acknowledge, false, true).first, "409");
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(post("/api/v1/acknowledge", acknowledge, false).first, "200");
}

TEST_F(Rest, AnAnswerFindsItsStepAlsoWhenTheServerIsBehind) {
  for (int i = 0; i < 30; ++i) {
    core_->skip(1500);  // what the server has not read yet, after a stall of 15 s
    const Answer lease = call("POST", "/api/v1/lease", {{"take_over", true}});
    ASSERT_EQ(lease.status, 200) << lease.body;
    std::uint32_t epoch = 0;
    core_->set([&](const contract::TickRecord& r) { epoch = r.lease_epoch; });
    ASSERT_EQ(lease.json()["epoch"], epoch) << i;
  }
}

TEST_F(Rest, TheSameExerciseGoesOnUnlessItIsToStartAgain) {
  const std::string epoch = std::to_string(call("POST", "/api/v1/lease", json::object()).json()["epoch"].get<int>());
  const json eight{{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}};
  const auto marks = [&](const json& start) {
    EXPECT_EQ(call("POST", "/api/v1/mode", start, {{"X-Hoist-Lease", epoch}}).status, 200) << start;
    EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "standby"}}, {{"X-Hoist-Lease", epoch}}).status, 200);
    EXPECT_TRUE(until([&] { return get("/api/v1/mode").json()["mode"] == "standby"; }));
    std::uint32_t number = 0;
    core_->set([&](const contract::TickRecord& r) { number = r.start_mark; });
    return number;
  };
  EXPECT_EQ(marks({{"mode", "user"}, {"exercise", eight}}), 1U);
  EXPECT_EQ(marks({{"mode", "user"}, {"exercise", eight}}), 1U);
  EXPECT_EQ(marks({{"mode", "remote"}}), 1U) << "only moved";
  EXPECT_EQ(marks({{"mode", "user"}, {"exercise", eight}, {"start_again", true}}), 2U);
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "start"}, {"subject", "P-018"}}).status, 200);
  EXPECT_EQ(marks({{"mode", "user"}, {"exercise", eight}}), 3U) << "another patient";
  EXPECT_EQ(marks({{"mode", "user"}, {"exercise", eight}}), 3U);
  EXPECT_EQ(marks({{"mode", "remote"}, {"exercise", eight}}), 4U) << "another lead";
  const json wrong{{"mode", "user"}, {"exercise", eight}, {"start_again", "yes"}};
  const Answer refused = call("POST", "/api/v1/mode", wrong, {{"X-Hoist-Lease", epoch}});
  EXPECT_EQ(refused.status, 422);
  EXPECT_EQ(refused.json()["errors"][0]["field"], "start_again");
}

TEST_F(Rest, AnExerciseIsCheckedFieldByFieldAndReachesTheCoreWhole) {
  const std::string epoch = std::to_string(call("POST", "/api/v1/lease", json::object()).json()["epoch"].get<int>());
  const auto ask = [&](const json& path) {
    return call("POST", "/api/v1/mode", {{"mode", "guided"}, {"path", path}}, {{"X-Hoist-Lease", epoch}});
  };
  const json eight{{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}, {"clockwise", true}, {"speed_m_s", 0.3}, {"laps", 3}};
  // Each field wrong by itself is named with what it may be.
  const auto refused_field = [&](const char* name, const json& value) {
    json path = eight;
    path[name] = value;
    const auto answer = ask(path);
    EXPECT_EQ(answer.status, 422) << name << value;
    return answer.json()["errors"][0];
  };
  EXPECT_EQ(refused_field("speed_m_s", 5.0)["field"], "path.speed_m_s");
  EXPECT_NEAR(refused_field("speed_m_s", 5.0)["max"].get<double>(), 0.65, 1e-9);
  EXPECT_EQ(refused_field("speed_m_s", "fast")["field"], "path.speed_m_s");
  EXPECT_EQ(refused_field("laps", 0)["field"], "path.laps");
  EXPECT_EQ(refused_field("laps", 1.5)["field"], "path.laps");
  EXPECT_EQ(refused_field("laps", 40)["max"], 200.0) << "too long altogether";
  EXPECT_EQ(refused_field("radius_m", 1.2)["field"], "path.radius_m");
  EXPECT_EQ(refused_field("clockwise", "yes")["field"], "path.clockwise");
  EXPECT_EQ(refused_field("shape", "spiral")["field"], "path.shape");
  EXPECT_EQ(refused_field("shape", "free")["field"], "path.shape");
  EXPECT_EQ(ask(nullptr).status, 422);
  EXPECT_EQ(ask("eight").status, 422);
  const json both{{"mode", "guided"}, {"path", eight}, {"exercise", {{"shape", "free"}}}};
  EXPECT_EQ(call("POST", "/api/v1/mode", both, {{"X-Hoist-Lease", epoch}}).status, 422);
  const json misplaced{{"mode", "remote"}, {"path", eight}};
  EXPECT_EQ(call("POST", "/api/v1/mode", misplaced, {{"X-Hoist-Lease", epoch}}).status, 422);
  for (const contract::Command& c : core_->commands())
    EXPECT_NE(c.kind, contract::CommandKind::begin_guided) << "nothing of that reached the core";
  ASSERT_EQ(ask(eight).status, 200);
  bool pose = false;
  for (const contract::Command& c : core_->commands()) {
    pose = pose || c.kind == contract::CommandKind::set_pose;
    if (c.kind != contract::CommandKind::begin_guided) continue;
    EXPECT_TRUE(pose) << "figure and odometry share their origin";
    const contract::GuidedPath path = contract::guided_of(c);
    EXPECT_EQ(path.shape, contract::GuidedShape::eight);
    EXPECT_TRUE(path.clockwise);
    EXPECT_EQ(path.size_m, 1.0);
    EXPECT_EQ(path.radius_m, 0.8);
    EXPECT_EQ(path.speed_m_s, 0.3);
    EXPECT_EQ(path.laps, 3U);
  }
  EXPECT_TRUE(until([&] { return get("/api/v1/mode").json()["mode"] == "guided"; }));
}

TEST_F(Rest, StopIsForEveryone) {
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  const std::string cookie = log_in();
  // As the console's fallback sends it: a cookie, the header, no body at all.
  EXPECT_EQ(http(port_, "POST", "/api/v1/stop", {{"Cookie", cookie}, {"X-Hoist", "1"}, {"Origin", origin()}}).status, 200);
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(call("POST", "/api/v1/acknowledge", json::object()).status, 409) << "only the driver releases";
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/acknowledge", json::object()).status, 200);
}

TEST_F(Rest, TheSoundOfAlarmsIsPausedAndBack) {
  const auto pause = [this](const json& body) { return call("PUT", "/api/v1/alarm-pause", body).status; };
  EXPECT_EQ(pause({{"paused", true}}), 409) << "nothing sounds";
  core_->set([](contract::TickRecord& r) { r.fault_bits = contract::fault_bit(contract::Fault::battery_low); });
  for (const json& wrong : {json::object(), json{{"paused", 1}}, json{{"paused", true}, {"for_s", 600}}})
    EXPECT_EQ(pause(wrong), 422) << wrong;
  EXPECT_EQ(pause({{"paused", true}}), 200);
  EXPECT_EQ(core_->commands().back().kind, contract::CommandKind::pause_alarm);
  EXPECT_EQ(core_->commands().back().a, 1U);
  EXPECT_EQ(pause({{"paused", false}}), 200);
  EXPECT_EQ(core_->commands().back().a, 0U);
}

TEST_F(Rest, AnAcknowledgementNamesWhatWasSeen) {
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  const auto acknowledged = [this] {
    std::vector<contract::FaultBits> seen;
    for (const auto& command : core_->commands())
      if (command.kind == contract::CommandKind::acknowledge) seen.push_back(command.bits);
    return seen;
  };
  for (const json& wrong :
       {json("bumper_pressed"), json::array(), json{"bumper_pressed", "no_such_fault"}, json{"bumper_pressed", 3}, json(7)}) {
    const auto reply = call("POST", "/api/v1/acknowledge", {{"seen", wrong}});
    EXPECT_EQ(reply.status, 422U) << wrong;
    EXPECT_TRUE(reply.json()["errors"][0]["field"].get<std::string>().starts_with("seen")) << wrong;
  }
  EXPECT_TRUE(acknowledged().empty());
  EXPECT_EQ(call("POST", "/api/v1/acknowledge", {{"seen", {"bumper_pressed", "stop_pressed"}}}).status, 200U);
  EXPECT_EQ(call("POST", "/api/v1/acknowledge", json::object()).status, 200U);
  const contract::FaultBits both =
      contract::fault_bit(contract::Fault::bumper_pressed) | contract::fault_bit(contract::Fault::stop_pressed);
  EXPECT_EQ(acknowledged(), (std::vector<contract::FaultBits>{both, 0}));
}

TEST_F(Rest, StopLooksAtNoBody_H30) {
  for (const char* body : {"", "{}", "null", "[]", "zzz", "{\"a\":1,\"a\":2}"})
    for (const char* type : {"", "application/json", "application/x-www-form-urlencoded"}) {
      core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
      Headers headers = bearer_;
      if (*type != '\0') headers.emplace_back("Content-Type", type);
      headers.emplace_back("Content-Encoding", "gzip");
      const Answer answer = http(port_, "POST", "/api/v1/stop", headers, body);
      check_described("POST", "/api/v1/stop", answer);
      EXPECT_EQ(answer.status, 200) << body << " as " << type;
      EXPECT_EQ(core_->mode(), Mode::protective_stop);
    }
}

TEST_F(Rest, WhoWasEverSignedInMayStop) {
  const std::string cookie = log_in();
  stop_server();
  // The session was last used yesterday.
  const auto file = folder_ / "token.sessions";
  std::ofstream(file) << cookie.substr(cookie.find('=') + 1) << " " << std::time(nullptr) - 24 * 3600 << "\n";
  start_server();
  wait_for_core();
  const Headers own{{"Cookie", cookie}, {"X-Hoist", "1"}, {"Origin", origin()}};
  const Answer out = http(port_, "GET", "/api/v1/status", own);
  EXPECT_EQ(out.status, 401);
  EXPECT_EQ(out.header("www-authenticate"), "Bearer realm=\"Hoist\"");
  EXPECT_EQ(http(port_, "POST", "/api/v1/neutral", own).status, 401) << "nothing but STOP";
  EXPECT_EQ(http(port_, "POST", "/api/v1/stop", {{"Cookie", cookie}, {"Origin", origin()}}).status, 403) << "the other checks stay";
  EXPECT_EQ(http(port_, "POST", "/api/v1/stop", own).status, 200);
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
}

TEST_F(Rest, TheCauseOfAStopIsToldDuringTheStopOnly) {
  const auto cause = [&](Mode mode) {
    core_->set([mode](contract::TickRecord& r) {
      r.mode = static_cast<std::uint8_t>(mode);
      r.stop_cause = 1;
    });
    json told;
    EXPECT_TRUE(until([&] {
      told = get("/api/v1/mode").json();
      return told["mode"] == contract::kModes[static_cast<std::size_t>(mode)].name;
    }));
    return told["stop_cause"];
  };
  EXPECT_EQ(cause(Mode::protective_stop).size(), 1U);
  EXPECT_TRUE(cause(Mode::standby).is_null());
  EXPECT_EQ(cause(Mode::fault).size(), 1U);
}

TEST_F(Rest, AlarmsAreToldInTheOrderInWhichTheyMatter) {
  using contract::Fault;
  const auto alarms = [&](std::initializer_list<Fault> faults, Fault first) {
    contract::FaultBits bits = 0;
    for (const Fault fault : faults) bits |= contract::fault_bit(fault);
    core_->set([bits, first](contract::TickRecord& r) {
      r.fault_bits = bits;
      r.stop_cause = static_cast<std::uint8_t>(static_cast<unsigned>(first) + 1U);
      r.drive_left_fault_code = 0x7121;
    });
    json told;
    EXPECT_TRUE(until([&] {
      told = get("/api/v1/status").json()["core"]["alarms"];
      return told.size() == faults.size();
    }));
    return told;
  };
  const json cut = alarms({Fault::tilt_left_lost, Fault::io_lost, Fault::bus_down}, Fault::tilt_left_lost);
  EXPECT_EQ(cut[0]["name"], "bus_down");
  EXPECT_TRUE(cut[0]["consequence_of"].is_null());
  EXPECT_EQ(cut[1]["consequence_of"], "bus_down");
  EXPECT_EQ(cut[2]["consequence_of"], "bus_down");
  const json fall = alarms({Fault::tilt_left_lost, Fault::fall_detected}, Fault::tilt_left_lost);
  EXPECT_EQ(fall[0]["name"], "fall_detected");
  const json blocked = alarms({Fault::drive_left_fault}, Fault::drive_left_fault);
  EXPECT_EQ(blocked[0]["code"], 0x7121);
  EXPECT_EQ(blocked[0]["text"]["en"], "The left wheel was blocked");
}

TEST_F(Rest, FieldsThatNobodyKnowsAreNamed) {
  const auto refused = [&](const char* method, const char* path, const json& body, const char* field, const Headers& more = {}) {
    const Answer answer = call(method, path, body, more);
    EXPECT_EQ(answer.status, 422) << path << " " << answer.body;
    EXPECT_EQ(answer.json()["errors"][0]["field"], field) << answer.body;
    EXPECT_NE(answer.json()["detail"].get<std::string>().find(field), std::string::npos);
  };
  refused("PUT", "/api/v1/parameters/lean_dead_band_norm", {{"value", 0.1}, {"revert_after", 20}}, "revert_after");
  refused("POST", "/api/v1/lease", {{"takeover", true}}, "takeover");
  refused("POST", "/api/v1/neutral", {{"now", true}}, "now");
  refused("POST", "/api/v1/pose", {{"x_m", 0}, {"y_m", 0}, {"psi_rad", 0}, {"z_m", 0}}, "z_m");
  refused("POST", "/api/v1/recording", {{"action", "start"}, {"subjekt", "x"}}, "subjekt");
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  const Headers lease{{"X-Hoist-Lease", std::to_string(get("/api/v1/status").json()["lease"]["epoch"].get<int>())}};
  const std::size_t asked = core_->commands().size();
  refused("POST", "/api/v1/mode", {{"mode", "user"}, {"exercise", {{"shape", "circle"}, {"radius_m", 1}, {"radius", 2}}}},
          "exercise.radius", lease);
  // A size of another shape is one that this shape does not know.
  refused("POST", "/api/v1/mode", {{"mode", "user"}, {"exercise", {{"shape", "circle"}, {"radius_m", 1}, {"c_m", 2}}}}, "exercise.c_m",
          lease);
  EXPECT_EQ(core_->commands().size(), asked);
  EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "standby"}, {"please", true}}, lease).status, 200) << "ending motion is never refused";
  Headers headers = bearer_;
  headers.emplace_back("Content-Type", "application/json");
  headers.emplace_back("If-Match", "*");
  const Answer twice = http(port_, "PUT", "/api/v1/parameters/lean_dead_band_norm", headers, "{\"value\": 0.1, \"value\": 0.2}");
  EXPECT_EQ(twice.status, 422);
  EXPECT_EQ(twice.json()["errors"][0]["message"], "is given twice");
  headers.emplace_back("Content-Encoding", "gzip");
  EXPECT_EQ(http(port_, "PUT", "/api/v1/parameters/lean_dead_band_norm", headers, "{\"value\": 0.1}").status, 415);
}

TEST_F(Rest, ALeaseEndsWithItsHoldersUseOfIt) {
  const Answer lease = call("POST", "/api/v1/lease", json::object());
  ASSERT_EQ(lease.status, 200);
  const Headers mine{{"X-Hoist-Lease", std::to_string(lease.json()["epoch"].get<int>())}};
  const auto holder = [&](const Headers& more) { return call("GET", "/api/v1/status", nullptr, more).json()["lease"]["holder"]; };
  // Longer than it lasts by itself.
  const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(server::kRestLease_ns) + std::chrono::seconds(1);
  while (std::chrono::steady_clock::now() < end) ASSERT_NE(holder(mine), 0);
  EXPECT_TRUE(until([&] { return holder({}) == 0; })) << "reading with the same token does not keep it";
}

TEST_F(Rest, ACoreThatDoesNotAnswerIsSaidSo) {
  core_->mute(true);
  const Answer answer = call("POST", "/api/v1/neutral", json::object());
  EXPECT_EQ(answer.status, 503);
  EXPECT_NE(answer.json()["detail"].get<std::string>().find("does not answer"), std::string::npos);
  core_.reset();
  wait_for_core(false);
  EXPECT_EQ(call("POST", "/api/v1/stop", json::object()).status, 503);
  EXPECT_EQ(get("/api/v1/mode").status, 503);
  // A server that never heard a core knows no limits: it says so instead of judging the exercise by others.
  stop_server();
  start_server();
  const json fast{{"mode", "guided"}, {"path", {{"shape", "circle"}, {"radius_m", 1.0}, {"speed_m_s", 5.0}}}};
  EXPECT_EQ(call("POST", "/api/v1/mode", fast, {{"X-Hoist-Lease", "1"}}).status, 503);
}

TEST_F(Rest, ACalibrationStepIsLedFromBeginToUse) {
  const json table = get("/api/v1/calibration").json();
  EXPECT_EQ(table["items"].size(), contract::kCalibrationSteps.size());
  EXPECT_EQ(table["reasons"].size(), contract::kCalibrationReasons.size());
  EXPECT_TRUE(table["under_way"].is_null());
  EXPECT_TRUE(table["items"][0]["done_utc_s"].is_null()) << "never";
  EXPECT_EQ(call("POST", "/api/v1/calibration", {{"step", "wheel_radius"}}).status, 409) << "without the lease";
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/calibration", {{"step", "weather"}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/calibration/use", json::object()).status, 409) << "nothing has begun";
  ASSERT_EQ(call("POST", "/api/v1/calibration", {{"step", "wheel_radius"}}).status, 200);
  EXPECT_EQ(core_->commands().back().a, static_cast<std::uint32_t>(contract::CalibrationStep::wheel_radius));
  EXPECT_EQ(core_->commands().back().b, static_cast<std::uint32_t>(contract::Role::engineer));
  ASSERT_TRUE(until([&] { return get("/api/v1/calibration").json()["under_way"]["step"] == "wheel_radius"; }));
  EXPECT_EQ(get("/api/v1/calibration").json()["under_way"]["phase"], "operator");
  EXPECT_EQ(call("POST", "/api/v1/calibration/measure", {{"figure", "far"}}).status, 422);
  const Answer far = call("POST", "/api/v1/calibration/measure", {{"figure", 21.0}});
  EXPECT_EQ(far.status, 422);
  EXPECT_EQ(far.json()["errors"][0]["field"], "figure");
  EXPECT_EQ(far.json()["errors"][0]["max"], 20.0);
  EXPECT_EQ(call("POST", "/api/v1/calibration/measure", {{"figure", 3.0}, {"turning", "up"}}).status, 422);
  ASSERT_EQ(call("POST", "/api/v1/calibration/measure", {{"figure", -2.0}}).status, 200);
  EXPECT_DOUBLE_EQ(core_->commands().back().v0, -2.0);
  ASSERT_EQ(call("POST", "/api/v1/calibration/measure", {{"figure", 3.0}, {"x_m", 0.1}, {"y_m", -0.2}, {"turning", "right"}}).status, 200);
  EXPECT_EQ(core_->commands().back().a, static_cast<std::uint32_t>(contract::CalibrationPart::right_square));
  EXPECT_DOUBLE_EQ(core_->commands().back().v2, -0.2);
  contract::Event event;
  event.kind = contract::EventKind::calibration_result;
  event.item = contract::kParams[contract::param_index(contract::ParamName::wheel_radius_m)].id;
  event.value = 0.098;
  event.before = 0.1;
  core_->publish_event(event);
  ASSERT_TRUE(until([&] { return get("/api/v1/calibration").json()["under_way"]["result"].size() == 1; }));
  EXPECT_EQ(get("/api/v1/calibration").json()["under_way"]["result"][0]["name"], "wheel_radius_m");
  ASSERT_EQ(call("POST", "/api/v1/calibration/use", json::object()).status, 200);
  EXPECT_GT(core_->commands().back().v0, 1.6e9) << "today";
  ASSERT_EQ(call("POST", "/api/v1/neutral", json::object()).status, 200);
  EXPECT_GT(core_->commands().back().v0, 1.6e9) << "a posture that is set beside a walk is dated as one that is calibrated";
  EXPECT_EQ(call("DELETE", "/api/v1/calibration").status, 409) << "it is over";
}

// The struts may be zeroed only without a patient; the confirmation is part of the request, so that scripts must give it, too.
TEST_F(Rest, StrutsAreZeroedOnlyAfterAConfirmation) {
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  const json calibration = get("/api/v1/calibration").json();
  for (const json& item : calibration["items"]) {
    const bool needed =
        item["name"] == "zero" || item["name"] == "strut_length" || item["name"] == "strut_spacing" || item["name"] == "struts";
    EXPECT_EQ(item["empty_harness"], needed) << item["name"];
  }
  for (const json& refused : {json{{"step", "zero"}}, json{{"step", "zero"}, {"harness_empty", false}}}) {
    const Answer answer = call("POST", "/api/v1/calibration", refused);
    EXPECT_EQ(answer.status, 409);
    EXPECT_EQ(answer.json()["refusals"][0], "harness_unconfirmed");
    EXPECT_EQ(answer.json()["errors"][0]["field"], "harness_empty");
  }
  const std::size_t before = core_->commands().size();
  const Answer odd = call("POST", "/api/v1/calibration", {{"step", "zero"}, {"harness_empty", "yes"}});
  EXPECT_EQ(odd.status, 422);
  EXPECT_EQ(odd.json()["errors"][0]["field"], "harness_empty");
  EXPECT_EQ(core_->commands().size(), before);
  EXPECT_EQ(call("POST", "/api/v1/calibration", {{"step", "zero"}, {"harness_empty", true}}).status, 200);
}

TEST_F(Rest, WhatADeadCoreProposedIsNoResultOfTheNext) {
  const auto at_result = [this] {
    core_->set([](contract::TickRecord& r) {
      r.mode = static_cast<std::uint8_t>(Mode::calibrate);
      r.calibration_step = static_cast<std::uint8_t>(contract::CalibrationStep::zero);
      r.calibration_phase = 4;
    });
    return until([&] { return get("/api/v1/calibration").json()["under_way"].is_object(); });
  };
  const auto result = [this] { return get("/api/v1/calibration").json()["under_way"]["result"]; };
  ASSERT_TRUE(at_result());
  contract::Event event;
  event.kind = contract::EventKind::calibration_result;
  event.item = contract::kParams[contract::param_index(contract::ParamName::wheel_radius_m)].id;
  core_->publish_event(event);
  ASSERT_TRUE(until([&] { return result().size() == 1; }));
  core_.reset();
  wait_for_core(false);
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
  wait_for_core();
  ASSERT_TRUE(at_result());
  EXPECT_EQ(result().size(), 0U);
}

TEST_F(Rest, PoseIsChecked) {
  EXPECT_EQ(call("POST", "/api/v1/pose", {{"x_m", 1}, {"y_m", 2}, {"psi_rad", 0.5}}).status, 200);
  const Answer bad = call("POST", "/api/v1/pose", {{"x_m", 1e6}, {"psi_rad", "x"}});
  EXPECT_EQ(bad.status, 422);
  EXPECT_EQ(bad.json()["errors"].size(), 3U);
}

TEST_F(Rest, RefusalsAreCounted) {
  const auto counters = [&] { return get("/api/v1/status").json()["counters"]; };
  const json before = counters();
  EXPECT_EQ(http(port_, "GET", "/api/v1/status").status, 401);
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Host", "evil"}}).status, 421);
  EXPECT_EQ(get("/api/v1/none").status, 404);
  const json after = counters();
  EXPECT_EQ(after["http_refused_no_session"].get<int>(), before["http_refused_no_session"].get<int>() + 1);
  EXPECT_EQ(after["http_refused_host"].get<int>(), before["http_refused_host"].get<int>() + 1);
  EXPECT_EQ(after["http_refused_no_route"].get<int>(), before["http_refused_no_route"].get<int>() + 1);
  EXPECT_EQ(after["http_refused"].get<int>(), before["http_refused"].get<int>() + 3);
}

}  // namespace
}  // namespace hoist::test
