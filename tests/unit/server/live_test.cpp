// The WebSocket: handshake, telemetry, lease, driving, STOP, limits, slow readers.
#include <set>

#include "control/contract/faults.hpp"
#include "server/live/client.hpp"
#include "server/state/views.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;
class LiveTest : public ServerTest {
 protected:
  json counters() { return get("/api/v1/status").json()["counters"]; }
};

TEST_F(LiveTest, HandshakeNeedsSessionOriginAndSubprotocol_H28) {
  EXPECT_EQ(Live(port_, {}).status(), 401U);
  EXPECT_EQ(Live(port_, bearer_, "").status(), 426U) << "no subprotocol";
  EXPECT_EQ(Live(port_, bearer_, "hoist.v2").status(), 426U);
  Live two(port_, bearer_, "foxglove, hoist.v1");
  EXPECT_EQ(two.status(), 101U);
  EXPECT_EQ(two.protocol(), "hoist.v1");
  const std::string cookie = log_in();
  EXPECT_EQ(Live(port_, {{"Cookie", cookie}}).status(), 403U) << "a browser always says its origin";
  EXPECT_EQ(Live(port_, {{"Cookie", cookie}, {"Origin", "http://evil.example"}}).status(), 403U);
  EXPECT_EQ(Live(port_, {{"Cookie", cookie}, {"Origin", "null"}}).status(), 403U);
  EXPECT_EQ(Live(port_, {{"Cookie", cookie}, {"Origin", origin()}, {"Host", "evil.example"}}).status(), 421U);
  EXPECT_EQ(Live(port_, {{"Cookie", cookie}, {"Origin", origin()}}).status(), 101U);
  Headers foreign = bearer_;
  foreign.emplace_back("Origin", "http://evil.example");
  EXPECT_EQ(Live(port_, foreign).status(), 403U) << "also with the token";
  EXPECT_EQ(http(port_, "GET", "/ws", bearer_).status, 426U);
}

TEST_F(LiveTest, WelcomeSaysWhatRuns) {
  Live live(port_, bearer_);
  const json welcome = live.wait("welcome");
  EXPECT_EQ(welcome["layout_hash"], server::layout_hash_hex());
  EXPECT_EQ(welcome["record_bytes"], sizeof(contract::TickRecord));
  EXPECT_EQ(welcome["simulated"], true);
  EXPECT_EQ(live.wait("core")["connected"], true);
  EXPECT_EQ(live.wait("walk")["exercise"], (json{{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}}));
  EXPECT_EQ(live.wait("parameters")["values"].size(), contract::kParamCount);
  EXPECT_EQ(live.wait("lease")["mine"], false);
  EXPECT_EQ(live.wait("recording")["state"], "idle");
}

TEST_F(LiveTest, TelemetryIsWhatTheCorePublished) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"topics", {"all"}}});
  const auto got = live.records(40);
  ASSERT_GE(got.size(), 40U);
  EXPECT_EQ(live.frame_layout_hash(), contract::layout_hash());
  const auto published = core_->published();
  for (std::size_t i = 0; i < got.size(); ++i) {
    ASSERT_LE(got[i].tick, published.size());
    EXPECT_EQ(std::memcmp(&got[i], &published[got[i].tick - 1], sizeof got[i]), 0) << "tick " << got[i].tick;
    if (i > 0) {
      EXPECT_EQ(got[i].tick, got[i - 1].tick + 1);
    }
  }
}

TEST_F(LiveTest, LeaseAndDriving) {
  Live driver(port_, bearer_);
  Live other(port_, bearer_);
  const json drive{{"type", "drive"}, {"sequence", 1}, {"echo", 5}, {"speed", 0.5}, {"yaw", -0.25}, {"held", true}};
  other.send(drive);
  EXPECT_EQ(other.wait("notice")["refusals"][0], "no_lease");
  const json taken = driver.ask({{"type", "lease_take"}});
  ASSERT_EQ(taken["ok"], true) << taken;
  EXPECT_GT(taken["epoch"].get<int>(), 0);
  EXPECT_TRUE(until([&] { return driver.wait("lease")["mine"] == true; }));
  const json refused = other.ask({{"type", "lease_take"}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["refusals"][0], "no_lease");
  EXPECT_NE(refused["detail"].get<std::string>().find("take_over"), std::string::npos) << "not what was asked just now";
  driver.send(drive);
  ASSERT_TRUE(until([&] { return get("/api/v1/status").status == 200 && core_->drive().held == 1; }));
  const contract::DriveCommand command = core_->drive();
  EXPECT_EQ(command.speed_norm, 0.5);
  EXPECT_EQ(command.yaw_norm, -0.25);
  EXPECT_EQ(command.echo_time_ns, 5U);
  EXPECT_EQ(command.lease_epoch, taken["epoch"].get<std::uint32_t>());
  // The same number again, out of range, not a number: refused, and the last good one stays.
  driver.send(drive);
  EXPECT_EQ(driver.wait("notice")["refusals"][0], "out_of_order");
  json bad = drive;
  bad["sequence"] = 2;
  bad["speed"] = 1.5;
  driver.send(bad);
  bad["speed"] = "0.5";
  driver.send(bad);
  bad["speed"] = 0.5;
  bad["sequence"] = -3;
  driver.send(bad);
  bad.erase("held");
  driver.send(bad);
  ASSERT_TRUE(until([&] { return counters()["ws_refused_drive"] >= 6; }));
  EXPECT_EQ(core_->drive().sequence, 1U);
  EXPECT_EQ(driver.ask({{"type", "lease_release"}})["ok"], true);
}

// The core misses a console whose connection ends, and not one that gives control back.
TEST_F(LiveTest, TheCoreHearsThatTheConsoleInControlIsGone_H21) {
  const auto releases = [this] {
    std::vector<std::uint32_t> how;
    for (const contract::Command& command : core_->commands())
      if (command.kind == contract::CommandKind::release_lease) how.push_back(command.a);
    return how;
  };
  {
    Live driver(port_, bearer_);
    ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
    ASSERT_EQ(driver.ask({{"type", "lease_release"}})["ok"], true);
    EXPECT_EQ(releases(), std::vector<std::uint32_t>{0});
    ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  }
  EXPECT_TRUE(until([&] { return releases() == std::vector<std::uint32_t>{0, contract::kConsoleGone}; }));
}

TEST_F(LiveTest, AnAlarmsSoundIsPausedByWhoMay) {
  Live live(port_, bearer_);
  EXPECT_EQ(live.ask({{"type", "pause_alarm"}, {"paused", true}})["refusals"], json::array({"out_of_order"})) << "nothing sounds";
  core_->set([](contract::TickRecord& r) { r.fault_bits = contract::fault_bit(contract::Fault::battery_low); });
  EXPECT_EQ(live.ask({{"type", "pause_alarm"}, {"paused", true}})["ok"], true);
  const contract::Command command = core_->commands().back();
  EXPECT_EQ(command.kind, contract::CommandKind::pause_alarm);
  EXPECT_EQ(command.a, 1U);
  EXPECT_GE(command.b, 1U) << "the role travels to the core";
  EXPECT_EQ(live.ask({{"type", "pause_alarm"}})["ok"], false) << "says what is wanted";
  EXPECT_EQ(live.ask({{"type", "pause_alarm"}, {"paused", false}})["ok"], true);
  EXPECT_EQ(core_->commands().back().a, 0U);
}

TEST_F(LiveTest, LettingGoIsPassedOnWhateverElseIsWrong_H17) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  const json held{{"type", "drive"}, {"sequence", 10}, {"echo", 5}, {"speed", 0.5}, {"yaw", 0.25}, {"held", true}};
  std::uint64_t sequence = 10;
  std::uint64_t counted = 0;
  for (const auto& [name, bad] : {std::pair<const char*, json>{"speed", 1.5},
                                  {"speed", "fast"},
                                  {"yaw", nullptr},
                                  {"echo", -1},
                                  {"sequence", 10},
                                  {"sequence", "x"}}) {
    json message = held;
    message["sequence"] = sequence;
    driver.send(message);
    ASSERT_TRUE(until([&] { return core_->drive().held == 1; })) << name << bad;
    message["held"] = false;
    message["sequence"] = ++sequence;
    message[name] = bad;
    driver.send(message);
    ASSERT_TRUE(until([&] { return core_->drive().held == 0; })) << name << bad;
    EXPECT_EQ(core_->drive().speed_norm, 0.0);
    EXPECT_EQ(core_->drive().yaw_norm, 0.0);
    sequence += 2;
    ASSERT_TRUE(until([&] { return counters()["ws_refused_drive"] == counted + 1; })) << "it is still told and counted";
    ++counted;
  }
  // Neither from another client, nor anything but exactly a release.
  json message = held;
  message["sequence"] = sequence;
  driver.send(message);
  ASSERT_TRUE(until([&] { return core_->drive().held == 1; }));
  Live other(port_, bearer_);
  message["held"] = false;
  message["speed"] = 7;
  other.send(message);
  message["held"] = 0;
  driver.send(message);
  ASSERT_TRUE(until([&] { return counters()["ws_refused_drive"] == counted + 2; }));
  EXPECT_EQ(core_->drive().held, 1U);
}

TEST_F(LiveTest, ARefusedStartMovesNoPose) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  const json start{{"type", "mode"}, {"mode", "remote"}, {"exercise", {{"shape", "square"}, {"side_m", 3.0}}}};
  const auto refused = [&](const char* why) {
    const json reply = driver.ask(start);
    EXPECT_EQ(reply["ok"], false);
    EXPECT_NE(reply["refusals"].dump().find(why), std::string::npos) << reply;
    EXPECT_FALSE(reply["detail"].get<std::string>().empty());
    for (const auto& command : core_->commands()) EXPECT_NE(command.kind, contract::CommandKind::set_pose) << why;
  };
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  ASSERT_TRUE(until([&] { return get("/api/v1/mode").json()["mode"] == "user"; }));
  refused("not_standby");
  core_->set([](contract::TickRecord& r) {
    r.mode = static_cast<std::uint8_t>(Mode::standby);
    r.blocked_bits = contract::refusal_bit(contract::Refusal::not_neutral);
  });
  ASSERT_TRUE(until([&] { return get("/api/v1/mode").json()["blocked"] == json::array({"not_neutral"}); }));
  refused("not_neutral");
  core_->set([](contract::TickRecord& r) { r.blocked_bits = 0; });
  ASSERT_TRUE(until([&] { return get("/api/v1/mode").json()["blocked"].empty(); }));
  // The button is still held from something else.
  const json path{{"shape", "circle"}, {"radius_m", 1.0}, {"speed_m_s", 0.2}};
  const json guided{{"type", "mode"}, {"mode", "guided"}, {"path", path}};
  // What the server has told: a stamp that it does not know yet would be one from the future.
  driver.send({{"type", "stream"}, {"topics", {"all"}}});
  const auto told = driver.records(1);
  ASSERT_FALSE(told.empty());
  driver.send({{"type", "drive"}, {"sequence", 1}, {"echo", told.back().time_ns}, {"speed", 0.0}, {"yaw", 0.0}, {"held", true}});
  const json held = driver.ask(guided);
  EXPECT_EQ(held["refusals"], json::array({"release_first"})) << held;
  for (const auto& command : core_->commands()) EXPECT_NE(command.kind, contract::CommandKind::set_pose);
  // An old hold-to-run does not hold.
  driver.send({{"type", "drive"}, {"sequence", 2}, {"echo", 5}, {"speed", 0.0}, {"yaw", 0.0}, {"held", true}});
  EXPECT_EQ(driver.ask(guided)["ok"], true);
}

// The pose is set first and answered in a later step: a client that ends motion meanwhile must not see the hoist begin
// afterwards.
TEST_F(LiveTest, AStartThatWasEndedBeforeItBeganDoesNotBegin) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  driver.send({{"type", "mode"}, {"request", 900}, {"mode", "remote"}, {"exercise", {{"shape", "free"}}}});
  EXPECT_EQ(driver.ask({{"type", "mode"}, {"mode", "standby"}})["ok"], true);
  const json start = driver.wait("reply", 900);
  // On a busy machine it may have begun before the other one arrived.
  if (start["ok"] != true) {
    EXPECT_EQ(start["refusals"], json::array({"out_of_order"})) << start;
  }
  std::uint32_t last = 0;
  for (const auto& command : core_->commands())
    if (command.kind == contract::CommandKind::request_mode) last = command.a;
  EXPECT_EQ(last, static_cast<std::uint32_t>(Mode::standby)) << "the start overtook the end";
  EXPECT_EQ(core_->mode(), Mode::standby);
  EXPECT_EQ(driver.ask({{"type", "mode"}, {"mode", "remote"}, {"exercise", {{"shape", "free"}}}})["ok"], true) << "the next one does";
}

// A stalled link brings a request late, when its page may be gone. A client that does not say what it had seen is taken at its word.
TEST_F(LiveTest, WhatWasHeldUpOnItsWayBeginsNoMotionAndLeavesNoStop_H17) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  const json start{{"type", "mode"}, {"mode", "remote"}, {"exercise", {{"shape", "free"}}}}, acknowledge{{"type", "acknowledge"}};
  const json path{{"shape", "circle"}, {"radius_m", 1.0}, {"speed_m_s", 0.2}};
  const json guided{{"type", "mode"}, {"mode", "guided"}, {"path", path}}, end{{"type", "mode"}, {"mode", "standby"}};
  const auto seen = [&](json message) {
    message["echo"] = core_->published().back().time_ns;
    return message;
  };
  const auto late = [&](json message) {
    message = seen(message);
    core_->skip(150);
    return driver.ask(message);
  };
  const auto refused = [&](const json& reply) {
    EXPECT_EQ(reply["refusals"], json::array({"stale_command"})) << reply;
    EXPECT_NE(reply.value("detail", "").find("1 s"), std::string::npos) << "names what is allowed: " << reply;
  };
  refused(late(start));
  refused(late(guided));
  json impossible = start;
  impossible["echo"] = 0;
  refused(driver.ask(impossible));
  impossible["echo"] = core_->published().back().time_ns + 3'600'000'000'000;
  refused(driver.ask(impossible));
  impossible["echo"] = 1e30;
  refused(driver.ask(impossible));
  EXPECT_EQ(core_->mode(), Mode::standby);
  EXPECT_EQ(driver.ask(seen(start))["ok"], true);
  EXPECT_EQ(late(end)["ok"], true) << "ending motion has no age";
  EXPECT_EQ(driver.ask(start)["ok"], true) << "does not say what it had seen";
  driver.send({{"type", "stop"}});
  ASSERT_TRUE(until([&] { return core_->mode() == Mode::protective_stop; }));
  refused(late(acknowledge));
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(driver.ask(seen(acknowledge))["ok"], true);
}

// What a client sends just before its end: the hoist must not move for a client that is gone.
TEST_F(LiveTest, AClientWhoseEndIsThereBeginsNoMotionAndLeavesNoStop_H21) {
  std::size_t left = 0;
  const auto releases = [this] {
    return static_cast<std::size_t>(std::ranges::count(core_->commands(), contract::CommandKind::release_lease, &contract::Command::kind));
  };
  for (const bool close_frame : {true, false})
    for (const json& last :
         {json{{"type", "mode"}, {"request", 900}, {"mode", "user"}, {"exercise", {{"shape", "free"}}}},
          json{{"type", "mode"}, {"request", 900}, {"mode", "remote"}}, json{{"type", "acknowledge"}, {"request", 900}}}) {
      SCOPED_TRACE(last);
      const Mode before = last["type"] == "mode" ? Mode::standby : Mode::protective_stop;
      core_->set([before](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(before); });
      Live driver(port_, bearer_);
      ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
      driver.hold();
      // More than one reading of the server.
      for (int i = 0; i < 40; ++i) driver.send({{"type", "ping"}, {"t", i}});
      driver.send(last);
      for (int i = 0; i < 10; ++i) driver.send({{"type", "ping"}, {"t", i}});
      driver.end(close_frame);
      ASSERT_TRUE(until([&] { return releases() == left + 1; }));
      ++left;
      EXPECT_EQ(core_->mode(), before);
      for (const auto& command : core_->commands())
        EXPECT_TRUE(command.kind == contract::CommandKind::take_lease || command.kind == contract::CommandKind::release_lease);
    }
  Live driver(port_, bearer_);
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  driver.hold();
  driver.send({{"type", "stop"}});
  driver.end(true);
  EXPECT_TRUE(until([&] { return core_->mode() == Mode::protective_stop; })) << "STOP counts all the same";
}

TEST_F(LiveTest, FieldsOfAWrongTypeAreNamed) {
  Live live(port_, bearer_);
  const auto refused = [&](json message, const char* field) {
    const json reply = live.ask(std::move(message));
    EXPECT_EQ(reply["ok"], false);
    EXPECT_EQ(reply["errors"][0]["field"], field) << reply;
  };
  refused({{"type", "lease_take"}, {"take_over", "x"}}, "take_over");
  refused({{"type", "ping"}, {"t", "x"}}, "t");
  refused({{"type", "ping"}}, "t");
  refused({{"type", "stream"}, {"every_tick", 1}}, "every_tick");
  refused({{"type", "preset"}, {"name", 5}}, "name");
  refused({{"type", "set"}, {"values", "x"}}, "values");
  refused({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 30}}}, {"revert_after_s", "soon"}}, "revert_after_s");
  refused({{"type", "marker"}}, "text");
  // Ranges, choices and unknown fields, by the schemas of REST.
  refused({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 30}}}, {"revert_after_s", 121}}, "revert_after_s");
  refused({{"type", "set"}, {"values", {{"lean_gain_filtered_units", "30"}}}}, "values.lean_gain_filtered_units");
  refused({{"type", "set"}, {"values", json::object()}}, "values");
  refused({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 30}}}, {"version", 0}}, "version");
  refused({{"type", "keep_settings"}, {"version", 4294967296U}}, "version");
  refused({{"type", "pose"}, {"x_m", 1001}, {"y_m", 0}, {"psi_rad", 0}}, "x_m");
  refused({{"type", "calibrate_measure"}, {"figure", 1}, {"turning", "up"}}, "turning");
  refused({{"type", "calibrate_measure"}, {"figure", 1}, {"x_m", 0}, {"turning", "left"}}, "y_m");
  refused({{"type", "calibrate"}, {"step", "none of ours"}}, "step");
  refused({{"type", "mode"}, {"mode", "init"}}, "mode");
  refused({{"type", "mode"}, {"mode", "user"}, {"echo", "now"}}, "echo");
  refused({{"type", "choose"}, {"exercise", {{"shape", "square"}, {"side_m", 1e9}}}}, "exercise.side_m");
  refused({{"type", "neutral"}, {"other", 1}}, "other");
  refused({{"type", "lease_hand_over"}}, "body");
  EXPECT_TRUE(core_->commands().empty());
  live.send({{"type", "neutral"}, {"request", "x"}});
  const json reply = live.wait("reply");
  EXPECT_EQ(reply["errors"][0]["field"], "request");
  EXPECT_EQ(reply["request"], 0) << "always a number";
  EXPECT_EQ(live.ask({{"type", "lease_take"}, {"take_over", nullptr}})["ok"], true) << "left out";
}

// The next state of the lease that one of these tells, or nothing.
json lease_where(Live& live, const std::function<bool(const json&)>& wanted) {
  for (json lease = live.wait("lease"); !lease.empty(); lease = live.wait("lease"))
    if (wanted(lease)) return lease;
  return {};
}

TEST_F(LiveTest, TheHolderSeesWhoAsksAndHandsOverAtStandstill_H20) {
  Live driver(port_, bearer_), other(port_, bearer_);
  const std::uint32_t driving = driver.wait("welcome")["client"], asking = other.wait("welcome")["client"];
  EXPECT_EQ(other.ask({{"type", "lease_ask"}})["reason_code"], "lease_free") << "nobody to ask";
  const json taken = driver.ask({{"type", "lease_take"}});
  ASSERT_EQ(taken["ok"], true);
  EXPECT_EQ(driver.ask({{"type", "lease_ask"}})["reason_code"], "lease_free") << "of itself";
  ASSERT_EQ(other.ask({{"type", "lease_ask"}})["ok"], true);
  const json asked = lease_where(driver, [](const json& lease) { return !lease["asking"].empty(); });
  EXPECT_EQ(asked["asking"],
            json::array({{{"client", asking},
                          {"actor", {{"user", "local"}, {"role", "engineer"}, {"origin", "hoist.v1"}, {"client", "script"}}}}}));
  EXPECT_EQ(asked["actor"]["origin"], "hoist.v1");
  EXPECT_EQ(get("/api/v1/status").json()["lease"]["asking"][0]["client"], asking);
  // The holder keeps it: the client that asks is told, and asks no longer.
  ASSERT_EQ(driver.ask({{"type", "lease_keep"}})["ok"], true);
  EXPECT_EQ(other.wait("notice")["text_key"], "lease_kept");
  EXPECT_TRUE(get("/api/v1/lease").json()["asking"].empty());
  // Only its holder gives it away, to a client that is there, and not while the hoist moves.
  EXPECT_EQ(other.ask({{"type", "lease_hand_over"}, {"client", asking}})["refusals"][0], "no_lease");
  EXPECT_EQ(other.ask({{"type", "lease_keep"}})["refusals"][0], "no_lease");
  EXPECT_EQ(driver.ask({{"type", "lease_hand_over"}, {"client", asking + 1}})["reason_code"], "unknown");
  EXPECT_EQ(driver.ask({{"type", "lease_hand_over"}, {"user", "nobody of this name"}})["reason_code"], "unknown");
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  EXPECT_EQ(driver.ask({{"type", "lease_hand_over"}, {"client", asking}})["refusals"], json::array({"moving"}));
  EXPECT_EQ(get("/api/v1/lease").json()["holder"], driving);
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::standby); });
  ASSERT_EQ(other.ask({{"type", "lease_ask"}})["ok"], true);
  ASSERT_EQ(driver.ask({{"type", "lease_hand_over"}, {"client", asking}})["ok"], true);
  const json mine = lease_where(other, [](const json& lease) { return lease["mine"] == true; });
  EXPECT_EQ(mine["holder"], asking);
  EXPECT_EQ(mine["epoch"], taken["epoch"].get<std::uint32_t>() + 1);
  EXPECT_TRUE(mine["asking"].empty()) << "asked was the former holder";
  const json event = other.wait("event");
  EXPECT_EQ(event["kind"], "lease_changed");
  EXPECT_EQ(event["actor"]["user"], "local");
}

TEST_F(LiveTest, AnAskEndsWithItsClientAndByName) {
  Live driver(port_, bearer_);
  auto other = std::make_unique<Live>(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(other->ask({{"type", "lease_ask"}})["ok"], true);
  ASSERT_EQ(other->ask({{"type", "lease_ask"}, {"withdraw", true}})["ok"], true);
  EXPECT_TRUE(get("/api/v1/lease").json()["asking"].empty());
  ASSERT_EQ(other->ask({{"type", "lease_ask"}})["ok"], true);
  EXPECT_EQ(get("/api/v1/lease").json()["asking"].size(), 1U);
  const std::uint32_t gone = get("/api/v1/lease").json()["asking"][0]["client"];
  other->close();
  EXPECT_TRUE(until([&] { return get("/api/v1/lease").json()["asking"].empty(); }));
  EXPECT_EQ(driver.ask({{"type", "lease_hand_over"}, {"client", gone}})["reason_code"], "unknown");
  Live next(port_, bearer_);
  const std::uint32_t newest = next.wait("welcome")["client"];
  ASSERT_EQ(driver.ask({{"type", "lease_hand_over"}, {"user", "local"}})["ok"], true);
  EXPECT_EQ(get("/api/v1/lease").json()["holder"], newest);
}

TEST_F(LiveTest, ALeaseIsAskedForAndHandedOverByRest) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  EXPECT_TRUE(get("/api/v1/lease").json()["expires_in_s"].is_null()) << "a WebSocket's has no time";
  ASSERT_EQ(call("POST", "/api/v1/lease/ask").status, 200);
  const json lease = get("/api/v1/lease").json();
  ASSERT_EQ(lease["asking"][0]["actor"]["origin"], "rest");
  ASSERT_EQ(driver.ask({{"type", "lease_hand_over"}, {"client", lease["asking"][0]["client"]}})["ok"], true);
  const json held = get("/api/v1/lease").json();
  EXPECT_GT(held["expires_in_s"], 8.0) << "time to use it";
  EXPECT_EQ(call("POST", "/api/v1/lease/ask").status, 409) << "has it already";
  EXPECT_EQ(call("POST", "/api/v1/lease/hand-over", {{"client", 1}, {"user", "local"}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/lease/hand-over", {{"client", 4294967295U}}).status, 404);
  const Headers old{{"X-Hoist-Lease", std::to_string(held["epoch"].get<int>() - 1)}};
  EXPECT_EQ(call("POST", "/api/v1/lease/keep", json::object(), old).status, 409) << "the epoch of the former lease";
  EXPECT_EQ(call("POST", "/api/v1/lease/hand-over", {{"client", held["holder"]}}, old).status, 409);
  EXPECT_EQ(call("POST", "/api/v1/lease/keep").status, 200);
  EXPECT_EQ(call("DELETE", "/api/v1/lease/ask").status, 200);
}

TEST(LeaseAsks, AreBoundedAndEnd) {
  server::LeaseAsks asks;
  for (std::uint32_t client = 1; client <= server::LeaseAsks::kMost; ++client) EXPECT_TRUE(asks.add(client, client));
  EXPECT_FALSE(asks.add(99, 10));
  EXPECT_TRUE(asks.add(1, 50)) << "once more";
  EXPECT_EQ(asks.list().size(), server::LeaseAsks::kMost);
  asks.expire(2 + server::LeaseAsks::kLife_ns);
  EXPECT_FALSE(asks.has(2));
  EXPECT_TRUE(asks.has(1)) << "asked again";
  EXPECT_TRUE(asks.has(3));
  const std::uint64_t before = asks.changes();
  asks.remove(77);
  EXPECT_EQ(asks.changes(), before) << "nothing to tell";
}

TEST_F(LiveTest, ADriverWhoIsGoneLosesTheLease) {
  auto driver = std::make_unique<Live>(port_, bearer_);
  ASSERT_EQ(driver->ask({{"type", "lease_take"}})["ok"], true);
  driver->close();
  EXPECT_TRUE(until([&] { return get("/api/v1/status").json()["lease"]["holder"] == 0; }));
  // Numbers are never used again: the next connection is not taken for the last driver.
  Live next(port_, bearer_);
  const json welcome = next.wait("welcome");
  for (const auto& command : core_->commands()) EXPECT_NE(command.client, welcome["client"].get<std::uint32_t>());
}

TEST_F(LiveTest, StopFromSomeoneWhoDoesNotDrive) {
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(driver.ask({{"type", "mode"}, {"mode", "user"}, {"exercise", nullptr}})["ok"], true);
  EXPECT_EQ(core_->mode(), Mode::user);
  Live other(port_, bearer_);
  other.send({{"type", "stop"}});
  EXPECT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["mode"] == "protective_stop"; }));
  EXPECT_EQ(other.ask({{"type", "acknowledge"}})["ok"], false);
  const json refused = driver.ask({{"type", "acknowledge"}, {"seen", {"nothing_we_know"}}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["errors"][0]["field"], "seen");
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(driver.ask({{"type", "acknowledge"}, {"seen", {"stop_pressed"}}})["ok"], true);
  EXPECT_EQ(core_->commands().back().bits, contract::fault_bit(contract::Fault::stop_pressed));
}

TEST_F(LiveTest, StopIsHeardEvenBeyondTheMessageLimit) {
  Live live(port_, bearer_);
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  for (std::uint64_t i = 0; i < server::kMessagesPerSecond; ++i) live.send({{"type", "ping"}, {"t", i}});
  live.send({{"type", "stop"}});
  EXPECT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["mode"] == "protective_stop"; }));
}

// As a stalled link brings it: what a hand on the joystick sent meanwhile, and its STOP behind that. The connection is being closed by then.
TEST_F(LiveTest, StopIsHeardBehindAFloodThatClosesTheConnection) {
  // In the reading that closes, and in a later one.
  for (const std::size_t flood_bytes : {std::size_t{20'000}, server::kReadTurn_bytes + 20'000}) {
    core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
    Live live(port_, bearer_);
    live.hold();
    // Long ones: they are looked through within the second that closing takes, also under a sanitizer.
    const std::string ping = json{{"type", "ping"}, {"t", 1}}.dump() + std::string(200, ' ');
    for (std::size_t sent = 0; sent < flood_bytes; sent += ping.size()) live.send_text(ping);
    live.send({{"type", "stop"}});
    live.send({{"type", "lease_take"}, {"request", 1}});
    live.end(false);
    EXPECT_TRUE(until([&] { return core_->mode() == Mode::protective_stop; })) << flood_bytes;
    EXPECT_EQ(live.wait_close(), 1008U) << flood_bytes;
  }
  for (const auto& command : core_->commands()) EXPECT_EQ(command.kind, contract::CommandKind::stop) << "nothing else counts";
}

TEST_F(LiveTest, ParametersOverTheSocket) {
  Live live(port_, bearer_);
  ASSERT_EQ(live.wait("parameters")["version"], 1);
  EXPECT_EQ(live.ask({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 30}}}})["ok"], true);
  const json changed = live.wait("parameters");
  EXPECT_EQ(changed["values"]["lean_gain_filtered_units"], 30.0);
  const json event = live.wait("event");
  EXPECT_EQ(event["kind"], "parameter_changed");
  EXPECT_EQ(event["actor"], (json{{"user", "local"}, {"role", "engineer"}, {"origin", "hoist.v1"}, {"client", "script"}}));
  EXPECT_EQ(event["name"], "lean_gain_filtered_units");
  EXPECT_EQ(event["before"], 50.0);
  const json refused = live.ask({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 101}}}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["errors"][0]["max"], 100.0);
  EXPECT_EQ(live.ask({{"type", "preset"}, {"name", "paper"}})["ok"], true);
  EXPECT_EQ(live.ask({{"type", "preset"}, {"name", "nothing"}})["ok"], false);
  EXPECT_EQ(live.ask({{"type", "set"}, {"values", json::array({1})}})["ok"], false);
}

TEST_F(LiveTest, WhatIsKeptIsWhatWasLookedAt_H27) {
  Live live(port_, bearer_);
  live.wait("parameters");
  ASSERT_EQ(live.ask({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 30}}}, {"revert_after_s", 20}})["ok"], true);
  const json seen = live.wait("parameters")["version"];
  ASSERT_EQ(live.ask({{"type", "set"}, {"values", {{"lean_gain_filtered_units", 90}}}, {"revert_after_s", 20}})["ok"], true);
  const json refused = live.ask({{"type", "keep_settings"}, {"version", seen}});
  EXPECT_EQ(refused["ok"], false);
  EXPECT_EQ(refused["refusals"][0], "set_outdated");
  EXPECT_EQ(live.ask({{"type", "keep_settings"}, {"version", "newest"}})["errors"][0]["field"], "version");
  const json newest = live.wait("parameters")["version"];
  EXPECT_EQ(live.ask({{"type", "keep_settings"}, {"version", newest}})["ok"], true);
  EXPECT_EQ(live.ask({{"type", "undo_settings"}})["ok"], false) << "nothing is on trial any more";
}

TEST_F(LiveTest, EveryStepOnlyForTheDriver) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"every_tick", true}});
  EXPECT_EQ(live.wait("notice")["refusals"][0], "no_lease");
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  live.send({{"type", "stream"}, {"topics", {"all"}}, {"every_tick", true}});
  const json pong_before = live.ask({{"type", "neutral"}});
  EXPECT_EQ(pong_before["ok"], true);
  const auto records = live.records(20);
  ASSERT_GE(records.size(), 20U);
  for (std::size_t i = 1; i < records.size(); ++i) EXPECT_EQ(records[i].tick, records[i - 1].tick + 1);
}

// A sample of the topics state and motion: its length and where its values lie, by topics.def.
constexpr std::size_t kStateBytes = 66, kMotionBytes = 20, kSamplesBegin = 20, kMode = 46;
struct ChosenSample {
  std::uint64_t tick = 0;
  std::uint8_t mode = 0;
  float speed_m_s = 0;
};
std::vector<ChosenSample> chosen_samples(const std::string& message) {
  std::vector<ChosenSample> all;
  for (std::size_t at = kSamplesBegin; at + kStateBytes + kMotionBytes <= message.size(); at += kStateBytes + kMotionBytes) {
    ChosenSample& sample = all.emplace_back();
    std::memcpy(&sample.tick, message.data() + at, 8);
    std::memcpy(&sample.mode, message.data() + at + kMode, 1);
    std::memcpy(&sample.speed_m_s, message.data() + at + kStateBytes + 8, 4);
  }
  return all;
}

TEST_F(LiveTest, ChosenTopicsComeAtTheChosenRate) {
  core_->set_each([](contract::TickRecord& record) { record.speed_m_s = static_cast<float>(record.tick) * 0.25F; });
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"topics", {"motion"}}, {"rate_hz", 10}});
  const json told = live.wait("streaming");
  EXPECT_EQ(told["topics"], (json{"state", "motion"}));
  EXPECT_EQ(told["rate_hz"], 10);
  EXPECT_EQ(told["every_tick"], false);
  ASSERT_EQ(told["sample_bytes"], kStateBytes + kMotionBytes);
  std::uint64_t before = 0;
  for (int i = 0; i < 8; ++i) {
    const std::string message = live.binary();
    ASSERT_EQ(message.size(), kSamplesBegin + kStateBytes + kMotionBytes) << "one sample";
    EXPECT_EQ(message.substr(0, 4), std::string("\2\1\1\0", 4));
    const ChosenSample sample = chosen_samples(message).at(0);
    EXPECT_EQ(sample.tick % 10, 0U);
    // The first may be of a step before the speeds were set.
    if (before != 0) {
      EXPECT_EQ(sample.tick, before + 10);
      EXPECT_EQ(sample.speed_m_s, static_cast<float>(sample.tick) * 0.25F);
    }
    before = sample.tick;
    EXPECT_EQ(sample.mode, static_cast<std::uint8_t>(Mode::standby));
  }
  live.send({{"type", "stream"}, {"topics", {"power", "all"}}, {"rate_hz", 20}});
  EXPECT_EQ(live.wait("streaming")["topics"], json{"all"});
  const auto whole = live.records(3);
  ASSERT_GE(whole.size(), 3U);
  EXPECT_EQ(whole.back().tick - whole[whole.size() - 2].tick, 5U);
}

TEST_F(LiveTest, WhoChoosesNothingGetsHowTheHoistMovesAndLeans_NotWholeRecords) {
  Live live(port_, bearer_);
  const std::string message = live.binary();
  ASSERT_GE(message.size(), kSamplesBegin);
  EXPECT_EQ(message.substr(0, 4), std::string("\2\1\5\0", 4)) << "blocks of topics, five steps";
  std::uint32_t sample_bytes = 0, topics = 0;
  std::memcpy(&sample_bytes, message.data() + 4, sizeof sample_bytes);
  std::memcpy(&topics, message.data() + 16, sizeof topics);
  EXPECT_EQ(message.size(), kSamplesBegin + 5 * sample_bytes);
  EXPECT_EQ(topics, 0b11111U) << "state, motion, pose, posture, intent";
  EXPECT_LT(sample_bytes, sizeof(contract::TickRecord) / 3);
}

TEST_F(LiveTest, AChangeOfStateIsSentAtOnceAtAnyRate) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"topics", {"motion"}}, {"rate_hz", 1}});
  live.wait("streaming");
  core_->set_each([](contract::TickRecord& record) {
    if (record.tick % 100 == 37) record.mode = static_cast<std::uint8_t>(Mode::protective_stop);
  });
  ChosenSample sample;
  for (int i = 0; i < 4 && sample.mode != static_cast<std::uint8_t>(Mode::protective_stop); ++i) {
    const auto samples = chosen_samples(live.binary());
    ASSERT_FALSE(samples.empty());
    sample = samples.back();
  }
  EXPECT_EQ(sample.mode, static_cast<std::uint8_t>(Mode::protective_stop));
  EXPECT_EQ(sample.tick % 100, 37U) << "the step that changed it, between the samples of the chosen rate";
}

// What a driver's commands echo is never old because of what the page has chosen to see.
TEST_F(LiveTest, TheDriverGetsAtLeastTwentySamplesASecond_H17) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"topics", {"motion"}}, {"rate_hz", 1}});
  EXPECT_EQ(live.wait("streaming")["rate_hz"], 1);
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  live.binary();
  const std::uint64_t first = chosen_samples(live.binary()).at(0).tick;
  EXPECT_LE(chosen_samples(live.binary()).at(0).tick - first, 5U);
  live.send({{"type", "stream"}, {"topics", {"motion"}}, {"every_tick", true}});
  EXPECT_EQ(live.wait("streaming")["every_tick"], true);
  const std::uint64_t second = chosen_samples(live.binary()).back().tick;
  EXPECT_EQ(chosen_samples(live.binary()).at(0).tick, second + 1);
}

TEST_F(LiveTest, UnknownTopicsAndRatesAreRefusedWithWhatIsAllowed) {
  Live live(port_, bearer_);
  const auto refused = [&live](json message) {
    message["type"] = "stream";
    const json reply = live.ask(message);
    EXPECT_EQ(reply["ok"], false) << message;
    return reply["errors"].empty() ? json::object() : reply["errors"][0];
  };
  const json topic = refused({{"topics", {"motion", "speed"}}});
  EXPECT_EQ(topic["field"], "topics.1");
  EXPECT_NE(topic["message"].get<std::string>().find("motion, pose"), std::string::npos) << topic;
  for (const int rate : {0, 3, 101, -1}) {
    const json error = refused({{"rate_hz", rate}});
    EXPECT_EQ(error["field"], "rate_hz");
    EXPECT_EQ(error["message"], "must be 1, 2, 5, 10, 20, 50 or 100");
    EXPECT_EQ(error["min"], 1);
    EXPECT_EQ(error["max"], 100);
  }
  EXPECT_EQ(refused({{"topics", json::array()}})["field"], "topics");
  EXPECT_EQ(refused({{"last_tick", 7}})["field"], "run");
  EXPECT_EQ(refused(json::object())["field"], "body");
}

TEST_F(LiveTest, StepsOfAnotherCoreAreNotResumed) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"last_tick", 7}, {"run", "1"}});
  const json gap = live.wait("gap");
  EXPECT_EQ(gap, (json{{"type", "gap"}, {"from_tick", 8}, {"to_tick", nullptr}, {"count", nullptr}, {"reason", "core_restarted"}}));
}

TEST_F(LiveTest, MessagesThatCannotBeUsed_H30) {
  struct Case {
    std::string text;
    unsigned code;
  };
  for (const Case& c : {Case{"not json", 1008},
                        {"[1]", 1008},
                        {std::string(4000, '['), 1008},
                        {"{\"type\": \"ping\", \"t\": NaN}", 1008},
                        {std::string(4097, ' '), 1009}}) {
    Live live(port_, bearer_);
    live.send_text(c.text);
    EXPECT_EQ(live.wait_close(), c.code) << c.text.substr(0, 40);
  }
  Live binary(port_, bearer_);
  binary.send_binary("x");
  EXPECT_EQ(binary.wait_close(), 1003U);
  Live live(port_, bearer_);
  EXPECT_EQ(live.ask({{"type", "unheard"}})["ok"], false);
  live.send({{"type", "neutral"}});
  EXPECT_EQ(live.wait("reply")["errors"][0]["field"], "request");
  live.send({{"type", 5}});
  EXPECT_EQ(live.wait("reply")["errors"][0]["field"], "type");
  EXPECT_GE(counters()["ws_refused"].get<int>(), 9);
}

TEST_F(LiveTest, AFieldThatIsGivenTwiceIsRefused_H30) {
  Live live(port_, bearer_);
  live.send_text(R"({"type": "lease_take", "request": 1, "take_over": true, "take_over": false})");
  EXPECT_EQ(live.wait("reply")["errors"][0]["field"], "take_over");
  ASSERT_EQ(live.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(live.ask({{"type", "mode"}, {"mode", "remote"}})["ok"], true);
  live.send_text(R"({"type": "drive", "sequence": 1, "echo": 5, "speed": 0.5, "yaw": 0, "held": true})");
  ASSERT_TRUE(until([&] { return get("/api/v1/status").status == 200 && core_->drive().held == 1; }));
  live.send_text(R"({"type": "drive", "sequence": 2, "echo": 5, "speed": 0.5, "yaw": 0, "held": false, "held": true})");
  EXPECT_TRUE(until([&] { return get("/api/v1/status").status == 200 && core_->drive().held == 0; })) << "one of them let go";
  live.send_text(R"({"type": "mode", "request": 2, "mode": "standby", "exercise": null, "exercise": null})");
  EXPECT_EQ(live.wait("reply", 2)["ok"], true) << "ending motion is not delayed";
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  live.send_text(R"({"type": "stop", "type": "stop"})");
  EXPECT_TRUE(until([&] { return core_->mode() == Mode::protective_stop; }));
}

TEST_F(LiveTest, AMessageFollowedByOtherBytesIsNone_H30) {
  Live live(port_, bearer_);
  live.send_text(std::string("{\"type\": \"ping\", \"t\": 1}\0{}", 27));
  EXPECT_TRUE(until([&] { return counters()["ws_refused_json"] == 1; }));
}

TEST_F(LiveTest, TooManyMessagesEndTheConnection_H31) {
  Live live(port_, bearer_);
  // More than a second's worth in one go; a slow machine refills meanwhile, hence the margin.
  for (int i = 0; i < 2000; ++i) live.send({{"type", "ping"}, {"t", i}});
  EXPECT_TRUE(until([&] { return counters()["ws_refused_rate"] == 1; }));
}

TEST_F(LiveTest, AReaderWhoNeverReadsDelaysNobody_H31) {
  // A tiny window and no reading: the server's buffers for this client fill up.
  Raw stuck(port_, 2048);
  ASSERT_TRUE(stuck.send(
      "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
      "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
      "Sec-WebSocket-Protocol: hoist.v1\r\nAuthorization: " +
      bearer_[0].second + "\r\n\r\n"));
  ASSERT_EQ(stuck.read(12), "HTTP/1.1 101");
  Live good(port_, bearer_);
  good.send({{"type", "stream"}, {"topics", {"all"}}});
  good.wait("streaming");
  // Much more than its buffers hold, faster than time.
  std::uint64_t last = 0;
  bool dropped = false;
  for (int round = 0; round < 60 && !dropped; ++round) {
    core_->skip(100);
    const auto records = good.records(100);
    ASSERT_GE(records.size(), 100U);
    for (const auto& record : records) {
      EXPECT_EQ(record.tick, last == 0 ? record.tick : last + 1) << "the good reader misses nothing";
      last = record.tick;
    }
    const json now = counters();
    dropped = now["telemetry_frames_dropped"] > 0 || now["ws_closed_slow"] > 0 || now["ws_closed_silent"] > 0;
  }
  EXPECT_TRUE(dropped) << "the stuck one loses frames or its connection, never anyone's memory";
}

TEST_F(LiveTest, ASilentClientIsDropped) {
  Raw silent(port_);
  ASSERT_TRUE(silent.send(
      "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
      "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
      "Sec-WebSocket-Protocol: hoist.v1\r\nAuthorization: " +
      bearer_[0].second + "\r\n\r\n"));
  const std::string all = silent.read_to_end(20000);
  EXPECT_TRUE(all.starts_with("HTTP/1.1 101"));
  EXPECT_TRUE(silent.closed()) << "it answers no ping";
  EXPECT_EQ(counters()["ws_closed_silent"], 1);
}

TEST_F(LiveTest, TheCoreDiesAndComesBack) {
  Live live(port_, bearer_);
  live.send({{"type", "stream"}, {"topics", {"all"}}});
  ASSERT_GE(live.records(5).size(), 5U);
  core_.reset();
  EXPECT_TRUE(until([&] { return live.wait("core")["connected"] == false; }));
  EXPECT_EQ(live.ask({{"type", "neutral"}})["ok"], false);
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
  EXPECT_TRUE(until([&] { return live.wait("core")["connected"] == true; }));
  EXPECT_GE(live.records(5).size(), 5U);
  EXPECT_EQ(live.ask({{"type", "neutral"}})["ok"], true) << "commands work in the new life";
}

}  // namespace
}  // namespace hoist::test
