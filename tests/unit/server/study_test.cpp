// The job `study`: a process of its own, what of it comes among the recordings, and when it may not run. A script stands in for `hoist study`.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <unistd.h>

#include <fstream>

#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "db/store/studies.hpp"
#include "server/jobs/child.hpp"
#include "server/jobs/jobs.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using server::JobKind;

const json kReport = [] {
  const json column = {0.5, nullptr}, columns = json::array({column});
  const json test{{"pairs", 0}, {"up", 0}, {"down", 0}, {"mean_first", 0.0}, {"mean_second", 0.0}, {"p", nullptr}};
  return json{{"title", "Of two runs"},
              {"virtual_subjects", true},
              {"subjects", 2},
              {"seed", 4},
              {"preset", "walk"},
              {"laps", 2.0},
              {"runs", {{{"run", 3}, {"shape", "eight"}, {"led_by", "patient"}, {"injured", false}}}},
              {"tables",
               {{{"figure", "C"},
                 {"decimals", 2},
                 {"subjects", {"S01", "S02"}},
                 {"own", columns},
                 {"paper", columns},
                 {"own_mean", {0.5}},
                 {"paper_mean", {0.87}}}}},
              {"compared", {{{"figure", "C"}, {"from", 2}, {"to", 3}, {"decimals", 2}, {"own", test}, {"paper", test}}}},
              {"others", {{{"figure", "C_best"}, {"means", {0.6}}}}},
              {"findings", {{"c_square", nullptr}, {"c_led", 0.5}, {"j_ratio", nullptr}}},
              {"assumed", nullptr},
              {"left_out", {{{"subject", "S02"}, {"run", 3}, {"figure", "C"}, {"reason_code", "part_missing"}, {"laps", nullptr}}}}};
}();

// A file as `hoist study --out` leaves it: one study with two sessions.
void make_study(const std::filesystem::path& file) {
  auto database = db::Database::open(file);
  ASSERT_TRUE(database.ok());
  const auto study = db::begin_study(*database, 5);
  auto writer = db::SessionWriter::create(*database);
  ASSERT_TRUE(writer.ok());
  for (int i = 0; i < 2; ++i) {
    const std::vector<double> parameters(contract::kParams.size(), 0.25);
    db::SessionStart start;
    start.started_utc_ns = 1'790'000'000'000'000'000 + i;
    start.start_time_ns = 1;
    start.simulated = true;
    start.software_version = "study";
    start.note = "run 3";
    start.parameter_values = parameters;
    const auto session = writer->begin(start);
    ASSERT_TRUE(session.ok());
    std::vector<contract::TickRecord> records(3200);
    for (std::size_t k = 0; k < records.size(); ++k) {
      records[k].tick = k;
      records[k].time_ns = 1 + k * 10'000'000;
      records[k].x_m = static_cast<float>(k) * 1e-3F;
    }
    ASSERT_TRUE(writer->append_ticks(records).ok());
    ASSERT_TRUE(writer->end(db::CloseReason::finished, 1'790'000'000'000'000'000).ok());
    ASSERT_TRUE(db::mark_run(*database, *session, {.study = *study, .subject = "S0" + std::to_string(i + 1), .run = 3}).ok());
  }
  ASSERT_TRUE(db::finish_study(*database, *study, kReport.dump(), {{"figure-2", "<svg/>"}}).ok());
}

std::string stat_of(const std::string& pid) {
  std::ifstream file("/proc/" + pid + "/stat");
  std::string number, name, state;
  file >> number >> name >> state;
  return state;
}

class StudyJob : public ServerTest {
 protected:
  StudyJob() {
    adjust_ = [this](server::Settings& settings) { settings.study_program = folder_ / "hoist"; };
    make_study(folder_ / "made.db");
    script("cp " + (folder_ / "made.db").string() + " \"$out\"");
  }
  // What the program does, with `$out` as it was asked for; its process number is in the file "pid", its arguments in "arguments".
  void script(const std::string& does) {
    const std::filesystem::path file = folder_ / "hoist", folder = folder_.path();
    std::ofstream(file) << "#!/bin/sh\necho \"$@\" > " << (folder / "arguments").string() << "\necho $$ > " << (folder / "pid").string()
                        << "\nwhile [ $# -gt 0 ]; do [ \"$1\" = --out ] && out=$2; shift; done\necho progress 1 2\n"
                        << does << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  std::string line_of(const char* name) {
    std::ifstream file(folder_ / name);
    std::string line;
    std::getline(file, line);
    return line;
  }
  std::string start() {
    const Answer started = call("POST", "/api/v1/jobs", {{"kind", "study"}, {"subjects", 2}, {"seed", 4}});
    EXPECT_EQ(started.status, 202) << started.body;
    return started.header("location");
  }
  json ended(const std::string& place) {
    json info;
    EXPECT_TRUE(until([&] {
      info = get(place).json();
      return info["ended_utc_ms"] != nullptr;
    }));
    return info;
  }
  void mode(contract::Mode mode) {
    core_->set([mode](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(mode); });
  }
  std::size_t workshops() {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      count += entry.path().string().find(".study-") != std::string::npos ? 1 : 0;
    return count;
  }
};

TEST_F(StudyJob, ItsSessionsTablesAndDrawingsComeAmongTheRecordings) {
  const json info = ended(start());
  ASSERT_EQ(info["state"], "done") << info;
  EXPECT_EQ(info["result"]["study"], 1);
  EXPECT_NE(line_of("arguments").find("study --subjects 2 --seed 4 --begin-utc-ms "), std::string::npos) << line_of("arguments");
  const json list = get("/api/v1/studies").json()["items"];
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["seed"], 4);
  EXPECT_EQ(list[0]["sessions"], 2);
  const json study = get("/api/v1/studies/1").json();
  EXPECT_EQ(study["report"], kReport);
  EXPECT_EQ(study["sessions"], (json{{{"session", 1}, {"subject", "S01"}, {"run", 3}}, {{"session", 2}, {"subject", "S02"}, {"run", 3}}}));
  const Answer drawing = get("/api/v1/studies/1/drawings/figure-2");
  EXPECT_EQ(drawing.header("content-type"), "image/svg+xml");
  EXPECT_EQ(drawing.body, "<svg/>");
  for (const char* none : {"/api/v1/studies/2", "/api/v1/studies/x", "/api/v1/studies/1/drawings/figure-9"})
    EXPECT_EQ(get(none).status, 404) << none;
  // Marked on the list of sessions, whole, and of no patient.
  const json sessions = get("/api/v1/sessions").json()["items"];
  ASSERT_EQ(sessions.size(), 2U);
  EXPECT_EQ(sessions[0]["study"], (json{{"study", 1}, {"subject", "S02"}, {"run", 3}}));
  EXPECT_EQ(sessions[0]["samples"], 3200);
  EXPECT_TRUE(sessions[0]["simulated"] && sessions[0]["subject"].is_null() && sessions[0]["visit"].is_null());
  EXPECT_EQ(get("/api/v1/patients").json()["items"], json::array());
  const json samples = get("/api/v1/sessions/2/samples?columns=x_m&points=1").json();
  EXPECT_NEAR(samples.dump().empty() ? 0 : samples["columns"][0]["max"][0].get<double>(), 3.199, 1e-9);
  EXPECT_NE(get("/api/v1/sessions/2/export?format=csv").body.find("0.25"), std::string::npos) << "with its settings";
  EXPECT_EQ(workshops(), 0U);
}

// Sessions of people, evaluated where they are.
TEST_F(StudyJob, RecordedSessionsAreEvaluatedAndStay) {
  ASSERT_EQ(ended(start())["state"], "done");
  json report = kReport;
  report["virtual_subjects"] = false;
  report["seed"] = nullptr;
  std::ofstream(folder_ / "report.json") << report;
  script("while [ -n \"$all\" ]; do break; done; set -- $(cat " + (folder_ / "arguments").string() +
         "); while [ $# -gt 0 ]; do [ \"$1\" = --json ] && j=$2; [ \"$1\" = --figures ] && f=$2; shift; done; cp " +
         (folder_ / "report.json").string() + " $j; mkdir -p $f; echo '<svg/>' > $f/figure-8.svg");
  const json info = ended(call("POST", "/api/v1/jobs", {{"kind", "study_recorded"}}).header("location"));
  ASSERT_EQ(info["state"], "done") << info;
  EXPECT_NE(line_of("arguments").find("--sessions 1,2 "), std::string::npos) << line_of("arguments");
  const json study = get("/api/v1/studies/2").json();
  EXPECT_EQ(study["report"], report);
  EXPECT_EQ(study["drawings"], json::array({"figure-8"}));
  EXPECT_EQ(ended(call("POST", "/api/v1/jobs", {{"kind", "delete_study"}, {"study", 2}}).header("location"))["result"]["sessions"], 0);
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 2) << "they are nobody's to delete with it";

  const json none = ended(call("POST", "/api/v1/jobs", {{"kind", "study_recorded"}, {"subject", "P-9"}}).header("location"));
  EXPECT_EQ(none["reason_code"], "none_fits");
  script("echo 'hoist study: no session has a patient'; exit 1");
  EXPECT_EQ(ended(call("POST", "/api/v1/jobs", {{"kind", "study_recorded"}}).header("location"))["reason_code"], "none_fits");
}

TEST_F(StudyJob, StudiesAreListedInPagesNewestFirst) {
  for (int i = 0; i < 3; ++i) ASSERT_EQ(ended(start())["state"], "done");
  const json first = get("/api/v1/studies?limit=2").json();
  ASSERT_EQ(first["items"].size(), 2U);
  EXPECT_EQ(first["items"][0]["id"], 3);
  const json second = get("/api/v1/studies?limit=2&cursor=" + first["next"].get<std::string>()).json();
  ASSERT_EQ(second["items"].size(), 1U);
  EXPECT_EQ(second["items"][0]["id"], 1);
  EXPECT_TRUE(second["next"].is_null());
}

TEST_F(StudyJob, AStudyIsDeletedWithItsSessions) {
  ASSERT_EQ(ended(start())["state"], "done");
  EXPECT_EQ(ended(call("POST", "/api/v1/jobs", {{"kind", "delete_study"}, {"study", 7}}).header("location"))["reason_code"], "unknown");
  const json gone = ended(call("POST", "/api/v1/jobs", {{"kind", "delete_study"}, {"study", 1}}).header("location"));
  EXPECT_EQ(gone["result"]["sessions"], 2) << gone;
  EXPECT_EQ(get("/api/v1/studies").json()["items"], json::array());
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 0);
}

TEST_F(StudyJob, OneAtATimeAndNotWhileTheHoistMoves) {
  script("exec sleep 60");
  const std::string place = start();
  ASSERT_TRUE(until([&] { return !line_of("pid").empty() && get(place).json()["progress"] > 0.4; })) << "half of two runs";
  EXPECT_EQ(call("POST", "/api/v1/jobs", {{"kind", "study"}, {"subjects", 1}, {"seed", 1}}).json()["type"], "/problems/study-runs");
  EXPECT_EQ(call("DELETE", place).status, 202);
  EXPECT_EQ(ended(place)["state"], "cancelled");
  EXPECT_EQ(stat_of(line_of("pid")), "") << "its process has ended with it";
  EXPECT_EQ(workshops(), 0U);
  mode(contract::Mode::user);
  ASSERT_TRUE(until([&] { return get("/api/v1/status").json()["core"]["mode"] == "user"; }));
  const Answer moving = call("POST", "/api/v1/jobs", {{"kind", "study"}, {"subjects", 1}, {"seed", 1}});
  EXPECT_EQ(moving.status, 409);
  EXPECT_EQ(moving.json()["type"], "/problems/moving");
}

// A patient who begins to walk has the processor: the virtual ones stand still meanwhile.
TEST_F(StudyJob, ItRestsWhileTheHoistMoves) {
  script("exec sleep 60");
  const std::string place = start();
  ASSERT_TRUE(until([&] { return !line_of("pid").empty() && stat_of(line_of("pid")) == "S"; }));
  mode(contract::Mode::user);
  EXPECT_TRUE(until([&] { return stat_of(line_of("pid")) == "T"; }));
  mode(contract::Mode::standby);
  EXPECT_TRUE(until([&] { return stat_of(line_of("pid")) == "S"; }));
  call("DELETE", place);
  EXPECT_EQ(ended(place)["state"], "cancelled");
}

// A deletion truncates the log at once; the study reads nothing then, and does not begin again from its start.
TEST_F(StudyJob, ADeletionDoesNotBeginItAgain) {
  const json first = ended(start());
  ASSERT_EQ(first["state"], "done") << first;
  script("while [ ! -e " + (folder_ / "go").string() + " ]; do sleep 0.05; done; cp " + (folder_ / "made.db").string() + " \"$out\"");
  std::filesystem::remove(folder_ / "pid");
  const std::string place = start();
  ASSERT_TRUE(until([&] { return !line_of("pid").empty(); }));
  const std::string pid = line_of("pid");
  EXPECT_EQ(call("DELETE", "/api/v1/sessions/1").status, 204);
  std::ofstream(folder_ / "go") << "go";
  EXPECT_EQ(ended(place)["state"], "done");
  EXPECT_EQ(line_of("pid"), pid);
}

TEST_F(StudyJob, AProgramThatFailsLeavesNothing) {
  script("echo 'hoist study: the disk is gone' >&2; exit 1");
  json info = ended(start());
  EXPECT_EQ(info["state"], "failed");
  EXPECT_EQ(info["detail"], "hoist study: the disk is gone");
  EXPECT_EQ(info["reason_code"], "internal");
  script("kill -9 $$");
  EXPECT_EQ(ended(start())["detail"], "the study ended with 137");
  std::filesystem::remove(folder_ / "hoist");
  EXPECT_EQ(ended(start())["state"], "failed");
  EXPECT_EQ(get("/api/v1/studies").json()["items"], json::array());
  EXPECT_EQ(workshops(), 0U);
}

// A server that was killed while the sessions were put in leaves a study that no list tells: the next one takes it away.
TEST_F(StudyJob, AnUnfinishedStudyIsTakenBack) {
  stop_server();
  {
    auto database = db::Database::open(db_path_);
    const auto study = db::begin_study(*database, 5);
    ASSERT_TRUE(db::take_run(*database, folder_ / "made.db", 1, {.study = *study, .subject = "S09", .run = 1}).ok());
    EXPECT_FALSE(db::take_run(*database, folder_ / "made.db", 99, {.study = *study, .subject = "S09", .run = 1}).ok());
  }
  start_server();
  wait_for_core();
  EXPECT_EQ(get("/api/v1/studies").json()["items"], json::array());
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 1);
  ASSERT_EQ(ended(start())["state"], "done");
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 2) << "those of the whole study only";
}

TEST(Child, GivesLinesAsTheyComeAndInheritsNothing) {
  const int secret = ::open("/dev/null", O_RDONLY);  // without close-on-exec
  auto child = server::Child::start({"/bin/sh", "-c", "echo one; echo two >&2; ls /proc/self/fd | wc -l; printf rest"});
  ASSERT_TRUE(child.ok());
  std::vector<std::string> lines;
  while (!child->ended())
    while (const auto line = child->line(1000)) lines.push_back(*line);
  EXPECT_EQ(child->exit_code(), 0);
  // In, out, error and the folder that ls reads.
  EXPECT_EQ(lines, (std::vector<std::string>{"one", "two", "4", "rest"}));
  EXPECT_FALSE(server::Child::start({"/no/such/program"}).ok());
  ::close(secret);
}

}  // namespace
}  // namespace hoist::test
