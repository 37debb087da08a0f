// Long work: its queue on a thread of its own, what may be asked of it and by whom, and the check of the file that a start does not wait for.
#include "server/jobs/jobs.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using server::JobId;
using server::JobInfo;
using server::JobKind;
using server::Jobs;
using server::JobState;

constexpr std::int64_t kPage_bytes = 4096;

// A file with one session of some MB, as a server that was stopped leaves it.
void record_into(const std::filesystem::path& file, std::size_t ticks) {
  auto database = db::Database::open(file);
  ASSERT_TRUE(database.ok());
  auto writer = db::SessionWriter::create(*database);
  ASSERT_TRUE(writer.ok());
  db::SessionStart start;
  start.started_utc_ns = 1'790'000'000'000'000'000;
  start.start_time_ns = 1;
  ASSERT_TRUE(writer->begin(start).ok());
  std::vector<contract::TickRecord> records(ticks);
  for (std::size_t i = 0; i < ticks; ++i) {
    records[i].tick = i;
    records[i].time_ns = 1 + i * 10'000'000;
    // Noise, so that the samples fill many pages.
    records[i].left_alpha_rad = static_cast<float>((i * 7919U) % 1000) * 1e-4F;
    records[i].x_m = static_cast<float>((i * 104729U) % 100000) * 1e-3F;
  }
  ASSERT_TRUE(writer->append_ticks(records).ok());
  ASSERT_TRUE(writer->end(db::CloseReason::finished, start.started_utc_ns).ok());
}

// Overwrites a page that neither opening nor the begin of a session reads.
void damage_page(const std::filesystem::path& file) {
  std::int64_t page = 0;
  {
    auto database = db::Database::attach(file);
    ASSERT_TRUE(database.ok());
    sqlite3_stmt* root = nullptr;
    sqlite3_prepare_v2(database->handle(), "SELECT rootpage FROM sqlite_schema WHERE name = 'markers'", -1, &root, nullptr);
    ASSERT_EQ(sqlite3_step(root), SQLITE_ROW);
    page = sqlite3_column_int64(root, 0);
    sqlite3_finalize(root);
  }
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  stream.seekp((page - 1) * kPage_bytes);
  stream << std::string(kPage_bytes, '\x5A');
}

class Queue : public ::testing::Test {
 protected:
  void SetUp() override { record_into(folder_ / "hoist.db", 500); }
  Jobs::Options options() {
    return {.tools = {.file = folder_ / "hoist.db", .utc_ns = [] { return std::int64_t{5'000'000}; }},
            .on_damage = [this](const db::IntegrityReport& report) { damage_ = report.structure.front(); },
            .on_step =
                [this](const JobInfo& info) {
                  if (on_step_) on_step_(info);
                }};
  }
  TemporaryFolder folder_;
  std::function<void(const JobInfo&)> on_step_;
  std::string damage_;
};

TEST_F(Queue, JobsRunInTheirOrderAndTooManyAreRefused) {
  Jobs jobs(options());
  std::vector<JobId> ids;
  for (std::size_t i = 0; i < server::kJobsWaiting; ++i) ids.push_back(jobs.add(JobKind::recompute_metrics, {}, {}).value_or(0));
  EXPECT_FALSE(jobs.add(JobKind::recompute_metrics, {}, {}));
  // One that waits is cancelled at once, and its place is free.
  EXPECT_TRUE(jobs.cancel(ids[1]));
  EXPECT_EQ(jobs.find(ids[1])->state, JobState::cancelled);
  EXPECT_FALSE(jobs.cancel(ids[1])) << "once only";
  EXPECT_FALSE(jobs.cancel(999));
  EXPECT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  std::vector<JobId> order;
  on_step_ = [&](const JobInfo& info) {
    EXPECT_EQ(info.state, JobState::running);
    if (order.empty() || order.back() != info.id) order.push_back(info.id);
  };
  while (jobs.work_here()) {
  }
  EXPECT_EQ(order, (std::vector<JobId>{1, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(jobs.find(9)->state, JobState::done);
  EXPECT_EQ(json::parse(*jobs.find(9)->result)["sound"], true);
  EXPECT_EQ(json::parse(*jobs.find(1)->result)["items"].size(), 1U);
  EXPECT_EQ(jobs.file_health().state, server::FileState::sound);
  EXPECT_EQ(jobs.file_health().checked_utc_ms, 5);
  // What has ended is forgotten in time.
  for (std::size_t i = 0; i < server::kJobsKept; ++i) {
    ASSERT_TRUE(jobs.add(JobKind::recompute_metrics, {.sessions = {77}}, {}));
    jobs.work_here();
  }
  EXPECT_EQ(jobs.list().size(), server::kJobsKept);
  EXPECT_FALSE(jobs.find(9));
  const json unknown = json::parse(*jobs.list().back().result);
  EXPECT_EQ(unknown["failed"][0]["session"], 77) << "a session that is not there fails by itself";
}

// Not the oldest job goes first, but the one that ended first: a long one is still known when it ends at last.
TEST_F(Queue, WhatHasJustEndedIsNotForgotten) {
  Jobs jobs(options());
  const JobId runs = jobs.add(JobKind::recompute_metrics, {}, {}).value_or(0),
              waits = jobs.add(JobKind::recompute_metrics, {}, {}).value_or(0);
  on_step_ = [&](const JobInfo&) {
    for (std::size_t i = 0; i < server::kJobsKept; ++i) EXPECT_TRUE(jobs.cancel(jobs.add(JobKind::integrity_check, {}, {}).value_or(0)));
    EXPECT_TRUE(jobs.cancel(waits));
    EXPECT_EQ(jobs.find(waits).value_or(JobInfo{}).state, JobState::cancelled);
  };
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(jobs.find(runs).value_or(JobInfo{}).state, JobState::done);
  EXPECT_EQ(jobs.list().size(), server::kJobsKept);
}

TEST_F(Queue, ARunningJobEndsWhenItIsCancelledOrTheServerEnds) {
  Jobs jobs(options());
  ASSERT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  int steps = 0;
  on_step_ = [&](const JobInfo& info) {
    if (++steps == 3) {
      EXPECT_TRUE(jobs.cancel(info.id));
    }
  };
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(steps, 3) << "not a page more";
  EXPECT_EQ(jobs.find(1)->state, JobState::cancelled);
  EXPECT_EQ(jobs.file_health().state, server::FileState::unchecked) << "half a check says nothing";
  ASSERT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  on_step_ = [&](const JobInfo&) { jobs.stop(); };
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(jobs.find(2)->state, JobState::cancelled);
  EXPECT_FALSE(jobs.add(JobKind::integrity_check, {}, {})) << "the server ends";
}

// The deleted data are out of the log when the deletion is answered, although a check was reading.
TEST_F(Queue, AJobGivesWayToADeletionAndBeginsAnew) {
  Jobs jobs(options());
  ASSERT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  std::shared_ptr<void> held;
  int steps = 0;
  on_step_ = [&](const JobInfo&) {
    if (++steps == 3) held = jobs.hold();
  };
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(steps, 3);
  EXPECT_EQ(jobs.find(1)->state, JobState::waiting);
  EXPECT_FALSE(jobs.work_here()) << "while it is held";
  {
    auto database = db::Database::attach(folder_ / "hoist.db");
    ASSERT_TRUE(db::SessionEditor(*database).remove(1));
    EXPECT_EQ(std::filesystem::file_size(folder_ / "hoist.db-wal"), 0U);
  }
  held.reset();
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(jobs.find(1)->state, JobState::done);
}

// What an export has read before a session was deleted may hold it, also when it looks only after the deletion.
TEST_F(Queue, AnExportThatADeletionOvertakesBeginsAnew) {
  Jobs jobs(options());
  for (const JobKind kind : {JobKind::export_sessions, JobKind::recompute_metrics}) {
    const JobId id = *jobs.add(kind, {}, {});
    bool deleted = false;
    on_step_ = [&](const JobInfo& info) {
      if (std::exchange(deleted, true) || info.id != id) return;
      const auto held = jobs.hold();
      jobs.forget_recordings();
    };
    EXPECT_TRUE(jobs.work_here());
    EXPECT_EQ(jobs.find(id)->state, JobState::waiting);
    EXPECT_TRUE(jobs.work_here());
    EXPECT_EQ(jobs.find(id)->state, JobState::done);
  }
}

TEST_F(Queue, WhatRetentionDeletesIsInNoEarlierExport) {
  const std::filesystem::path file = folder_ / "hoist.db";
  record_into(file, 100);
  constexpr std::int64_t kDay_ns = 86'400'000'000'000, kNow_ns = 1'790'000'000'000'000'000;
  {
    auto database = db::Database::attach(file);
    sqlite3_exec(database->handle(),
                 ("UPDATE sessions SET started_utc_ns = " + std::to_string(kNow_ns - 90 * kDay_ns) + " WHERE id = 1").c_str(), nullptr,
                 nullptr, nullptr);
    ASSERT_TRUE(db::set_retention_rule(*database, {.days = 365, .disk_percent = {}, .needs_backup = false}));
  }
  Jobs::Options at_work = options();
  at_work.tools.utc_ns = [] { return kNow_ns; };
  Jobs jobs(at_work);
  for (const JobKind kind : {JobKind::export_sessions, JobKind::recompute_metrics, JobKind::retention}) ASSERT_TRUE(jobs.add(kind, {}, {}));
  while (jobs.work_here()) continue;
  EXPECT_NE(jobs.find(1)->file, nullptr) << "nothing was old enough";
  EXPECT_NE(jobs.find(2)->result, nullptr);
  ASSERT_TRUE(db::set_retention_rule(*db::Database::attach(file), {.days = 60, .disk_percent = {}, .needs_backup = false}));
  ASSERT_TRUE(jobs.add(JobKind::retention, {}, {}));
  while (jobs.work_here()) continue;
  EXPECT_EQ(json::parse(*jobs.find(4)->result)["sessions"], 1);
  EXPECT_EQ(jobs.find(1)->file, nullptr);
  EXPECT_EQ(jobs.find(2)->result, nullptr);
}

// Of an older schema, as a recorder leaves it that could not bring it up to date: no session is being recorded that a job would wait for.
TEST_F(Queue, AFileThatIsNotSetUpIsAFaultOfTheStorage) {
  sqlite3* file = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "hoist.db").c_str(), &file), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(file, "PRAGMA user_version = 1", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(file);
  Jobs jobs(options());
  ASSERT_TRUE(jobs.add(JobKind::recompute_metrics, {}, {}));
  jobs.work_here();
  EXPECT_EQ(jobs.find(1)->state, JobState::failed);
  EXPECT_EQ(jobs.find(1)->reason, server::Reason::storage);
  EXPECT_FALSE(jobs.find(1)->detail.empty());
}

TEST_F(Queue, AJobThatThrowsFailsAndTheNextOneRuns) {
  Jobs jobs(options());
  ASSERT_TRUE(jobs.add(JobKind::recompute_metrics, {}, {}));
  ASSERT_TRUE(jobs.add(JobKind::recompute_metrics, {}, {}));
  on_step_ = [](const JobInfo& info) {
    if (info.id == 1) throw std::runtime_error("the folder cannot be read");
  };
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(jobs.find(1)->state, JobState::failed);
  EXPECT_EQ(jobs.find(1)->reason, server::Reason::internal);
  EXPECT_EQ(jobs.find(1)->detail, "the job broke off: the folder cannot be read");
  EXPECT_TRUE(jobs.work_here());
  EXPECT_EQ(jobs.find(2)->state, JobState::done);
}

TEST_F(Queue, DamagedPagesAreToldToTheRecorder) {
  damage_page(folder_ / "hoist.db");
  Jobs jobs(options());
  ASSERT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  jobs.work_here();
  EXPECT_EQ(jobs.find(1)->state, JobState::done) << jobs.find(1)->detail;
  EXPECT_EQ(jobs.file_health().state, server::FileState::damaged);
  EXPECT_FALSE(damage_.empty());
  // A file that cannot be opened was not checked.
  std::filesystem::remove(folder_ / "hoist.db");
  ASSERT_TRUE(jobs.add(JobKind::integrity_check, {}, {}));
  jobs.work_here();
  EXPECT_EQ(jobs.find(2)->state, JobState::failed);
  EXPECT_FALSE(jobs.find(2)->detail.empty());
  EXPECT_EQ(jobs.file_health().state, server::FileState::unchecked);
}

// Where a backup may go is the server's matter, not the client's: links and ".." lead nowhere else.
TEST_F(Queue, ABackupGoesIntoAnAllowedFolderOnly) {
  namespace fs = std::filesystem;
  const fs::path stick = folder_ / "stick", home = folder_ / "home";
  for (const fs::path& made : {stick, stick / "ward", home}) fs::create_directory(made);
  fs::create_directory_symlink(home, stick / "out");
  Jobs::Options with = options();
  with.tools.backup_roots = {stick};
  with.tools.device = "ward 3";
  with.tools.other_databases = {folder_ / "accounts.db", folder_ / "none.db"};
  with.tools.identity_key = folder_ / "identity.key";
  std::ofstream(with.tools.identity_key) << "secret";
  sqlite3* accounts = nullptr;
  ASSERT_EQ(sqlite3_open((folder_ / "accounts.db").c_str(), &accounts), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(accounts, "PRAGMA journal_mode = WAL; CREATE TABLE users (name TEXT); INSERT INTO users VALUES ('eva')", nullptr,
                         nullptr, nullptr),
            SQLITE_OK);
  Jobs jobs(with);
  const auto run = [&](JobKind kind, server::JobArguments arguments) {
    const JobId id = jobs.add(kind, std::move(arguments), {}).value_or(0);
    jobs.work_here();
    return *jobs.find(id);
  };
  for (const fs::path& folder : {home, stick / "out", stick / ".." / "home", fs::path("stick"), fs::path("/"), folder_ / "stickier"}) {
    const JobInfo refused = run(JobKind::backup, {.folder = folder});
    EXPECT_EQ(refused.state, JobState::failed) << folder;
    EXPECT_EQ(refused.reason, server::Reason::invalid) << folder;
  }
  EXPECT_EQ(run(JobKind::backup, {.folder = stick / "gone"}).reason, server::Reason::unknown);
  EXPECT_TRUE(fs::is_empty(home));
  const JobInfo done = run(JobKind::backup, {.folder = stick / "ward"});
  ASSERT_EQ(done.state, JobState::done) << done.detail;
  const json told = json::parse(*done.result);
  EXPECT_EQ(told["device"], "ward-3");
  EXPECT_EQ(told["sessions"], 1);
  ASSERT_EQ(told["files"].size(), 2U) << "recordings and accounts, without the key";
  sqlite3* copied = nullptr;
  sqlite3_stmt* row = nullptr;
  ASSERT_EQ(sqlite3_open((fs::path(told["backup"].get<std::string>()) / "accounts.db").c_str(), &copied), SQLITE_OK);
  ASSERT_EQ(sqlite3_prepare_v2(copied, "SELECT name FROM users", -1, &row, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_step(row), SQLITE_ROW) << "also what stood in the log";
  sqlite3_finalize(row);
  sqlite3_close(copied);
  sqlite3_close(accounts);
  const json with_key = json::parse(*run(JobKind::backup, {.folder = stick, .identity_key = true}).result);
  EXPECT_EQ(with_key["files"].size(), 3U);
  const json list = json::parse(*run(JobKind::list_backups, {}).result);
  EXPECT_EQ(list["folders"][0]["there"], true);
  EXPECT_EQ(list["items"].size(), 1U) << "those of the folder itself";
  EXPECT_EQ(run(JobKind::restore, {.backup = folder_ / "hoist.db"}).reason, server::Reason::invalid) << "from an allowed folder only";
}

class JobsRest : public ServerTest {
 protected:
  json health() { return get("/api/v1/health").json()["recordings"]; }
  bool wait_file(const char* state) {
    return until([&] { return health()["state"] == state; });
  }
  void mode(contract::Mode mode) {
    core_->set([mode](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(mode); });
  }
  // Another program that has done this in the file of the next server's recordings; the caller closes it.
  sqlite3* another_program(const char* file, const char* sql) {
    db_path_ = folder_ / file;
    sqlite3* other = nullptr;
    EXPECT_EQ(sqlite3_open(db_path_.c_str(), &other), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(other, sql, nullptr, nullptr, nullptr), SQLITE_OK);
    return other;
  }
};

// Another program reads the new file, so that the recorder cannot set it up yet.
TEST_F(JobsRest, AJobWaitsUntilTheRecordingsAreSetUp) {
  stop_server();
  sqlite3* other = another_program("new.db", "BEGIN EXCLUSIVE");
  start_server();
  const std::string place = call("POST", "/api/v1/jobs", {{"kind", "recompute_metrics"}}).header("location");
  EXPECT_EQ(get(place).json()["state"], "waiting");
  ASSERT_EQ(sqlite3_exec(other, "ROLLBACK", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(other);
  EXPECT_TRUE(until([&] { return get(place).json()["ended_utc_ms"] != nullptr; }));
  EXPECT_EQ(get(place).json()["state"], "done") << get(place).body;
}

// A file that cannot be set up keeps no job waiting: what it needs not is done, the rest says why not.
TEST_F(JobsRest, JobsBeginAlsoWhereTheRecordingsCannotBeSetUp) {
  stop_server();
  sqlite3* other = another_program("foreign.db", "CREATE TABLE letters (text TEXT)");
  sqlite3_close(other);
  start_server();
  const std::string lists = call("POST", "/api/v1/jobs", {{"kind", "list_backups"}}).header("location"),
                    needs = call("POST", "/api/v1/jobs", {{"kind", "recompute_metrics"}}).header("location");
  EXPECT_TRUE(until([&] { return get(needs).json()["ended_utc_ms"] != nullptr; }));
  EXPECT_EQ(get(lists).json()["state"], "done") << get(lists).body;
  EXPECT_EQ(get(needs).json()["reason_code"], "storage") << get(needs).body;
}

TEST_F(JobsRest, AJobIsStartedFollowedAndAskedForItsResult) {
  ASSERT_TRUE(wait_file("sound")) << "each start checks the file";
  Live live(port_, bearer_);
  ASSERT_EQ(live.status(), 101U);
  const Answer started = call("POST", "/api/v1/jobs", {{"kind", "recompute_metrics"}});
  ASSERT_EQ(started.status, 202) << started.body;
  const std::string place = started.header("location");
  EXPECT_EQ(place, "/api/v1/jobs/" + started.json()["id"].dump());
  EXPECT_EQ(started.json()["actor"]["role"], "engineer");
  ASSERT_TRUE(until([&] { return get(place).json()["state"] == "done"; }));
  EXPECT_EQ(get(place).json()["result"]["items"], json::array()) << "nothing is recorded yet";
  json told;
  ASSERT_TRUE(until([&] {
    told = live.wait("job");
    return told["id"] == started.json()["id"] && told["state"] == "done";
  }));
  const json items = get("/api/v1/jobs").json()["items"];
  EXPECT_EQ(items[0]["kind"], "integrity_check");
  EXPECT_EQ(items[0]["actor"], nullptr) << "the server itself";
  EXPECT_EQ(call("DELETE", place).status, 409) << "it has ended";
  EXPECT_EQ(call("DELETE", place).json()["type"], "/problems/job-ended");
  EXPECT_EQ(call("DELETE", "/api/v1/jobs/99").status, 404);
  EXPECT_EQ(get("/api/v1/jobs/none").status, 404);
}

TEST_F(JobsRest, WhatNoJobIsIsRefusedWithItsField) {
  const auto refused = [this](const json& body, const char* field) {
    const Answer answer = call("POST", "/api/v1/jobs", body);
    EXPECT_EQ(answer.status, 422) << body;
    EXPECT_EQ(answer.json()["errors"][0]["field"], field) << answer.body;
  };
  refused({{"kind", "format_disk"}}, "kind");
  refused({{"kind", 3}}, "kind");
  refused(json::object(), "kind");
  refused({{"kind", "integrity_check"}, {"sessions", {1}}}, "sessions");
  for (const json& sessions : {json(1), json::array(), json(std::vector<int>(1001, 1))})
    refused({{"kind", "recompute_metrics"}, {"sessions", sessions}}, "sessions");
  for (const json& session : {json(0), json(-1), json(1.5), json("1")})
    refused({{"kind", "recompute_metrics"}, {"sessions", {1, session}}}, "sessions.1");
}

// The start does not wait: the server records while the check reads. The file is set aside after the walk, and Health says what it knows.
TEST_F(JobsRest, ADamagedFileIsFoundAfterTheStartAndLeftAfterTheWalk) {
  stop_server();
  record_into(folder_ / "hoist.db", 3000);
  damage_page(folder_ / "hoist.db");
  start_server();
  wait_for_core();
  // Set aside as soon as nothing is recorded into it; a new file is in use and sound.
  ASSERT_TRUE(until([&] {
    const json notices = get("/api/v1/status").json()["notices"];
    return std::ranges::any_of(notices, [](const json& notice) { return notice["name"] == "recordings_set_aside"; });
  }));
  ASSERT_TRUE(wait_file("sound"));
  const json check = get("/api/v1/jobs/1").json();
  EXPECT_EQ(check["state"], "done");
  EXPECT_EQ(check["result"]["sound"], false);
  EXPECT_FALSE(check["result"]["structure"].empty());
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 0);
  mode(contract::Mode::user);
  EXPECT_TRUE(until([&] { return get("/api/v1/recording").json()["state"] == "recording"; }));
}

TEST_F(JobsRest, ABackupIsTakenWhileRecordingAndPutBackAfterIt) {
  const auto job = [this](const json& request) {
    const Answer started = call("POST", "/api/v1/jobs", request);
    EXPECT_EQ(started.status, 202) << started.body;
    json info;
    EXPECT_TRUE(until([&] {
      info = get("/api/v1/jobs/" + started.json()["id"].dump()).json();
      return info["ended_utc_ms"] != nullptr;
    }));
    return info;
  };
  const auto recording = [this](const char* state) { return until([&] { return get("/api/v1/recording").json()["state"] == state; }); };
  ASSERT_TRUE(wait_file("sound"));
  EXPECT_EQ(job({{"kind", "backup"}})["reason_code"], "unknown") << "no stick";
  std::filesystem::create_directory(folder_ / "stick");
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "start"}}).status == 200; }));
  ASSERT_TRUE(recording("recording"));
  const json taken = job({{"kind", "backup"}});
  ASSERT_EQ(taken["state"], "done") << taken;
  EXPECT_EQ(taken["result"]["sessions"], 1);
  const json request{{"kind", "restore"}, {"backup", taken["result"]["backup"]}};
  const json refused = job(request);
  EXPECT_EQ(refused["state"], "failed");
  EXPECT_EQ(refused["reason_code"], "not_now") << "a session is being recorded";
  ASSERT_TRUE(recording("recording"));
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "start"}}).status, 200);
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 2);
  const json id = get("/api/v1/settings").json()["hoist_id"];
  EXPECT_EQ(taken["result"]["hoist_id"], id);
  const json restored = job(request);
  ASSERT_EQ(restored["state"], "done") << restored;
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 1);
  EXPECT_TRUE(std::filesystem::exists(restored["result"]["set_aside"].get<std::string>()));
  ASSERT_TRUE(wait_file("sound")) << "the new file is checked";
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "start"}}).status, 200);
  EXPECT_TRUE(recording("recording")) << "and recorded into";
  const json listed = job({{"kind", "list_backups"}})["result"]["items"];
  ASSERT_EQ(listed.size(), 1U);
  EXPECT_EQ(listed[0]["hoist_id"], id);
  EXPECT_EQ(get("/api/v1/settings").json()["hoist_id"], id);
}

TEST_F(JobsRest, RetentionIsShownBeforeItIsSetAndActsAtTheNextStart) {
  ASSERT_TRUE(wait_file("sound"));
  const json off = get("/api/v1/retention").json();
  EXPECT_EQ(off["days"], nullptr);
  EXPECT_EQ(off["disk_percent"], nullptr);
  EXPECT_EQ(off["needs_backup"], true);
  const auto rule = [](const json& days, const json& percent) {
    return json{{"days", days}, {"disk_percent", percent}, {"needs_backup", false}};
  };
  const Headers seen{{"If-Match", "\"" + off["etag"].get<std::string>() + "\""}};
  for (const auto& [bad, field] :
       {std::pair{rule(29, nullptr), "days"}, {rule(1.5, nullptr), "days"}, {rule(nullptr, 91), "disk_percent"}}) {
    const Answer refused = call("PUT", "/api/v1/retention", bad, seen);
    EXPECT_EQ(refused.status, 422) << bad;
    EXPECT_EQ(refused.json()["errors"][0]["field"], field) << refused.body;
  }
  EXPECT_EQ(call("PUT", "/api/v1/retention", rule(90, nullptr), {{"If-Match", ""}}).status, 428);
  stop_server();
  record_into(folder_ / "hoist.db", 300);
  record_into(folder_ / "hoist.db", 300);
  {
    auto database = db::Database::attach(folder_ / "hoist.db");
    sqlite3_exec(database->handle(), "UPDATE sessions SET started_utc_ns = started_utc_ns - 8000000000000000 WHERE id = 1", nullptr,
                 nullptr, nullptr);
  }
  const auto ended = [this](const std::string& place) {
    json info;
    EXPECT_TRUE(until([&] {
      info = get(place).json();
      return info["ended_utc_ms"].is_number();
    }));
    return info;
  };
  start_server();
  wait_for_core();
  ASSERT_TRUE(wait_file("sound"));
  const json preview =
      ended(call("POST", "/api/v1/jobs", {{"kind", "preview_retention"}, {"rule", rule(90, nullptr)}}).header("location"))["result"];
  EXPECT_EQ(preview["sessions"], 1) << preview;
  EXPECT_EQ(preview["from_utc_ms"], 1'782'000'000'000);
  EXPECT_GT(preview["bytes"], 100);
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 2) << "nothing is deleted by looking";
  EXPECT_EQ(ended(call("POST", "/api/v1/jobs", {{"kind", "retention"}}).header("location"))["result"]["sessions"], 0) << "it is off";
  const Answer set = call("PUT", "/api/v1/retention", rule(90, nullptr), seen);
  ASSERT_EQ(set.status, 200) << set.body;
  EXPECT_EQ(get("/api/v1/retention").json(), set.json());
  EXPECT_EQ(call("PUT", "/api/v1/retention", rule(nullptr, nullptr), seen).status, 412) << "another rule than the one that was seen";
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 2);
  stop_server();
  start_server();
  wait_for_core();
  ASSERT_TRUE(until([&] { return get("/api/v1/sessions").json()["total"] == 1; }));
  EXPECT_EQ(get("/api/v1/sessions/1").status, 404);
  EXPECT_EQ(ended("/api/v1/jobs/2")["result"]["sessions"], 1);
  // Nobody asked for it at that moment: the log names the rule.
  json row;
  ASSERT_TRUE(until([&] {
    const json rows = get("/api/v1/audit").json()["items"];
    for (const json& one : rows)
      if (one["action"] == "retention") row = one;
    return !row.is_null();
  }));
  EXPECT_EQ(row["user"], "hoist-server");
  EXPECT_TRUE(row["after"].get<std::string>().starts_with("1 sessions, 1 to 1, rule ")) << row;
}

TEST_F(JobsRest, ADamagedRecordingIsNamedOnHealthAndTheFileStays) {
  stop_server();
  record_into(folder_ / "hoist.db", 500);
  {
    auto database = db::Database::attach(folder_ / "hoist.db");
    ASSERT_TRUE(database.ok());
    ASSERT_EQ(sqlite3_exec(database->handle(), "UPDATE chunks SET body = zeroblob(length(body))", nullptr, nullptr, nullptr), SQLITE_OK);
  }
  start_server();
  wait_for_core();
  ASSERT_TRUE(wait_file("damaged"));
  EXPECT_EQ(health()["damaged_sessions"], json{1});
  const json notices = get("/api/v1/status").json()["notices"];
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0]["name"], "recordings_damaged");
  EXPECT_EQ(get("/api/v1/sessions").json()["total"], 1);
}

}  // namespace
}  // namespace hoist::test
