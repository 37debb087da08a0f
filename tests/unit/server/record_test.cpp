// The recording as people get it: what the core published is what the export says, whatever happened in between.
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/program_version.hpp"
#include "control/publish/core_link.hpp"
#include "control/publish/server_link.hpp"
#include "db/export/session_export.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/database.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"
#include "db/summary/session_metrics.hpp"
#include "server/record/recorder.hpp"
#include "tests/support/crash_disk.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;

class Record : public ServerTest {
 protected:
  void mode(Mode mode) {
    core_->set([mode](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(mode); });
  }
  json recording() { return get("/api/v1/recording").json(); }
  bool wait_state(const char* state) {
    return until([&] { return recording()["state"] == state; });
  }
  // The rows of the CSV by column name.
  std::vector<std::map<std::string, std::string>> rows(const std::string& csv) {
    std::vector<std::map<std::string, std::string>> out;
    std::vector<std::string> names;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.starts_with("#") || line.empty()) continue;
      std::vector<std::string> cells;
      std::istringstream parts(line);
      for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(cell);
      if (names.empty()) {
        names = cells;
        continue;
      }
      std::map<std::string, std::string> row;
      for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) row[names[i]] = cells[i];
      out.push_back(std::move(row));
    }
    return out;
  }
};

TEST_F(Record, AWalkIsRecordedAndExportedAsPublished) {
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  const json lease = get("/api/v1/status").json()["lease"];
  const Headers holder{{"X-Hoist-Lease", std::to_string(lease["epoch"].get<int>())}};
  ASSERT_EQ(
      call("POST", "/api/v1/mode", {{"mode", "user"}, {"exercise", {{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}}}}, holder).status,
      200);
  ASSERT_TRUE(wait_state("recording"));
  EXPECT_EQ(call("POST", "/api/v1/sessions/1/markers", {{"text", "=1+1 looks, good"}}).status, 201);
  EXPECT_EQ(call("POST", "/api/v1/sessions/1/markers", {{"text", 5}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/sessions/99/markers", {{"text", "x"}}).status, 404);
  EXPECT_EQ(call("DELETE", "/api/v1/sessions/1").status, 409) << "not while it is being recorded";
  core_->skip(300);
  ASSERT_EQ(call("POST", "/api/v1/mode", {{"mode", "standby"}}, holder).status, 200);
  core_->skip(400);
  ASSERT_TRUE(wait_state("idle"));
  const json session = get("/api/v1/sessions/1").json();
  EXPECT_EQ(session["close_reason"], "finished");
  EXPECT_EQ(session["gaps"], 0);
  EXPECT_EQ(session["simulated"], true);
  EXPECT_EQ(session["exercise"], (json{{"shape", "eight"}, {"c_m", 1.0}, {"radius_m", 0.8}}));
  const Answer csv = get("/api/v1/sessions/1/export?format=csv");
  ASSERT_EQ(csv.status, 200);
  EXPECT_NE(csv.header("content-disposition").find("attachment"), std::string::npos);
  EXPECT_EQ(csv.header("cache-control"), "no-store");
  const auto lines = rows(csv.body);
  ASSERT_EQ(lines.size(), session["samples"].get<std::size_t>());
  ASSERT_GT(lines.size(), 600U);
  const auto published = core_->published();
  for (const auto& line : lines) {
    const std::size_t tick = std::stoul(line.at("tick"));
    ASSERT_LE(tick, published.size());
    EXPECT_EQ(std::stoull(line.at("time_ns")), published[tick - 1].time_ns);
    EXPECT_NEAR(std::stod(line.at("x_m")), static_cast<double>(published[tick - 1].x_m), 0.51e-5 + 1e-6);
    EXPECT_EQ(std::stoul(line.at("mode")), published[tick - 1].mode);
    EXPECT_EQ(line.at("gap_before"), "0");
  }
  const json exported = get("/api/v1/sessions/1/export?format=json").json();
  EXPECT_EQ(exported["rows"], session["samples"]);
  EXPECT_EQ(get("/api/v1/sessions/1/export?format=xls").status, 422);
  const json marker = get("/api/v1/sessions/1/markers").json()["items"][0];
  EXPECT_EQ(marker["text"], "=1+1 looks, good");
  // Who asked stands with what was done; the connection's number does not.
  const json actor{{"user", "local"}, {"role", "engineer"}, {"origin", "rest"}, {"client", "script"}};
  EXPECT_EQ(marker["actor"], actor);
  int asked = 0;
  const json events = get("/api/v1/sessions/1/events").json()["items"];
  for (const json& event : events) {
    EXPECT_FALSE(event.contains("client"));
    if (event["actor"] == actor) ++asked;
  }
  EXPECT_GT(asked, 0);
  EXPECT_NE(get("/api/v1/sessions/1/export?format=events").body.find(",local,engineer,rest,script,"), std::string::npos);
  const json samples = get("/api/v1/sessions/1/samples?columns=x_m,mode&points=10").json();
  EXPECT_EQ(samples["columns"][0]["name"], "x_m");
  EXPECT_LE(samples["from_s"].size(), 10U);
  for (const char* bad : {"", "?columns=", "?columns=nothing", "?columns=x_m&points=0", "?columns=x_m&points=1e9", "?columns=x_m&from_s=x",
                          "?columns=x_m&from_s=nan"})
    EXPECT_EQ(get(std::string("/api/v1/sessions/1/samples") + bad).status, 422) << bad;
  const json status = get("/api/v1/status").json();
  EXPECT_EQ(status["version"], contract::program_version());
  EXPECT_EQ(session["software_version"], status["version"]);
  EXPECT_EQ(session["core_version"], status["core"]["version"]);
  EXPECT_EQ(session["layout_hash"], status["server"]["layout_hash"]);
  EXPECT_EQ(session["nodes"].size(), contract::kRemoteNodeCount);
  EXPECT_TRUE(session["nodes"][0]["revision"].is_null()) << "nobody asked that node";
  const Answer chosen = get("/api/v1/sessions/1/export?columns=y_m,x_m&comments=0");
  EXPECT_EQ(chosen.body.substr(0, chosen.body.find('\n')), "utc,time_s,gap_before,y_m,x_m");
  const Answer unknown = get("/api/v1/sessions/1/export?columns=x_m,nothing,other");
  EXPECT_EQ(unknown.status, 422);
  EXPECT_EQ(unknown.json()["errors"][0]["field"], "columns");
  EXPECT_NE(unknown.body.find("nothing, other"), std::string::npos) << unknown.body;
  EXPECT_EQ(get("/api/v1/sessions/1/export?comments=2").status, 422);
  EXPECT_EQ(get("/api/v1/sessions/1/export?format=candump").header("content-type"), "text/plain; charset=utf-8");
  EXPECT_TRUE(session["visit"].is_null()) << "of an unknown patient";
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"note", "went well"}, {"subject", "P-17"}}).json()["note"], "went well");
  const json visit = get("/api/v1/visits").json()["items"].at(0);
  EXPECT_EQ(visit["sessions"], json::array({1}));
  EXPECT_EQ(visit["code"], "P-17");
  const json in_visit{{"id", visit["id"]}, {"patient", visit["patient"]}, {"day", visit["day"]}};
  EXPECT_EQ(get("/api/v1/sessions/1").json()["visit"], in_visit);
  EXPECT_EQ(get("/api/v1/sessions").json()["items"][0]["visit"], in_visit);
  EXPECT_EQ(get("/api/v1/patients").json()["items"].at(0)["id"], visit["patient"]);
  EXPECT_EQ(get("/api/v1/visits?patient=99").json()["items"], json::array());
  for (const char* bad : {"visits?patient=x", "visits?limit=0", "visits?cursor=x", "patients?limit=201"})
    EXPECT_EQ(get(std::string("/api/v1/") + bad).status, 422) << bad;
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"note", 5}}).status, 422);
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"id", 5}}).status, 422);
  EXPECT_EQ(get("/api/v1/sessions?q=P-17").json()["items"].size(), 1U);
  EXPECT_EQ(get("/api/v1/sessions?q=p-1").json()["items"].size(), 1U);
  EXPECT_EQ(get("/api/v1/sessions?q=P-18").json()["items"].size(), 0U);
  const auto sessions_of = [&](const json& patient) { return get("/api/v1/sessions?patient=" + patient.dump()).json()["total"]; };
  EXPECT_EQ(sessions_of(visit["patient"]), 1);
  EXPECT_EQ(sessions_of(call("POST", "/api/v1/patients", {{"code", "P-1"}}).json()["id"]), 0) << "P-17 contains this code";
  EXPECT_EQ(get("/api/v1/sessions?patient=P-1").status, 422);
  EXPECT_EQ(get("/api/v1/sessions?limit=0").status, 422);
  EXPECT_EQ(call("DELETE", "/api/v1/sessions/1").status, 204);
  EXPECT_EQ(get("/api/v1/sessions/1").status, 404);
}

json by_command(const char* name, const std::filesystem::path& database, const char* options = "") {
  const std::string command = std::string(HOIST_BINARY_DIR) + "/bin/hoist " + name + " " + database.string() + " 1" + options;
  return json::parse(test::run_shell(command).output, nullptr, false);
}

// C, J_N and L of this walk are another program's (tests/golden); the other figures are counted here by their definitions.
TEST_F(Record, TheFiguresOfAWalkAreThoseOfTheirDefinitions) {
  std::ifstream file(std::string(HOIST_SOURCE_DIR) + "/tests/golden/evaluate.json");
  const json golden = json::parse(file)["cases"][0];
  const json& in = golden["in"];
  ASSERT_EQ(in["shape"], "eight");
  const std::vector<float> x_m = in["x"], y_m = in["y"], psi_rad = in["psi"], dpsi_rad = in["dpsi"];
  const std::size_t count = x_m.size();
  ASSERT_EQ(call("POST", "/api/v1/lease", json::object()).status, 200);
  const Headers holder{{"X-Hoist-Lease", std::to_string(get("/api/v1/status").json()["lease"]["epoch"].get<int>())}};
  // Stands for a second, then goes forward and back by turns; after the last sample the core goes to standby.
  constexpr std::size_t kStanding = 100;
  core_->set_each([=, walked = std::size_t{0}](contract::TickRecord& r) mutable {
    if (r.mode != static_cast<std::uint8_t>(Mode::user)) return;
    const bool over = walked == count;
    const std::size_t i = over ? count - 1 : walked++;
    if (over) r.mode = static_cast<std::uint8_t>(Mode::standby);
    r.fused_x_m = x_m[i];
    r.fused_y_m = y_m[i];
    r.fused_psi_rad = psi_rad[i];
    r.dpsi_rad = dpsi_rad[i];
    r.distance_m = 0.001F * static_cast<float>(i);
    r.standing_still = over || i < kStanding ? 1 : 0;
    r.speed_m_s = r.standing_still != 0 ? 0.0F : i % 2 == 0 ? 0.5F : -0.25F;
  });
  // Refused until the recorder has seen its first step.
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "start"}}).status == 200; })) << recording();
  const json eight{{"shape", "eight"}, {"c_m", in["c"]}, {"radius_m", in["R"]}};
  ASSERT_EQ(call("POST", "/api/v1/mode", {{"mode", "user"}, {"exercise", eight}}, holder).status, 200);
  core_->skip(count);
  core_->skip(400);
  ASSERT_TRUE(until([&] { return recording()["samples"].get<std::size_t>() > count + 400; })) << "the walk is in it";
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200) << recording();
  json told = get("/api/v1/sessions/1/metrics").json();
  // The same session's figures, each with version, inputs and hash, on the command line and in the export.
  EXPECT_EQ(told, by_command("metrics", folder_ / "hoist.db"));
  EXPECT_EQ(told, get("/api/v1/sessions/1/export?format=json&columns=mode").json()["metrics"]);
  EXPECT_EQ(told["computed"].size(), db::kMetrics.size());
  // So is the advice.
  const json advice = get("/api/v1/sessions/1/tuning-advice").json();
  EXPECT_EQ(advice, by_command("tune-advice", folder_ / "hoist.db", " --json"));
  EXPECT_EQ(advice["items"].size(), 5U) << advice;
  EXPECT_EQ(advice["items"][0]["name"], "lean_dead_band_norm");
  EXPECT_EQ(get("/api/v1/sessions/9/tuning-advice").status, 404);
  told.erase("computed");
  const auto figure = [&told](const char* name) {
    const double value = told[name].is_number() ? told[name].get<double>() : std::nan("");
    told.erase(name);
    return value;
  };
  const json& out = golden["out"];
  const double j_n = out["J"], length_m = out["L"];
  // The recording rounds to 10 um and 10 urad.
  EXPECT_NEAR(figure("C"), out["C"].get<double>(), 1e-4);
  EXPECT_NEAR(figure("J_N"), j_n, 1e-3);
  EXPECT_NEAR(figure("reference_length_m"), length_m, 1e-3);
  // J_N is the sum of all squared deviations over L.
  EXPECT_NEAR(std::pow(figure("rms_position_m"), 2) + std::pow(figure("rms_heading_rad"), 2), j_n * length_m / static_cast<double>(count),
              1e-4);
  const double moving = static_cast<double>(count - kStanding), distance_m = 0.01 * (moving / 2 * 0.5 + moving / 2 * 0.25);
  EXPECT_NEAR(figure("under_way_s"), 0.01 * static_cast<double>(count), 1e-9);
  EXPECT_NEAR(figure("motion_s"), 0.01 * moving, 1e-9);
  EXPECT_NEAR(figure("walked_m"), distance_m, 0.003) << "an odd number of samples";
  EXPECT_NEAR(figure("mean_speed_m_s"), distance_m / (0.01 * moving), 1e-3);
  EXPECT_NEAR(figure("max_speed_m_s"), 0.5, 1e-6);
  EXPECT_EQ(figure("missing_s"), 0);
  // What the other program does not know is held against numpy by tests/system/figures.
  for (const db::MetricInfo& metric : db::kMetrics) told.erase(std::string(metric.key));
  EXPECT_EQ(told, (json{{"session", 1}, {"track", "fused"}, {"exercise", eight}, {"reason_if_none", nullptr}, {"reason_code", nullptr}}));
}

TEST_F(Record, ACoreThatDiesEndsTheSession_AndTheNextOneBegins) {
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  core_->skip(100);
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions/1").json()["samples"] > 100; }));
  const std::size_t before = core_->published().size();
  core_.reset();
  wait_for_core(false);
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
  mode(Mode::user);
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions").json()["total"] == 2; }));
  const json first = get("/api/v1/sessions/1").json();
  EXPECT_EQ(first["close_reason"], "core_restarted");
  EXPECT_LE(first["samples"].get<std::size_t>(), before);
  EXPECT_EQ(recording()["session"], 2);
}

TEST_F(Record, ASkippedStepIsAnExplicitGap) {
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  core_->set([](contract::TickRecord& r) { r.tick += 7; });
  core_->skip(100);
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions/1").json()["gaps"] == 1; }));
  const json gap = get("/api/v1/sessions/1/gaps").json()["items"][0];
  EXPECT_EQ(gap["to_tick"].get<int>() - gap["from_tick"].get<int>(), 6);
  EXPECT_EQ(gap["reason"], "not_received");
  core_->set([](contract::TickRecord& r) {
    r.tick += 4;
    r.missed_ticks += 4;
  });
  core_->skip(100);
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions/1").json()["gaps"] == 2; }));
  EXPECT_EQ(get("/api/v1/sessions/1/gaps").json()["items"][1]["reason"], "step_left_out") << "the core never made them";
}

TEST_F(Record, ByHandOnStandby) {
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "dance"}}).status, 422);
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 409);
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "start"}, {"subject", 5}}).status, 422);
  Answer started;
  // Refused until the recorder has seen its first step.
  ASSERT_TRUE(until([&] {
    started = call("POST", "/api/v1/recording", {{"action", "start"}, {"subject", "P-1"}, {"note", "rest"}});
    return started.status == 200;
  })) << started.body;
  EXPECT_EQ(started.json()["state"], "recording");
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "start"}}).status, 409);
  core_->skip(50);
  // Walking inside it does not end it.
  mode(Mode::user);
  core_->skip(50);
  ASSERT_TRUE(until([&] { return get("/api/v1/mode").json()["mode"] == "user"; }));
  EXPECT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "stop"}}).status == 409; })) << "not while the hoist moves";
  mode(Mode::standby);
  core_->skip(500);
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "stop"}}).status == 200; }));
  const json session = get("/api/v1/sessions/1").json();
  EXPECT_EQ(session["subject"], "P-1");
  EXPECT_EQ(session["recording"], false);
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 1);
}

TEST_F(Record, AMistypedCodeIsRefusedAndNoFailureOfTheRecording) {
  const auto start = [this](const std::string& subject, const std::string& note) {
    return call("POST", "/api/v1/recording", {{"action", "start"}, {"subject", subject}, {"note", note}}).status;
  };
  EXPECT_EQ(start("", ""), 422);
  EXPECT_EQ(start("P-1\nP-2", ""), 422);
  EXPECT_EQ(start("P-1", std::string(5000, 'x')), 422);
  EXPECT_EQ(recording()["state"], "idle") << recording();
  EXPECT_EQ(recording()["detail"], "");
  EXPECT_EQ(recording()["reason_code"], nullptr);
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  EXPECT_EQ(start("", ""), 422);
  EXPECT_EQ(recording()["state"], "recording");
  EXPECT_EQ(recording()["session"], 1) << "what is being recorded does not end for it";
}

TEST_F(Record, ASecondServerDoesNotRecordIntoTheSameFile) {
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  server::Settings settings;
  settings.socket_path = (folder_ / "other.sock").string();
  settings.port = 0;
  settings.web_dir = folder_ / "web";
  settings.db_path = folder_ / "web" / ".." / "hoist.db";  // another name of the same file
  settings.token_file = folder_ / "other-token";
  std::string error;
  {
    server::App second(settings);
    EXPECT_FALSE(second.start(error));
  }
  EXPECT_NE(error.find("another hoist-server (process " + std::to_string(::getpid()) + ") records into"), std::string::npos) << error;
  EXPECT_NE(error.find("--db"), std::string::npos) << error;
  core_->skip(10);
  EXPECT_EQ(recording()["state"], "recording");
  EXPECT_EQ(get("/api/v1/sessions/1").json()["recording"], true) << "the first one's session goes on";
  // Readers are not kept out.
  EXPECT_TRUE(db::Database::attach(folder_ / "hoist.db").ok());
}

TEST_F(Record, AServerThatRestartsKeepsWhatWasSaid) {
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  core_->skip(100);
  ASSERT_TRUE(until([&] { return recording()["durable_tick"].is_number(); }));
  const std::string cookie = log_in();
  stop_server();
  start_server();
  wait_for_core();
  EXPECT_EQ(get("/api/v1/sessions/1").json()["close_reason"], "server_stopped");
  EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Cookie", cookie}}).status, 200) << "nobody has to log in again";
  EXPECT_TRUE(until([&] { return recording()["session"] == 2; })) << "the walk that goes on is recorded on";
}

TEST_F(Record, WithoutADatabaseTherapyGoesOn) {
  stop_server();
  std::filesystem::remove(folder_ / "hoist.db");
  std::filesystem::create_directories(folder_ / "hoist.db" / "in-the-way");
  start_server();
  wait_for_core();
  EXPECT_EQ(get("/api/v1/sessions").status, 503);
  EXPECT_TRUE(wait_state("failed"));
  EXPECT_FALSE(recording()["detail"].get<std::string>().empty());
  EXPECT_EQ(recording()["reason_code"], "storage");
  EXPECT_EQ(call("POST", "/api/v1/neutral", json::object()).status, 200);
}

// H28
TEST_F(Record, WhatIsStoredIsForThisUserOnly) {
  stop_server();
  std::filesystem::permissions(folder_ / "hoist.db", std::filesystem::perms(0644));
  start_server();
  wait_for_core();
  mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  for (const char* name : {"hoist.db", "hoist.db-wal", "hoist.db-shm", "token", "token.sessions", "core.sock"})
    EXPECT_EQ(std::filesystem::status(folder_ / name).permissions(), std::filesystem::perms(0600)) << name;
}

TEST_F(Record, WhyNoCoreIsConnectedIsSaid) {
  EXPECT_EQ(get("/api/v1/status").json()["core"]["problem"], nullptr);
  core_.reset();
  ASSERT_TRUE(until([&] {
    const json problem = get("/api/v1/status").json()["core"]["problem"];
    return problem.is_string() && problem.get<std::string>().find("no core listens on " + (folder_ / "core.sock").string()) == 0;
  }));
}

TEST_F(Record, AFileOfAnotherProgramStaysAsItIsAndTherapyGoesOn) {
  stop_server();
  for (const char* suffix : {"", "-wal", "-shm", ".seal"}) std::filesystem::remove((folder_ / "hoist.db").string() + suffix);
  const std::string letter = "Dear colleague,\n" + std::string(5000, 'x');
  std::ofstream(folder_ / "hoist.db") << letter;
  start_server();
  wait_for_core();
  ASSERT_TRUE(wait_state("failed"));
  const json notices = get("/api/v1/status").json()["notices"];
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0]["name"], "recordings_foreign");
  EXPECT_NE(notices[0]["detail"].get<std::string>().find("hoist.db is no database and stays as it is"), std::string::npos) << notices;
  EXPECT_EQ(get("/api/v1/sessions").status, 503);
  EXPECT_EQ(call("POST", "/api/v1/neutral", json::object()).status, 200);
  std::ifstream stream(folder_ / "hoist.db", std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), letter);
  // Its place is free again.
  std::filesystem::remove(folder_ / "hoist.db");
  ASSERT_TRUE(wait_state("idle"));
  EXPECT_TRUE(get("/api/v1/status").json()["notices"].empty());
}

TEST_F(Record, ADamagedDatabaseIsToldUntilItsFileIsTakenAway) {
  stop_server();
  std::filesystem::resize_file(folder_ / "hoist.db", 5000);
  for (int start = 0; start < 2; ++start) {
    start_server();
    wait_for_core();
    ASSERT_TRUE(until([&] { return !get("/api/v1/status").json()["notices"].empty(); })) << "start " << start;
    const json notice = get("/api/v1/status").json()["notices"][0];
    EXPECT_EQ(notice["name"], "recordings_set_aside");
    EXPECT_NE(notice["detail"].get<std::string>().find("hoist.db.corrupt-"), std::string::npos);
    EXPECT_EQ(recording()["state"], "idle") << "a new one takes its place";
    stop_server();
  }
}

// The recorder alone, on virtual time and a core in the same process: a server that dies is a recorder that is dropped.
class TakeOver : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kLife_ns = 5'000'000'000;
  void SetUp() override {
    std::string error;
    core_ = publish::CoreLink::create("", kLife_ns, static_cast<std::uint64_t>(kUtc_ns), error);
    ASSERT_NE(core_, nullptr) << error;
    record_.time_ns = kLife_ns;
    record_.simulated = 1;
    publish(10, Mode::standby);
  }
  void TearDown() override { die(); }
  // Steps of the core, each with one frame on the bus; the server looks after every second one.
  void publish(std::size_t count, Mode mode) {
    for (std::size_t i = 0; i < count; ++i) {
      ++record_.tick;
      record_.time_ns += 10'000'000;
      const std::uint8_t before = record_.mode;
      record_.mode = static_cast<std::uint8_t>(mode);
      core_->publish_tick(record_);
      if (before != record_.mode) event(contract::EventKind::mode_changed, record_.mode, before);
      contract::BusRecord frame;
      frame.time_ns = record_.time_ns;
      frame.id = 0x181;
      frame.dlc = 8;
      frame.data = record_.tick;
      core_->publish_bus(frame);
      if (recorder_ && record_.tick % 2 == 0) recorder_->pass_here();
    }
  }
  void event(contract::EventKind kind, std::uint32_t code = 0, std::uint32_t item = 0) {
    contract::Event event;
    event.kind = kind;
    event.code = code;
    event.item = item;
    event.tick = record_.tick;
    event.time_ns = record_.time_ns;
    core_->publish_event(event);
  }
  void live() {
    link_ = std::make_unique<publish::ServerLink>("");
    server::Recorder::Options options;
    options.file = folder_ / "hoist.db";
    options.version = "test";
    options.utc_ns = [this] { return kUtc_ns + clock_set_ns_ + static_cast<std::int64_t>(record_.time_ns - kLife_ns); };
    options.steady_ns = [this] { return record_.time_ns; };
    options.log = [](const std::string&) {};
    options.vfs = vfs_;
    recorder_ = std::make_unique<server::Recorder>(*link_, std::move(options));
    recorder_->open_here();
    std::string error;
    ASSERT_TRUE(link_->attach_directly(*core_, error)) << error;
    contract::ParamsInForce parameters;
    parameters.version = 1;
    recorder_->set_parameters(parameters);
    recorder_->pass_here();
  }
  void die() {
    recorder_.reset();
    link_.reset();
  }
  // The core ends and another one takes its place, whose steps happen to go on with higher numbers.
  void next_core() {
    std::string error;
    core_ = publish::CoreLink::create("", kLife_ns + 1, static_cast<std::uint64_t>(kUtc_ns), error);
    ASSERT_NE(core_, nullptr) << error;
    ASSERT_TRUE(link_->attach_directly(*core_, error)) << error;
  }
  // A walk of an exercise whose server dies in the middle of it. The newest step that is stored.
  void walk_and_die() {
    live();
    recorder_->set_exercise(kSquare);
    publish(300, Mode::user);
    ASSERT_EQ(recorder_->status().state, server::RecordingState::recording);
    die();
    publish(121, Mode::user);
  }
  struct Session {
    db::SessionInfo info;
    std::vector<std::uint64_t> ticks, frames;
    std::vector<std::uint8_t> gap_before;
    std::vector<db::Gap> gaps;
    std::size_t events = 0;
    std::vector<std::uint64_t> alarms;
    std::string csv, json;
  };
  Session session(db::SessionId id) {
    Session out;
    auto database = db::Database::attach(folder_ / "hoist.db", {.vfs = vfs_});
    if (!database) {
      ADD_FAILURE() << database.error().message;
      return out;
    }
    const db::SessionReader reader(*database);
    const auto info = reader.get(id);
    if (!info) {
      ADD_FAILURE() << info.error().message;
      return out;
    }
    out.info = *info;
    const auto columns = reader.read_columns(id, std::vector<std::string>{"mode"});
    out.ticks = columns->tick;
    out.gap_before = columns->gap_before;
    out.gaps = *reader.gaps(id);
    const auto events = reader.events(id);
    out.events = events->size();
    for (const db::StoredEvent& event : *events)
      if (event.kind_name == contract::event_name(contract::EventKind::fault_raised)) out.alarms.push_back(event.tick);
    const auto frames = reader.bus_frames(id, 0, 100000);
    for (const contract::BusRecord& frame : *frames) out.frames.push_back(frame.data);
    for (const auto format : {db::ExportFormat::csv, db::ExportFormat::json}) {
      auto exported = db::SessionExport::open(*database, id, {.format = format, .columns = {"tick"}, .comments = false});
      std::string piece;
      while (*exported->next_chunk(piece)) (format == db::ExportFormat::csv ? out.csv : out.json) += piece;
    }
    return out;
  }
  std::uint64_t sessions() { return db::SessionReader(*db::Database::attach(folder_ / "hoist.db", {.vfs = vfs_})).list()->total; }

  static constexpr std::int64_t kUtc_ns = 1'790'000'000'000'000'000;
  static constexpr const char* kSquare = R"({"shape": "square", "side_m": 3.2})";
  // A job of the recorder's thread, done at its next pass.
  db::Status job(const std::function<db::Status(server::Records&)>& work) {
    db::Status status;
    EXPECT_TRUE(recorder_->run([&](server::Records& records) { status = work(records); }));
    recorder_->pass_here();
    return status;
  }

  test::TemporaryFolder folder_;
  std::optional<tests::CrashDisk> disk_;  // outlives the connections, which TearDown closes
  const char* vfs_ = nullptr;
  std::unique_ptr<publish::CoreLink> core_;
  std::unique_ptr<publish::ServerLink> link_;
  std::unique_ptr<server::Recorder> recorder_;
  contract::TickRecord record_{};
  std::int64_t clock_set_ns_ = 0;  // by which the wall clock was set
};

TEST_F(TakeOver, WhatTheFirstCoreSaidBeforeAnySessionEntersNoneOfTheNextCore) {
  live();
  publish(300, Mode::standby);
  event(contract::EventKind::fault_raised, 3);
  publish(10, Mode::standby);
  record_.tick = 0;  // counts its steps anew
  next_core();
  publish(20, Mode::standby);
  publish(100, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 1U);
  EXPECT_TRUE(session(1).alarms.empty());
  EXPECT_EQ(session(1).events, 2U) << "begin and end of the walk";
}

// On a busy computer the file may take longer to open than a person to press a button: what waited is done before the next step comes.
TEST_F(TakeOver, ARecordingByHandNeedNotWaitForTheNextStep) {
  live();
  EXPECT_TRUE(job([](server::Records& records) { return records.begin_manual("P-018", ""); }).ok());
  publish(50, Mode::standby);
  EXPECT_TRUE(job([](server::Records& records) { return records.end_manual(); }).ok());
  const Session first = session(1);
  EXPECT_EQ(first.info.subject, "P-018");
  EXPECT_GE(first.ticks.size(), 48U);
}

// H21
TEST_F(TakeOver, AServerThatComesBackSoonRecordsWhatTheDeadOneMissed) {
  walk_and_die();
  live();
  publish(50, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 2U);
  const Session first = session(1), second = session(2);
  EXPECT_EQ(first.info.close_reason, "interrupted");
  EXPECT_EQ(second.info.close_reason, "finished");
  ASSERT_FALSE(first.ticks.empty());
  ASSERT_FALSE(second.ticks.empty());
  EXPECT_EQ(second.ticks.front(), first.ticks.back() + 1) << "from where the dead server broke off";
  EXPECT_EQ(second.info.gap_count, 0U);
  EXPECT_EQ(second.info.exercise_json, kSquare);
  EXPECT_EQ(second.info.started_utc_ns, kUtc_ns + static_cast<std::int64_t>(first.ticks.back() + 1) * 10'000'000) << "when it was walked";
  EXPECT_EQ(first.events, 1U);
  EXPECT_EQ(second.events, 1U) << "its end; the begin belongs to the first";
  ASSERT_FALSE(second.frames.empty());
  EXPECT_EQ(second.frames.front(), first.frames.back() + 1) << "no frame twice, none missing";
}

// H21
// In lock-step the core's time is that of its newest step, not of the step from the past with which the session begins.
TEST_F(TakeOver, InLockStepTooAWalkThatIsTakenOverIsDatedWhenItWasWalked) {
  std::string error;
  core_ = publish::CoreLink::create("", kLife_ns, static_cast<std::uint64_t>(kUtc_ns), error, contract::ClockKind::simulated);
  ASSERT_NE(core_, nullptr) << error;
  walk_and_die();
  publish(600, Mode::user);
  live();
  publish(400, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 2U);
  const Session second = session(2);
  EXPECT_EQ(second.info.started_utc_ns, kUtc_ns + static_cast<std::int64_t>(second.ticks.front()) * 10'000'000);
  auto database = db::Database::attach(folder_ / "hoist.db");
  EXPECT_EQ(db::number_of(database->handle(), "SELECT count(*) FROM utc_anchors WHERE session_id = 2"), 0) << "the clock was not set";
}

TEST_F(TakeOver, WhatTheCoreNoLongerHoldsIsAGapAtTheBegin) {
  walk_and_die();
  publish(3000, Mode::user);
  const std::uint64_t held = record_.tick - contract::kTickSlots;
  live();
  publish(50, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 2U);
  const Session first = session(1), second = session(2);
  ASSERT_FALSE(second.ticks.empty());
  EXPECT_EQ(second.ticks.front(), held + 1);
  ASSERT_EQ(second.gaps.size(), 1U) << "frames and events are all there";
  EXPECT_EQ(second.gaps[0].stream, "ticks");
  EXPECT_EQ(second.gaps[0].from_tick, first.ticks.back() + 1);
  EXPECT_EQ(second.gaps[0].to_tick, held);
  EXPECT_EQ(second.gaps[0].reason, "server_absent");
  EXPECT_EQ(second.gap_before[0], 1);
  EXPECT_EQ(second.gap_before[1], 0);
  EXPECT_EQ(second.info.exercise_json, kSquare);
  EXPECT_NE(second.json.find("server_absent"), std::string::npos);
  EXPECT_NE(second.json.find("\"gap_before\":[1,0"), std::string::npos) << second.json.substr(0, 2000);
  const std::string row = second.csv.substr(second.csv.find('\n') + 1);
  EXPECT_NE(row.substr(0, row.find('\n')).find(",1," + std::to_string(held + 1)), std::string::npos) << row.substr(0, 100);
}

TEST_F(TakeOver, StepsTheCoreLeftOutMeanwhileAreCalledSo) {
  live();
  publish(300, Mode::user);
  die();
  record_.tick += 7;
  record_.missed_ticks += 7;
  publish(20, Mode::user);
  live();
  publish(60, Mode::user);
  die();
  const Session second = session(2);
  // The newest of the first session were not stored: the core holds them, only its own steps are missing.
  ASSERT_EQ(second.gaps.size(), 1U);
  EXPECT_EQ(second.gaps[0].reason, "step_left_out");
  EXPECT_EQ(second.gaps[0].to_tick - second.gaps[0].from_tick, 6U);
}

// H21
TEST_F(TakeOver, AWalkThatEndedWhileNobodyRecordedIsRecordedToItsEnd) {
  walk_and_die();
  publish(500, Mode::standby);
  live();
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle);
  ASSERT_EQ(sessions(), 2U);
  const Session first = session(1), second = session(2);
  EXPECT_EQ(second.ticks.front(), first.ticks.back() + 1);
  EXPECT_EQ(second.info.close_reason, "finished");
  EXPECT_EQ(second.info.exercise_json, kSquare);
}

// H21
TEST_F(TakeOver, HoweverOftenItDiesEveryStepIsInOneSessionOrInAGap) {
  std::mt19937 random(21);
  constexpr int kDeaths = 25;
  std::vector<std::uint64_t> made, alarms;
  const auto walk = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (random() % 200 == 0) {
        record_.tick += 3;
        record_.missed_ticks += 3;
      }
      publish(1, Mode::user);
      made.push_back(record_.tick);
      if (random() % 20 != 0) continue;
      event(contract::EventKind::fault_raised);
      alarms.push_back(record_.tick);
    }
  };
  for (int death = 0; death < kDeaths; ++death) {
    live();
    walk(1 + random() % 400);
    die();
    walk(random() % (death % 5 == 4 ? 4000 : 300));
  }
  live();
  walk(100);
  publish(400, Mode::standby);
  std::vector<std::uint64_t> ticks, frames, noted, told;
  const std::uint64_t count = sessions();
  EXPECT_GT(count, 10U);
  for (std::uint64_t id = 1; id <= count; ++id) {
    const Session one = session(static_cast<db::SessionId>(id));
    ticks.insert(ticks.end(), one.ticks.begin(), one.ticks.end());
    frames.insert(frames.end(), one.frames.begin(), one.frames.end());
    told.insert(told.end(), one.alarms.begin(), one.alarms.end());
    for (const db::Gap& gap : one.gaps) {
      EXPECT_TRUE(gap.reason == "step_left_out" || gap.reason.starts_with("server_absent")) << gap.reason;
      if (gap.stream == "ticks")
        for (std::uint64_t tick = gap.from_tick; tick <= gap.to_tick; ++tick) noted.push_back(tick);
    }
  }
  EXPECT_EQ(std::ranges::adjacent_find(ticks, std::greater_equal<>{}), ticks.end()) << "time rises from session to session, nothing twice";
  EXPECT_EQ(std::ranges::adjacent_find(frames, std::greater_equal<>{}), frames.end());
  EXPECT_EQ(std::ranges::adjacent_find(noted, std::greater_equal<>{}), noted.end());
  EXPECT_EQ(std::ranges::find_first_of(ticks, noted), ticks.end()) << "what is there is not called missing";
  EXPECT_EQ(told, alarms) << "each once, also those of lost steps";
  ticks.insert(ticks.end(), noted.begin(), noted.end());
  std::ranges::sort(ticks);
  for (const std::uint64_t tick : made) {
    ASSERT_TRUE(std::ranges::binary_search(ticks, tick)) << "step " << tick << " is nowhere";
    ASSERT_TRUE(std::ranges::binary_search(frames, tick)) << "its frame, which the core still held, is not";
  }
}

// H24
TEST_F(TakeOver, AWalkThatBeginsOnADiskThatRefusesSaysWhatIsMissing) {
  tests::CrashDisk& disk = disk_.emplace(8);
  vfs_ = tests::CrashDisk::vfs_name();
  live();
  recorder_->set_exercise(kSquare);
  disk.fail(1);
  const std::uint64_t from = record_.tick + 1;
  publish(880, Mode::user);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::failed);
  disk.fail(0);
  publish(300, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 1U);
  const Session one = session(1);
  ASSERT_FALSE(one.ticks.empty());
  ASSERT_GT(one.ticks.front(), from + 800);
  ASSERT_EQ(one.gaps.size(), 2U);
  for (const db::Gap& gap : one.gaps) {
    EXPECT_EQ(gap.stream, &gap == &one.gaps[0] ? "ticks" : "bus");
    EXPECT_EQ(gap.from_tick, from);
    EXPECT_EQ(gap.to_tick, one.ticks.front() - 1);
    EXPECT_EQ(gap.reason, "storage");
  }
  EXPECT_EQ(one.events, 2U) << "its beginning, which was kept, and its end";
  auto database = db::Database::attach(folder_ / "hoist.db", {.vfs = vfs_});
  const auto metrics = db::session_metrics(*database, 1);
  ASSERT_TRUE(metrics.ok());
  EXPECT_NEAR(*(*metrics)["missing_s"].value, static_cast<double>(one.ticks.front() - from) * 0.01, 1e-9);
  EXPECT_FALSE((*metrics)["J_N"].value.has_value());
  EXPECT_EQ(metrics->why_absent, db::NoFigure::part_missing);
}

// H21
TEST_F(TakeOver, AServerThatFindsTheHoistWalkingRecordsFromTheBeginOfTheWalk) {
  for (const std::size_t before : {std::size_t{500}, std::size_t{3000}}) {
    const std::uint64_t from = record_.tick + 1;
    publish(before, Mode::user);
    const std::uint64_t held = std::max(from, record_.tick + 1 - std::min<std::uint64_t>(record_.tick, contract::kTickSlots));
    live();
    publish(50, Mode::user);
    publish(400, Mode::standby);
    const Session one = session(static_cast<db::SessionId>(sessions()));
    ASSERT_FALSE(one.ticks.empty());
    EXPECT_EQ(one.ticks.front(), held);
    EXPECT_EQ(one.events, held == from ? 2U : 1U);
    EXPECT_EQ(one.frames.front(), held) << "with the frames of its first step";
    EXPECT_EQ(one.gaps.empty(), held == from) << "what the core no longer holds is missing, and said to be";
    for (const db::Gap& gap : one.gaps) {
      EXPECT_EQ(gap.from_tick, from);
      EXPECT_EQ(gap.to_tick, held - 1);
      EXPECT_EQ(gap.reason, "server_absent");
    }
    die();
  }
}

TEST_F(TakeOver, WhatIsRecordedAlreadyIsNotRecordedAgain) {
  live();
  publish(300, Mode::user);
  publish(400, Mode::standby);
  EXPECT_EQ(sessions(), 1U);
  EXPECT_EQ(session(1).info.close_reason, "finished");
  die();
  live();
  publish(50, Mode::standby);
  EXPECT_EQ(sessions(), 1U) << "the core still holds that walk";
  publish(50, Mode::user);
  EXPECT_EQ(session(2).ticks.front(), 761U);
  EXPECT_FALSE(session(2).info.exercise_json.has_value());
}

// A server that was stopped for so long that the ring of frames was overwritten: the gap is where they are missing, not
// where it resumed.
TEST_F(TakeOver, AGapOfTheBusStandsWhereItIs) {
  live();
  publish(300, Mode::user);
  const std::uint64_t before = record_.tick;
  auto halted = std::move(recorder_);
  constexpr std::size_t kTicks = 1700, kPerTick = 15, kKept = contract::kBusSlots / kPerTick;
  for (std::size_t i = 0; i < kTicks; ++i) {
    publish(1, Mode::user);
    for (std::size_t k = 1; k < kPerTick; ++k) {
      contract::BusRecord frame;
      frame.time_ns = record_.time_ns;
      frame.data = record_.tick;
      core_->publish_bus(frame);
    }
  }
  event(contract::EventKind::fault_raised);
  recorder_ = std::move(halted);
  publish(100, Mode::user);
  publish(400, Mode::standby);
  const Session one = session(1);
  ASSERT_EQ(one.gaps.size(), 1U) << "no step is missing";
  EXPECT_EQ(one.gaps[0].stream, "bus");
  EXPECT_EQ(one.gaps[0].reason, "recorder_late");
  EXPECT_EQ(one.gaps[0].from_tick, before);
  EXPECT_NEAR(static_cast<double>(one.gaps[0].to_tick), static_cast<double>(before + kTicks - kKept), 2.0);
}

TEST_F(TakeOver, AGapOfTheEventsStandsWhereItIs) {
  live();
  publish(300, Mode::user);
  const std::uint64_t before = record_.tick;
  auto halted = std::move(recorder_);
  for (std::size_t i = 0; i < 2 * contract::kEventSlots; ++i) {
    if (i % 10 == 0) publish(1, Mode::user);
    event(contract::EventKind::fault_raised);
  }
  const std::uint64_t first_held = record_.tick - contract::kEventSlots / 10;
  publish(200, Mode::user);
  recorder_ = std::move(halted);
  publish(100, Mode::user);
  publish(400, Mode::standby);
  const Session one = session(1);
  ASSERT_EQ(one.gaps.size(), 1U);
  EXPECT_EQ(one.gaps[0].stream, "events");
  EXPECT_LE(one.gaps[0].from_tick, before);
  EXPECT_NEAR(static_cast<double>(one.gaps[0].to_tick), static_cast<double>(first_held), 2.0);
}

// A disk that refuses for a while, in memory.
class RefusingDisk : public TakeOver {
 protected:
  RefusingDisk() { vfs_ = tests::CrashDisk::vfs_name(); }
  tests::CrashDisk disk_{1};
};

TEST_F(RefusingDisk, AMarkerThatWasRefusedIsNotStoredLater) {
  live();
  publish(300, Mode::user);
  const db::SessionId id = recorder_->status().session.value_or(0);
  const auto mark = [&](const char* text) {
    return job([&](server::Records& records) { return records.marker(id, {.text = text}, std::nullopt); });
  };
  EXPECT_TRUE(mark("before"));
  disk_.fail(1.0);
  EXPECT_FALSE(mark("refused"));
  publish(100, Mode::user);
  disk_.fail(0);
  publish(100, Mode::user);
  EXPECT_TRUE(mark("after"));
  publish(400, Mode::standby);
  auto database = db::Database::attach(folder_ / "hoist.db", {.vfs = vfs_});
  ASSERT_TRUE(database.ok());
  std::vector<std::string> texts;
  const auto markers = db::SessionReader(*database).markers(id);
  for (const db::Marker& marker : *markers) texts.push_back(marker.text);
  EXPECT_EQ(texts, (std::vector<std::string>{"before", "after"}));
}

TEST_F(RefusingDisk, NothingOfTheNextCoreEntersTheSessionOfTheFirst) {
  live();
  publish(300, Mode::user);
  const std::uint64_t until = record_.tick;
  disk_.fail(1.0);
  next_core();
  publish(100, Mode::user);
  publish(400, Mode::standby);
  publish(200, Mode::user);
  disk_.fail(0);
  publish(300, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 3U) << "the new core holds its two walks until the disk takes them";
  const Session first = session(1), second = session(2), third = session(3);
  EXPECT_EQ(first.info.close_reason, "core_restarted");
  EXPECT_EQ(first.ticks.back(), until);
  EXPECT_EQ(first.frames.back(), until);
  for (const Session* one : {&second, &third}) EXPECT_EQ(one->info.core_start_time_ns, kLife_ns + 1);
  EXPECT_EQ(second.ticks.front(), until + 1);
  EXPECT_EQ(third.ticks.front(), until + 501);
  for (const Session* one : {&first, &second, &third}) EXPECT_TRUE(one->gaps.empty());
}

// The end of a session that is decided fixes its last step, however late the disk takes it.
TEST_F(RefusingDisk, AWalkThatBeginsWhileTheLastOnesEndIsRefusedIsItsOwnSession) {
  live();
  recorder_->set_subject("P-1");
  publish(300, Mode::user);
  publish(100, Mode::standby);
  disk_.fail(1.0);
  publish(300, Mode::standby);
  const std::uint64_t operations = disk_.operations();
  publish(400, Mode::standby);
  EXPECT_LT(disk_.operations() - operations, 100U) << "its end is tried with each commit, not with each step";
  const std::uint64_t walk = record_.tick + 1;
  publish(200, Mode::user);
  disk_.fail(0);
  publish(100, Mode::user);
  publish(310, Mode::standby);
  ASSERT_EQ(sessions(), 2U);
  const Session first = session(1), between = session(2), second = session(3);
  for (const Session* one : {&first, &between, &second}) ASSERT_FALSE(one->ticks.empty());
  EXPECT_EQ(first.info.close_reason, "finished");
  EXPECT_NEAR(static_cast<double>(first.ticks.size()), 600, 2) << "300 in motion and 3 s of roll-out";
  EXPECT_TRUE(between.info.standby);
  EXPECT_EQ(between.ticks.front(), first.ticks.back() + 1);
  EXPECT_EQ(second.ticks.front(), walk);
  EXPECT_EQ(second.frames.front(), walk);
  EXPECT_EQ(second.events, 2U);
  for (const Session* one : {&first, &between, &second}) {
    EXPECT_TRUE(one->gaps.empty());
    EXPECT_EQ(one->info.subject, "P-1");
  }
}

// H24: never into another patient's records.
TEST_F(RefusingDisk, WhatWaitsIsNotTheNextPatients) {
  live();
  recorder_->set_subject("P-1");
  publish(300, Mode::user);
  disk_.fail(1.0);
  publish(500, Mode::standby);
  publish(300, Mode::user);
  publish(100, Mode::standby);
  recorder_->set_subject("P-2");
  const std::uint64_t chosen = record_.tick;
  publish(100, Mode::standby);
  publish(50, Mode::user);
  disk_.fail(0);
  publish(300, Mode::user);
  publish(310, Mode::standby);
  ASSERT_EQ(sessions(), 2U);
  const Session first = session(1), between = session(2), second = session(3);
  for (const Session* one : {&first, &between, &second}) ASSERT_FALSE(one->ticks.empty());
  EXPECT_EQ(first.info.subject, "P-1");
  EXPECT_NEAR(static_cast<double>(first.ticks.size()), 600, 2);
  EXPECT_EQ(second.info.subject, "P-2");
  EXPECT_TRUE(between.info.standby);
  EXPECT_EQ(between.info.subject, "P-2");
  EXPECT_GT(between.ticks.front(), chosen);
  EXPECT_TRUE(second.gaps.empty());
}

// The core's ring was overwritten while no session was open.
TEST_F(TakeOver, AWalkThatBeginsWhileTheRecorderStallsSaysWhatIsMissing) {
  live();
  publish(50, Mode::standby);
  auto halted = std::move(recorder_);
  publish(500, Mode::standby);
  const std::uint64_t from = record_.tick + 1;
  publish(contract::kTickSlots + 500, Mode::user);
  recorder_ = std::move(halted);
  publish(100, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 1U);
  const Session one = session(1);
  ASSERT_EQ(one.gaps.size(), 2U);
  for (const db::Gap& gap : one.gaps) {
    EXPECT_EQ(gap.reason, "recorder_late");
    EXPECT_EQ(gap.from_tick, from);
    EXPECT_EQ(gap.to_tick, one.ticks.front() - 1);
  }
  EXPECT_EQ(one.events, 2U) << "its begin, which the core still held, and its end";
}

// H24: when the disk was freed says nothing about the session.
TEST_F(RefusingDisk, ASessionWhoseEndWasRefusedEndsAtItsLastStep) {
  live();
  publish(300, Mode::user);
  disk_.fail(1.0);
  publish(1000, Mode::standby);
  disk_.fail(0);
  publish(200, Mode::standby);
  const Session one = session(1);
  ASSERT_NEAR(static_cast<double>(one.ticks.size()), 600, 2);
  EXPECT_EQ(one.info.ended_utc_ns, kUtc_ns + static_cast<std::int64_t>(one.ticks.back()) * 10'000'000);
}

TEST_F(RefusingDisk, ARecordingByHandThatWasRefusedEndsNoSession) {
  live();
  publish(300, Mode::user);
  publish(50, Mode::standby);
  disk_.fail(1.0);
  EXPECT_FALSE(job([](server::Records& records) { return records.begin_manual(std::nullopt, ""); }));
  disk_.fail(0);
  publish(100, Mode::standby);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::recording) << "its roll-out is still being recorded";
  EXPECT_EQ(recorder_->status().session, 1);
  publish(400, Mode::standby);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle);
}

// What the core publishes waits in its rings for some 20 s only: a long session must not hold the recorder's thread when it ends.
TEST_F(RefusingDisk, ALongRecordingThatEndsIsFoldedBetweenThePassesThatRecord) {
  live();
  ASSERT_TRUE(job([](server::Records& records) { return records.begin_manual(std::nullopt, ""); }));
  publish(12'000, Mode::standby);
  auto reading = db::Database::attach(folder_ / "hoist.db", {.vfs = vfs_});
  const auto count = [&](const char* what) { return db::number_of(reading->handle(), what); };
  const char* const kChunks = "SELECT count(*) FROM chunks WHERE session_id = 1";
  ASSERT_TRUE(job([](server::Records& records) { return records.end_manual(); }));
  std::int64_t before = count(kChunks);
  EXPECT_GE(before, 120) << "nothing is folded when it ends";
  constexpr std::int64_t kPiece = db::kFoldedChunkSamples / db::kLiveChunkSamples;
  for (int i = 0; i < 40; ++i) {
    publish(2, Mode::user);
    const std::int64_t now = count(kChunks);
    EXPECT_LT(before - now, kPiece) << "pass " << i;
    before = now;
  }
  EXPECT_LT(before, 2 * kPiece) << "it is being folded";
  EXPECT_EQ(recorder_->status().session, 2) << "while the next walk is recorded";
  // The end of the server does not wait for the rest, and the next one goes on with it.
  const std::int64_t left = before;
  recorder_->finish_here();
  EXPECT_LT(left - count(kChunks), kPiece);
  EXPECT_EQ(count("SELECT folded FROM sessions WHERE id = 2"), 0);
  die();
  live();
  publish(100, Mode::standby);
  EXPECT_EQ(count("SELECT min(folded) FROM sessions WHERE ended_utc_ns IS NOT NULL"), 1);
  EXPECT_GE(session(1).ticks.size(), 12'000U);
  EXPECT_EQ(session(1).gaps.size() + session(2).gaps.size(), 0U);
}

// Decision 274
TEST_F(TakeOver, ACoreThatDiesInMotionEndsItsSessionWithItsLastStep) {
  live();
  publish(300, Mode::user);
  const std::uint64_t last_ns = record_.time_ns;
  const auto pass_after = [&](double seconds) {
    record_.time_ns = last_ns + static_cast<std::uint64_t>(seconds * 1e9);
    recorder_->pass_here();
    return recorder_->status().state;
  };
  EXPECT_EQ(pass_after(server::kAfterStop_s + 30), server::RecordingState::recording) << "a silent core may go on";
  recorder_->set_attached(false);
  EXPECT_EQ(pass_after(server::kAfterStop_s - 0.01), server::RecordingState::recording) << "it may attach again";
  EXPECT_EQ(job([](server::Records& records) { return records.end_manual(); }).error().kind, db::ErrorKind::wrong_state);
  ASSERT_EQ(pass_after(server::kAfterStop_s), server::RecordingState::idle);
  const Session one = session(1);
  EXPECT_EQ(one.info.close_reason, "core_restarted");
  EXPECT_EQ(one.info.ended_utc_ns, kUtc_ns + static_cast<std::int64_t>(last_ns - kLife_ns));
  EXPECT_EQ(one.ticks.size(), 300U);
  EXPECT_EQ(job([](server::Records& records) { return records.begin_manual(std::nullopt, ""); }).error().kind, db::ErrorKind::wrong_state)
      << "there is nothing to record";
  recorder_->set_attached(true);
  publish(100, Mode::user);
  EXPECT_EQ(recorder_->status().session, 2);
}

TEST_F(TakeOver, AFileFoundDamagedIsLeftAfterTheSessionUnderWay) {
  live();
  publish(300, Mode::user);
  ASSERT_EQ(recorder_->status().session, 1);
  const std::string id = db::Database::attach(folder_ / "hoist.db")->file_id();
  recorder_->set_aside("0123456789abcdef", "of a file that was replaced");
  publish(400, Mode::standby);
  EXPECT_EQ(sessions(), 1U) << "it is another file's damage";
  publish(300, Mode::user);
  recorder_->set_aside(id, "page 7 is damaged");
  publish(300, Mode::user);
  EXPECT_EQ(recorder_->status().session, 2) << "the walk goes on being recorded";
  EXPECT_EQ(recorder_->status().state, server::RecordingState::recording);
  publish(400, Mode::standby);
  const server::RecordingStatus status = recorder_->status();
  EXPECT_EQ(status.state, server::RecordingState::idle) << status.detail;
  ASSERT_EQ(status.notices.size(), 1U);
  EXPECT_EQ(status.notices[0].name, server::NoticeName::recordings_set_aside);
  EXPECT_EQ(sessions(), 0U) << "a new file";
  EXPECT_EQ(db::SessionReader(*db::Database::attach(status.notices[0].detail)).list()->total, 2U) << "nothing was lost of the old one";
  publish(300, Mode::user);
  EXPECT_EQ(recorder_->status().session, 3) << "a number is never given again";
}

// Standby with a patient chosen, the walk and standby again: three sessions of one visit, each step in one of them, and only the walk counts.
TEST_F(TakeOver, StandbyIsRecordedWhileAPatientIsChosen) {
  live();
  publish(300, Mode::standby);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle) << "nobody is chosen";
  recorder_->set_subject("P-1");
  publish(300, Mode::standby);
  EXPECT_EQ(recorder_->status().session, 1);
  EXPECT_TRUE(recorder_->status().standby);
  event(contract::EventKind::fault_raised);  // of the newest step before the walk
  EXPECT_EQ(job([](server::Records& records) { return records.end_manual(); }).error().kind, db::ErrorKind::wrong_state);
  publish(200, Mode::user);
  EXPECT_EQ(recorder_->status().session, 2);
  EXPECT_FALSE(recorder_->status().standby);
  publish(700, Mode::standby);
  EXPECT_EQ(recorder_->status().session, 3) << "3 s after the walk";
  recorder_->set_subject(std::nullopt);
  publish(2, Mode::standby);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle);
  EXPECT_EQ(sessions(), 1U) << "walks";
  const Session before = session(1), walk = session(2), after = session(3);
  for (const Session* one : {&before, &after}) {
    EXPECT_TRUE(one->info.standby);
    EXPECT_FALSE(one->info.exercise_json);
  }
  EXPECT_FALSE(walk.info.standby);
  EXPECT_NEAR(static_cast<double>(walk.ticks.size()), 500, 2) << "200 in motion and 3 s of roll-out";
  EXPECT_EQ(walk.ticks.front(), before.ticks.back() + 1);
  EXPECT_EQ(after.ticks.front(), walk.ticks.back() + 1);
  EXPECT_EQ(walk.frames.front(), before.frames.back() + 1) << "no frame twice, none missing";
  EXPECT_EQ(after.frames.front(), walk.frames.back() + 1);
  EXPECT_EQ(before.alarms, std::vector<std::uint64_t>{before.ticks.back()});
  EXPECT_EQ(walk.events, 2U) << "its begin and its end";
  for (const Session* one : {&before, &walk, &after}) {
    EXPECT_EQ(one->gaps.size(), 0U);
    EXPECT_EQ(one->info.subject, "P-1");
    EXPECT_EQ(one->info.close_reason, "finished");
  }
}

TEST_F(TakeOver, StandbySessionsAreBoundedAndOfOnePatientEach) {
  live();
  recorder_->set_subject("P-1");
  publish(200, Mode::calibrate);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle) << "the harness is empty";
  publish(200, Mode::standby);
  EXPECT_EQ(recorder_->status().session, 1);
  recorder_->set_subject("P-2");
  publish(200, Mode::standby);
  EXPECT_EQ(recorder_->status().session, 2);
  record_.time_ns += static_cast<std::uint64_t>(server::kStandbySession_s * 1e9) - 1'000'000'000;
  publish(200, Mode::standby);
  EXPECT_EQ(recorder_->status().session, 3) << "the next one follows";
  EXPECT_LE(session(2).info.duration_s, server::kStandbySession_s);
  publish(100, Mode::calibrate);
  EXPECT_EQ(recorder_->status().state, server::RecordingState::idle);
  EXPECT_EQ(session(1).info.subject, "P-1");
  EXPECT_EQ(session(2).info.subject, "P-2");
  EXPECT_EQ(sessions(), 0U) << "nobody has walked";
}

TEST_F(TakeOver, ADamagedFileIsLeftAtOnceInStandby) {
  live();
  recorder_->set_subject("P-1");
  publish(300, Mode::standby);
  ASSERT_EQ(recorder_->status().session, 1);
  recorder_->set_aside(db::Database::attach(folder_ / "hoist.db")->file_id(), "page 7 is damaged");
  publish(300, Mode::standby);
  ASSERT_EQ(recorder_->status().notices.size(), 1U);
  EXPECT_EQ(recorder_->status().session, 2) << "of the new file, after the old one's";
  EXPECT_TRUE(recorder_->status().standby);
  auto old = db::Database::attach(recorder_->status().notices[0].detail);
  EXPECT_EQ(db::SessionReader(*old).get(1)->close_reason, "finished");
}

// The wall clock may be set at any time: lengths and order come from the steady clock and from the numbers.
TEST_F(TakeOver, AClockThatIsSetChangesNoLengthAndNoOrder) {
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  live();
  recorder_->set_subject("P-1");
  publish(300, Mode::user);
  clock_set_ns_ = 3'600'000'000'000;
  publish(300, Mode::user);
  clock_set_ns_ = -kDay_ns;
  publish(300, Mode::user);
  recorder_->set_subject(std::nullopt);
  publish(400, Mode::standby);
  publish(300, Mode::user);
  publish(400, Mode::standby);
  const Session first = session(1), second = session(2);
  EXPECT_EQ(first.info.started_utc_ns, kUtc_ns + 110'000'000) << "as the clock said when it began";
  EXPECT_NEAR(first.info.duration_s, 12.0, 0.02) << "9 s in motion and 3 s of roll-out";
  EXPECT_EQ(first.gaps.size(), 0U);
  EXPECT_LT(second.info.started_utc_ns, first.info.started_utc_ns) << "the day before, by the clock of that moment";
  auto database = db::Database::attach(folder_ / "hoist.db");
  const auto newest = db::SessionReader(*database).list({.limit = 1, .before = {}, .subject = {}});
  ASSERT_EQ(newest->sessions.size(), 1U);
  EXPECT_EQ(newest->sessions[0].id, 2) << "the one that was recorded last";
  EXPECT_EQ(db::SessionReader(*database).list({.limit = 1, .before = newest->next, .subject = {}})->sessions.at(0).id, 1);
  const auto visit = db::VisitReader(*database).visits()->items.at(0);
  const auto started_s = static_cast<std::time_t>(first.info.started_utc_ns / 1'000'000'000);
  char day[11];
  std::strftime(day, sizeof day, "%F", std::localtime(&started_s));
  EXPECT_EQ(visit.visit.day, day) << "the day on which it began";
  EXPECT_EQ(visit.sessions, (std::vector<db::SessionId>{1}));
  // Each jump is in the record, at its moment of the steady clock.
  std::vector<std::int64_t> jumps_s;
  sqlite3_stmt* row = nullptr;
  sqlite3_prepare_v2(database->handle(), "SELECT utc_ns - time_ns FROM utc_anchors WHERE session_id = 1 ORDER BY time_ns", -1, &row,
                     nullptr);
  const std::int64_t offset_ns = kUtc_ns - static_cast<std::int64_t>(kLife_ns);
  while (sqlite3_step(row) == SQLITE_ROW) jumps_s.push_back((sqlite3_column_int64(row, 0) - offset_ns) / 1'000'000'000);
  sqlite3_finalize(row);
  EXPECT_EQ(jumps_s, (std::vector<std::int64_t>{3600, -86400}));
}

// A whole export is kept for further parts: on the disk, without a name.
TEST_F(TakeOver, AWholeExportGoesAfterItsLastUseAndWithItsSession) {
  live();
  publish(100, Mode::user);
  publish(400, Mode::standby);
  ASSERT_EQ(sessions(), 1U);
  const auto make = [this] {
    server::ExportId id = 0;
    ASSERT_TRUE(job([&id](server::Records& records) -> db::Status {
      const auto opened = records.open_export(1, {.format = db::ExportFormat::mcap});
      if (opened) id = opened->id;
      return opened ? db::Status() : opened.error();
    }));
    for (bool whole = false; !whole;)
      ASSERT_TRUE(job([id, &whole](server::Records& records) -> db::Status {
        const auto file = records.export_file(id);
        if (!file) return file.error();
        whole = *file != nullptr;
        return {};
      }));
  };
  const auto on_disk = [this] {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
      std::error_code gone;
      const std::string target = std::filesystem::read_symlink(entry.path(), gone).string();
      if (target.starts_with(folder_.path().string() + "/") && target.ends_with(" (deleted)")) ++count;
    }
    return count;
  };
  const auto pass_after = [this](std::uint64_t wait_ns) {
    record_.time_ns += wait_ns;
    recorder_->pass_here();
  };
  constexpr std::uint64_t kKept_ns = 600'000'000'000;
  make();
  pass_after(kKept_ns);
  EXPECT_EQ(on_disk(), 1U);
  pass_after(1);
  EXPECT_EQ(on_disk(), 0U);
  make();
  EXPECT_EQ(on_disk(), 1U);
  ASSERT_TRUE(db::SessionEditor(*db::Database::attach(folder_ / "hoist.db")).remove(1));
  pass_after(0);
  EXPECT_EQ(on_disk(), 0U);
}

TEST_F(TakeOver, AJobThatWaitedTooLongIsToldSo) {
  live();
  const auto late_after = [this](std::uint64_t wait_ns) {
    bool late = false;
    EXPECT_TRUE(recorder_->run([&late](server::Records& records) { late = records.late(); }));
    record_.time_ns += wait_ns;
    recorder_->pass_here();
    return late;
  };
  EXPECT_FALSE(late_after(server::kJobWait_ns));
  EXPECT_TRUE(late_after(server::kJobWait_ns + 1));
}

}  // namespace
}  // namespace hoist::test
