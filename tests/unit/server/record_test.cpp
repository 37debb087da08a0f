// The recording as people get it: what the core published is what the export says, whatever happened in between.
#include <sstream>

#include "db/store/database.hpp"
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
  const json events = get("/api/v1/sessions/1/events").json();
  EXPECT_EQ(events["markers"][0]["text"], "=1+1 looks, good");
  const json samples = get("/api/v1/sessions/1/samples?columns=x_m,mode&points=10").json();
  EXPECT_EQ(samples["columns"][0]["name"], "x_m");
  EXPECT_LE(samples["from_s"].size(), 10U);
  for (const char* bad : {"", "?columns=", "?columns=nothing", "?columns=x_m&points=0", "?columns=x_m&points=1e9", "?columns=x_m&from_s=x",
                          "?columns=x_m&from_s=nan"})
    EXPECT_EQ(get(std::string("/api/v1/sessions/1/samples") + bad).status, 422) << bad;
  EXPECT_EQ(get("/api/v1/sessions/1/metrics").status, 200);
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"note", "went well"}, {"subject", "P-17"}}).json()["note"], "went well");
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"note", 5}}).status, 422);
  EXPECT_EQ(call("PATCH", "/api/v1/sessions/1", {{"id", 5}}).status, 422);
  EXPECT_EQ(get("/api/v1/sessions?q=P-17").json()["items"].size(), 1U);
  EXPECT_EQ(get("/api/v1/sessions?q=P-18").json()["items"].size(), 0U);
  EXPECT_EQ(get("/api/v1/sessions?limit=0").status, 422);
  EXPECT_EQ(call("DELETE", "/api/v1/sessions/1").status, 204);
  EXPECT_EQ(get("/api/v1/sessions/1").status, 404);
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
  const json gap = get("/api/v1/sessions/1/events").json()["gaps"][0];
  EXPECT_EQ(gap["to_tick"].get<int>() - gap["from_tick"].get<int>(), 6);
  EXPECT_EQ(gap["reason"], "not_received");
  core_->set([](contract::TickRecord& r) {
    r.tick += 4;
    r.missed_ticks += 4;
  });
  core_->skip(100);
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions/1").json()["gaps"] == 2; }));
  EXPECT_EQ(get("/api/v1/sessions/1/events").json()["gaps"][1]["reason"], "step_left_out") << "the core never made them";
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
  // Whoever only reads is not kept out.
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
  EXPECT_EQ(call("POST", "/api/v1/neutral", json::object()).status, 200);
}

}  // namespace
}  // namespace hoist::test
