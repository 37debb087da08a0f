// The archive against a real PostgreSQL, which this program starts for itself: its own folder, its own socket, no network.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include "db/archive/archive.hpp"
#include "db/archive/digest.hpp"
#include "db/archive/tables.hpp"
#include "db/export/session_export.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/db/db_support.hpp"

extern char** environ;

namespace hoist::db::test {
namespace {

using Said = hoist::test::ShellResult;
Said run(const std::string& command) { return hoist::test::run_shell(command + " 2>&1"); }

// The newest installed server's programs; empty when there is none.
std::filesystem::path postgres_programs() {
  std::filesystem::path newest;
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/usr/lib/postgresql", error), end; !error && entry != end; entry.increment(error))
    if (std::filesystem::exists(entry->path() / "bin" / "initdb", error)) newest = std::max(newest, entry->path() / "bin");
  return newest;
}

// One server for all cases; each case has a database of its own.
class Server {
 public:
  explicit Server(std::filesystem::path programs) : programs_(std::move(programs)) {
    // PostgreSQL refuses to run as root.
    if (::geteuid() == 0) as_ = "setpriv --reuid=postgres --regid=postgres --clear-groups ";
    ::chmod(dir_.path().c_str(), 0755);
    make_folder("data");
    make_folder("socket");
    const Said made =
        run(as_ + (programs_ / "initdb").string() + " -D " + dir_.file("data") + " -A trust -U owner --no-sync -E UTF8 --locale=C");
    if (made.exit_code != 0) problem = made.output;
    start();
  }
  ~Server() { stop("fast"); }

  void start() {
    const Said started = run(as_ + (programs_ / "pg_ctl").string() + " -w -s -D " + dir_.file("data") + " -l " + dir_.file("data/log") +
                             " -o \"-c fsync=off -c listen_addresses='' -c unix_socket_directories=" + dir_.file("socket") + "\" start");
    if (started.exit_code != 0) problem = started.output;
  }
  void stop(const std::string& how) {
    run(as_ + (programs_ / "pg_ctl").string() + " -w -s -D " + dir_.file("data") + " -m " + how + " stop");
  }
  // An answer of psql: another program's look at what the archive holds.
  std::string sql(const std::string& database, const std::string& statement) {
    Said said = run(as_ + (programs_ / "psql").string() + " -h " + dir_.file("socket") + " -U owner -d " + database + " -qAt -c \"" +
                    statement + "\"");
    while (!said.output.empty() && said.output.back() == '\n') said.output.pop_back();
    return said.output;
  }
  [[nodiscard]] std::string target(const std::string& database, const std::string& user = "owner") const {
    return "host=" + dir_.file("socket") + " user=" + user + " dbname=" + database;
  }
  std::string problem;

 private:
  void make_folder(const char* name) {
    run("mkdir -m 0700 " + dir_.file(name));
    if (::geteuid() == 0) run("chown postgres: " + dir_.file(name));
  }
  std::filesystem::path programs_;
  TemporaryFolder dir_;
  std::string as_;
};

class ArchiveTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (const std::filesystem::path programs = postgres_programs(); !programs.empty()) server_ = std::make_unique<Server>(programs);
  }
  static void TearDownTestSuite() { server_.reset(); }

  void SetUp() override {
    if (server_ == nullptr) GTEST_SKIP() << "Debian package postgresql is not installed";
    ASSERT_EQ(server_->problem, "");
    name_ = "case_" + std::to_string(++cases_);
    ASSERT_EQ(server_->sql("postgres", "CREATE DATABASE " + name_), "");
  }
  [[nodiscard]] std::string target(const std::string& user = "owner") const { return server_->target(name_, user); }
  std::string sql(const std::string& statement) { return server_->sql(name_, statement); }
  Archive archive() {
    EXPECT_TRUE(Archive::create(target()).ok());
    return connected(target());
  }
  static Archive connected(const std::string& where) {
    Result<Archive> made = Archive::connect(where);
    EXPECT_TRUE(made.ok()) << (made.ok() ? "" : made.error().message);
    return std::move(*made);
  }

  static inline std::unique_ptr<Server> server_;
  static inline int cases_ = 0;
  std::string name_;
  TemporaryFolder dir_;
};

Database open_at(const std::string& file) {
  Result<Database> database = Database::open(file);
  EXPECT_TRUE(database.ok()) << (database.ok() ? "" : database.error().message);
  return std::move(*database);
}

constexpr std::int64_t kHour_ns = 3'600'000'000'000;

// A walk with everything that a session can hold.
SessionId record(Database& database, std::uint32_t seed, const std::optional<std::string>& code, std::size_t samples = 300,
                 bool simulated = false) {
  Result<SessionWriter> writer = SessionWriter::create(database);
  EXPECT_TRUE(writer.ok());
  SessionStart start = start_of_walk();
  start.subject = code;
  start.simulated = simulated;
  start.started_utc_ns += seed * kHour_ns;
  start.core_start_time_ns += seed;
  start.core_version = "0.1.0+abc";
  start.nodes = {{"tilt_left", 1, std::nullopt, 65536, 7}};
  start.note = "a tab\t, a backslash \\N and \\. and a line\nand ö €";
  start.exercise_json = R"({"shape": "square", "side_m": 3.2})";
  std::vector<double> parameters(contract::kParamCount, 0.1);
  start.parameter_values = parameters;
  const Result<SessionId> id = writer->begin(start);
  EXPECT_TRUE(id.ok());
  writer->set_actor_of([](std::uint32_t client) -> std::optional<Actor> {
    if (client == 0) return std::nullopt;
    return Actor{"anna", "therapist", "rest", "device-12345678"};
  });
  Walk walk(seed);
  EXPECT_TRUE(writer->append_ticks(walk.records(0, samples)).ok());
  EXPECT_TRUE(writer->append_ticks(walk.records(samples + 20, 30)).ok());  // a gap
  std::array<contract::Event, 2> events{};
  events[0].tick = 5;
  events[0].value = std::numeric_limits<double>::quiet_NaN();
  events[1].tick = 6;
  events[1].client = 9;
  events[1].value = 1.0 / 3;
  EXPECT_TRUE(writer->append_events(events).ok());
  std::array<contract::BusRecord, 3> frames{};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].time_ns = kStart_ns + i * 1000;
    frames[i].id = 0x191;
    frames[i].dlc = 8;
  }
  EXPECT_TRUE(writer->append_bus(frames).ok());
  EXPECT_TRUE(
      writer->store_marker(7, start.started_utc_ns, "he said: \"tab\there\", \\N", Actor{"anna", "therapist", "rest", "script"}, "stumble")
          .ok());
  EXPECT_TRUE(writer->append_utc_anchor(kStart_ns + 10, start.started_utc_ns + 12).ok());
  EXPECT_TRUE(writer->end(CloseReason::finished, start.started_utc_ns + 4'000'000'000).ok());
  return *id;
}

// Every value of every table that belongs to a session, read without the archive's own code.
std::vector<std::string> dump(Database& database, SessionId session) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& sql) {
    Statement row(database.handle(), sql);
    row.integer(1, session);
    while (row.step()) out.push_back(row.text_at(0));
  };
  const std::string id = "?1";
  for (const char* sql :
       {"SELECT started_utc_ns || '|' || start_time_ns || '|' || core_start_time_ns || '|' || simulated || '|' || layout_hash || '|' || "
        "software_version || '|' || core_version || '|' || note || '|' || exercise || '|' || ended_utc_ns || '|' || close_reason || '|' || "
        "hoist_id || '|' || sample_count || '|' || first_time_ns || '|' || last_time_ns || '|' || folded || '|' || columns_hash FROM "
        "sessions WHERE id = ?1",
        "SELECT ifnull(code, '-') || '|' || ifnull(day, '-') FROM sessions LEFT JOIN visits ON visits.id = visit_id LEFT JOIN patients ON "
        "patients.id = patient_id WHERE sessions.id = ?1",
        "SELECT first_tick || '|' || last_tick || '|' || samples || '|' || hex(directory) || '|' || hex(body) FROM chunks WHERE session_id "
        "= ?1 "
        "ORDER BY 1",
        "SELECT first_frame || '|' || frames || '|' || hex(body) FROM bus_chunks WHERE session_id = ?1 ORDER BY 1",
        "SELECT number || '|' || stream || '|' || from_tick || '|' || to_tick || '|' || reason FROM gaps WHERE session_id = ?1 ORDER BY 1",
        "SELECT number || '|' || tick || '|' || kind_name || '|' || ifnull(printf('%!.17g', value), 'none') || '|' || name || '|' || "
        "ifnull(user || role || origin || client, 'none') FROM events LEFT JOIN actors ON actors.id = actor_id WHERE session_id = ?1 ORDER "
        "BY 1",
        "SELECT number || '|' || tick || '|' || utc_ns || '|' || text || '|' || ifnull(kind, 'none') || '|' || ifnull(user || client, "
        "'none') FROM markers LEFT JOIN "
        "actors ON "
        "actors.id = actor_id WHERE session_id = ?1 ORDER BY 1",
        "SELECT time_ns || '|' || utc_ns FROM utc_anchors WHERE session_id = ?1 ORDER BY 1",
        "SELECT position || '|' || name || '|' || printf('%!.17g', value) FROM parameters WHERE session_id = ?1 ORDER BY position",
        "SELECT position || '|' || name || '|' || product || '|' || ifnull(revision, 'none') || '|' || version || '|' || crc FROM "
        "node_programs "
        "WHERE session_id = ?1",
        "SELECT position || '|' || name || '|' || unit || '|' || type || '|' || lsb || '|' || decimals FROM column_layout WHERE hash = "
        "(SELECT "
        "columns_hash FROM sessions WHERE id = ?1) ORDER BY position"})
    add(sql);
  return out;
}
std::vector<SessionId> sessions_of(Database& database) {
  std::vector<SessionId> out;
  Statement row(database.handle(), "SELECT id FROM sessions ORDER BY started_utc_ns");
  while (row.step()) out.push_back(row.integer_at(0));
  return out;
}

TEST_F(ArchiveTest, sessions_of_two_hoists_come_back_as_they_were_and_nothing_goes_twice) {
  Archive there = archive();
  Database north = open_at(dir_.file("north.db"));
  Database south = open_at(dir_.file("south.db"));
  record(north, 1, "P-017");
  record(north, 2, "P-017");
  record(north, 3, std::nullopt);
  record(north, 4, "P-018", 100, true);
  record(south, 5, "P-017");

  const Result<PushReport> first = there.push(north, {"north"});
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_EQ(first->pushed, 3U);
  EXPECT_EQ(first->simulated, 1U);
  EXPECT_TRUE(first->refused.empty());
  const Result<PushReport> again = there.push(north, {"north"});
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->pushed, 0U);
  EXPECT_EQ(again->present, 3U);
  ASSERT_TRUE(there.push(south, {"south"}).ok());
  EXPECT_EQ(sql("SELECT count(*), count(DISTINCT device) FROM hoist.sessions"), "4|2");
  // The same code is the same patient; P-017 came on one day or two, but once each.
  EXPECT_EQ(sql("SELECT count(*) FROM hoist.patients"), "1");
  EXPECT_EQ(sql("SELECT count(*) = count(DISTINCT day) FROM hoist.visits"), "t");
  EXPECT_EQ(sql("SELECT sum(samples) FROM hoist.chunks"), std::to_string(4 * 330));

  Database all = open_at(dir_.file("all.db"));
  const Result<PullReport> pulled = there.pull(all, {});
  ASSERT_TRUE(pulled.ok()) << pulled.error().message;
  EXPECT_EQ(pulled->pulled, 4U);
  const std::vector<SessionId> here = sessions_of(all);
  ASSERT_EQ(here.size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(dump(all, here[i]), dump(north, static_cast<SessionId>(i + 1))) << i;
  EXPECT_EQ(dump(all, here[3]), dump(south, 1));
  // Named alike or not, the two are told apart by their ids.
  EXPECT_EQ(sql("SELECT count(DISTINCT hoist_id) FROM hoist.sessions"), "2");
  const std::string id = hoist_id(north.handle());
  const auto of_north = there.list({.device = id});
  ASSERT_EQ(of_north->size(), 3U);
  EXPECT_EQ(of_north->front().hoist_id, id);
  const Result<PullReport> twice = there.pull(all, {});
  ASSERT_TRUE(twice.ok());
  EXPECT_EQ(twice->pulled, 0U);
  EXPECT_EQ(twice->present, 4U);
  // A file that was pulled, and a copy of a hoist's own file, bring nothing new.
  const Result<PushReport> back = there.push(all, {"elsewhere"});
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->present, 4U);
  EXPECT_EQ(sql("SELECT count(*) FROM hoist.sessions WHERE device = 'elsewhere'"), "0");
}

TEST_F(ArchiveTest, a_query_selects_by_patient_device_and_day) {
  Archive there = archive();
  Database database = open_at(dir_.file("one.db"));
  record(database, 1, "P-1");
  record(database, 30, "P-1");  // the next day
  record(database, 31, "P-2");
  ASSERT_TRUE(there.push(database, {"one"}).ok());
  const auto count = [&](const ArchiveQuery& query) { return there.list(query)->size(); };
  EXPECT_EQ(count({}), 3U);
  EXPECT_EQ(count({.patient = "P-1"}), 2U);
  EXPECT_EQ(count({.device = "two"}), 0U);
  const std::string day = there.list({})->front().start_utc.substr(0, 10);
  EXPECT_EQ(count({.to_day = day}), 1U);
  EXPECT_EQ(count({.uuid = there.list({})->front().uuid}), 1U);
  for (const ArchiveQuery& wrong :
       {ArchiveQuery{.uuid = "1 OR 1=1"}, ArchiveQuery{.from_day = "2026-02-30"}, ArchiveQuery{.to_day = "today"}}) {
    const auto refused = there.list(wrong);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().kind, ErrorKind::bad_value);
    EXPECT_FALSE(refused.error().field.empty());
  }
}

// A study of several hoists, evaluated without a file in between: the same tables as of the sessions in one file.
TEST_F(ArchiveTest, the_study_command_reads_the_sessions_of_all_hoists) {
  Archive there = archive();
  for (std::uint32_t number = 1; number <= 2; ++number) {
    const std::string name = "hoist" + std::to_string(number);
    Database database = open_at(dir_.file(name + ".db"));
    const SessionId walk = record(database, number, "P-" + std::to_string(number));
    SessionPatch patch;
    patch.note = "run 1 #spring";
    ASSERT_TRUE(SessionEditor(database).patch(walk, patch).ok());
    ASSERT_TRUE(there.push(database, {name}).ok());
  }
  {
    Database all = open_at(dir_.file("all.db"));
    ASSERT_TRUE(there.pull(all, {}).ok());
  }
  const std::string tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist study ", from = "--archive '" + target() + "'";
  const Said told = run(tool + from);
  EXPECT_EQ(told.exit_code, 3) << "walks of three seconds have no figures: " << told.output;
  EXPECT_NE(told.output.find("; 2 subjects; recorded sessions"), std::string::npos) << told.output;
  EXPECT_EQ(told.output, run(tool + "--recorded " + dir_.file("all.db")).output);
  EXPECT_EQ(run(tool + from + " --tag spring").output, told.output);
  EXPECT_EQ(run(tool + from + " --tag autumn").exit_code, 1);
  EXPECT_EQ(run(tool + from + " --to 2000-01-01").exit_code, 1);
  EXPECT_EQ(run(tool + from + " --from 2000-01-01").output, told.output);
  EXPECT_EQ(run(tool + from + " --from yesterday").exit_code, 1);
  EXPECT_EQ(run(tool + from + " --study 1").exit_code, 2);
  EXPECT_EQ(run(tool + from + " --recorded " + dir_.file("all.db")).exit_code, 2);
  EXPECT_EQ(run(tool + "--recorded " + dir_.file("all.db") + " --to 2000-01-01").exit_code, 2);
}

TEST_F(ArchiveTest, capital_and_small_letters_do_not_tell_codes_apart) {
  Archive there = archive();
  Database north = open_at(dir_.file("north.db"));
  Database south = open_at(dir_.file("south.db"));
  record(north, 1, "MÜL-17");
  record(south, 2, "mül-17");
  ASSERT_TRUE(there.push(north, {"north"}).ok());
  ASSERT_TRUE(there.push(south, {"south"}).ok());
  EXPECT_EQ(sql("SELECT count(*), min(code) FROM hoist.patients"), "1|MÜL-17");
  EXPECT_EQ(there.push(south, {"south"})->present, 1U) << "the digest is that of the hoist's own letters";
  EXPECT_EQ(there.list({.patient = "MÜL-17"})->size(), 2U);
  Database pulled = open_at(dir_.file("pulled.db"));
  record(pulled, 3, "Mül-17");
  ASSERT_TRUE(there.pull(pulled, {}).ok());
  EXPECT_EQ(VisitReader(pulled).patients()->items.size(), 1U);
}

TEST_F(ArchiveTest, changed_words_follow_and_what_was_erased_stays_away) {
  Archive there = archive();
  Database database = open_at(dir_.file("one.db"));
  const SessionId session = record(database, 1, "P-1");
  ASSERT_TRUE(there.push(database, {"one"}).ok());
  ASSERT_TRUE(SessionEditor(database)
                  .patch(session, {.note = "looked at again", .subject = std::optional<std::string>("P-9"), .exercise_json = {}})
                  .ok());
  const Result<PushReport> described = there.push(database, {"one"});
  ASSERT_TRUE(described.ok()) << described.error().message;
  EXPECT_EQ(described->described, 1U);
  EXPECT_EQ(sql("SELECT note FROM hoist.sessions"), "looked at again");
  EXPECT_EQ(there.list({})->front().patient, "P-9");
  EXPECT_EQ(sql("SELECT count(*) FROM hoist.markers"), "1");

  const std::string uuid = there.list({})->front().uuid;
  ASSERT_TRUE(there.erase(uuid).ok());
  EXPECT_EQ(there.erase(uuid).error().kind, ErrorKind::not_found);
  EXPECT_EQ(there.push(database, {"one"})->erased, 1U);
  EXPECT_EQ(
      sql("SELECT (SELECT count(*) FROM hoist.sessions) + (SELECT count(*) FROM hoist.chunks) + (SELECT count(*) FROM hoist.patients)"),
      "0");
}

TEST_F(ArchiveTest, what_was_damaged_in_the_archive_is_named_and_never_pulled) {
  Archive there = archive();
  Database database = open_at(dir_.file("one.db"));
  record(database, 1, "P-1");
  record(database, 2, "P-2");
  ASSERT_TRUE(there.push(database, {"one"}).ok());
  ASSERT_TRUE(there.verify({})->empty());
  const std::string damaged = there.list({.patient = "P-2"})->front().uuid;
  sql("UPDATE hoist.chunks SET body = set_byte(body, 20, get_byte(body, 20) # 1) WHERE session_id = (SELECT id FROM hoist.sessions WHERE "
      "uuid = '" +
      damaged + "')");
  EXPECT_EQ(*there.verify({}), std::vector<std::string>{damaged});
  Database pulled = open_at(dir_.file("pulled.db"));
  const Result<PullReport> refused = there.pull(pulled, {.patient = "P-2"});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::corrupt);
  EXPECT_TRUE(sessions_of(pulled).empty());
  EXPECT_EQ(there.pull(pulled, {.patient = "P-1"})->pulled, 1U);

  // A recording under the same uuid with other content is refused; the others go.
  sql("UPDATE hoist.sessions SET content_sha256 = 'x' WHERE uuid = '" + damaged + "'");
  record(database, 3, "P-3");
  const Result<PushReport> partly = there.push(database, {"one"});
  ASSERT_TRUE(partly.ok()) << partly.error().message;
  EXPECT_EQ(partly->pushed, 1U);
  ASSERT_EQ(partly->refused.size(), 1U);
  EXPECT_NE(partly->refused[0].find(damaged), std::string::npos) << partly->refused[0];
}

TEST_F(ArchiveTest, rights_follow_the_role) {
  Archive owner = archive();
  server_->sql("postgres", "CREATE ROLE pusher_" + name_ + " LOGIN IN ROLE hoist_archive_push; CREATE ROLE reader_" + name_ +
                               " LOGIN IN ROLE hoist_archive_read; CREATE ROLE stranger_" + name_ + " LOGIN");
  Database database = open_at(dir_.file("one.db"));
  const SessionId session = record(database, 1, "P-1");
  Archive reader = connected(target("reader_" + name_));
  const Result<PushReport> denied = reader.push(database, {"one"});
  ASSERT_FALSE(denied.ok());
  EXPECT_EQ(denied.error().kind, ErrorKind::wrong_state) << denied.error().message;
  Archive pusher = connected(target("pusher_" + name_));
  const Result<PushReport> pushed = pusher.push(database, {"one"});
  ASSERT_TRUE(pushed.ok()) << pushed.error().message;
  EXPECT_EQ(pushed->pushed, 1U);
  ASSERT_TRUE(SessionEditor(database).patch(session, {.note = "later", .subject = {}, .exercise_json = {}}).ok());
  const Result<PushReport> described = pusher.push(database, {"one"});
  ASSERT_TRUE(described.ok()) << described.error().message;
  EXPECT_EQ(described->described, 1U);
  const std::string uuid = reader.list({})->front().uuid;
  EXPECT_FALSE(pusher.erase(uuid).ok());
  EXPECT_FALSE(reader.erase(uuid).ok());
  Database pulled = open_at(dir_.file("pulled.db"));
  EXPECT_EQ(reader.pull(pulled, {})->pulled, 1U);
  // A role without any right does not learn that there is an archive at all.
  EXPECT_FALSE(Archive::connect(target("stranger_" + name_)).ok());
}

TEST_F(ArchiveTest, a_database_without_an_archive_or_with_a_newer_one_says_what_to_do) {
  const auto none = Archive::connect(target());
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().kind, ErrorKind::wrong_state);
  EXPECT_NE(none.error().message.find("hoist archive create"), std::string::npos);
  EXPECT_EQ(*Archive::create(target()), 0);
  EXPECT_EQ(*Archive::create(target()), 2);
  sql("INSERT INTO hoist.archive_schema (version) VALUES (3)");
  EXPECT_EQ(Archive::connect(target()).error().kind, ErrorKind::newer_schema);
  EXPECT_EQ(Archive::create(target()).error().kind, ErrorKind::newer_schema);
  const auto unreachable = Archive::connect("host=" + dir_.file("nowhere") + " dbname=x");
  ASSERT_FALSE(unreachable.ok());
  EXPECT_EQ(unreachable.error().kind, ErrorKind::io);
}

// Sessions from before hoists had an id are the same recordings as before: nothing is sent again, nothing differs.
TEST_F(ArchiveTest, an_archive_of_the_first_schema_goes_on) {
  ASSERT_TRUE(Archive::create(target()).ok());
  Database database = open_at(dir_.file("one.db"));
  record(database, 1, "P-1");
  execute(database.handle(), "UPDATE sessions SET hoist_id = NULL; UPDATE markers SET kind = NULL");
  ASSERT_TRUE(connected(target()).push(database, {"one"}).ok());
  sql("ALTER TABLE hoist.sessions DROP COLUMN hoist_id; ALTER TABLE hoist.markers DROP COLUMN kind; DELETE FROM hoist.archive_schema WHERE "
      "version = 2");
  EXPECT_EQ(Archive::connect(target()).error().kind, ErrorKind::wrong_state);
  EXPECT_EQ(*Archive::create(target()), 1);
  Archive there = connected(target());
  EXPECT_TRUE(there.verify({})->empty());
  EXPECT_EQ(there.push(database, {"one"})->present, 1U);
  EXPECT_EQ(there.list({})->front().hoist_id, "");
  record(database, 2, "P-1");
  EXPECT_EQ(there.push(database, {"one"})->pushed, 1U);
}

// A push by the tool, as a process of its own; it says on stderr which visit it begins.
class Push {
 public:
  Push(const std::string& file, const std::string& target) {
    const std::string tool = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "hoist";
    std::array<std::string, 7> words{tool, "archive", "push", file, target, "--device", "one"};
    std::array<char*, 8> arguments{};
    for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
    std::array<int, 2> pipe{};
    EXPECT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions{};
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, pipe[1], 2);
    EXPECT_EQ(::posix_spawn(&child_, tool.c_str(), &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(pipe[1]);
    said_ = ::fdopen(pipe[0], "r");
  }
  ~Push() { (void)std::fclose(said_); }
  Push(const Push&) = delete;
  Push& operator=(const Push&) = delete;
  void await_visit(int visit) {
    std::array<char, 1000> line{};
    for (int i = 0; i < visit && std::fgets(line.data(), line.size(), said_) != nullptr; ++i) {
    }
  }
  void kill() { ::kill(child_, SIGKILL); }
  // True when it ended by itself and everything was sent.
  bool finished() {
    int status = 0;
    EXPECT_EQ(::waitpid(child_, &status, 0), child_);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
  }

 private:
  pid_t child_ = 0;
  std::FILE* said_ = nullptr;
};

// Either side dies at any moment: after one more push everything is there, once.
TEST_F(ArchiveTest, nothing_is_lost_or_sent_twice_when_either_side_dies) {
  ASSERT_TRUE(Archive::create(target()).ok());
  constexpr std::uint32_t kSessions = 24;
  const std::string file = dir_.file("one.db");
  {
    Database database = open_at(file);
    for (std::uint32_t i = 1; i <= kSessions; ++i) record(database, i, "P-" + std::to_string(i % 5), 1500);
  }
  int cut = 0;
  for (int round = 0; round < 10; ++round) {
    Push push(file, target());
    push.await_visit(round + 1);
    if (round % 4 == 3) {
      server_->stop("immediate");
      server_->start();
      ASSERT_EQ(server_->problem, "");
    } else {
      push.kill();
    }
    cut += push.finished() ? 0 : 1;
    // What is there is whole, whatever happened.
    EXPECT_EQ(
        sql("SELECT count(*) FROM hoist.sessions s WHERE sample_count IS DISTINCT FROM (SELECT sum(samples) FROM hoist.chunks c WHERE "
            "c.session_id = s.id)"),
        "0");
  }
  EXPECT_GE(cut, 7);
  Database database = open_at(file);
  Archive there = connected(target());
  const Result<PushReport> last = there.push(database, {"one"});
  ASSERT_TRUE(last.ok()) << last.error().message;
  EXPECT_EQ(last->pushed + last->present, kSessions);
  EXPECT_EQ(sql("SELECT count(*), count(DISTINCT uuid), count(DISTINCT content_sha256) FROM hoist.sessions"), "24|24|24");
  EXPECT_TRUE(there.verify({})->empty());
}

// A table or column of a session that is added to the schema must be archived, or be named here with the reason why it stays.
TEST(ArchiveTables, everything_of_a_session_is_archived) {
  TemporaryFolder dir;
  Database database = open_at(dir.file("hoist.db"));
  const std::vector<std::string> stays{
      "sessions.id",           // the file's own number; the archive has its own, and the uuid
      "sessions.visit_id",     // by patient and day
      "deletions.session_id",  // how far a deletion has come, which is the file's own affair
      "sessions.folded",       // only folded sessions are archived
      "sessions.standby",      // only walks are archived
      "events.actor_id",       // as words
      "markers.actor_id",      // as words
      "chunks.id",
      "bus_chunks.id",
      "journal_chunks.id",
      "core_images.id",
      // A virtual subject's session has no visit, so it is never archived.
      "study_runs.session_id",
      "study_runs.study_id",
      "study_runs.subject",
      "study_runs.run",
  };
  const auto archived = [&](const std::string& table, const std::string& column) {
    const auto has = [&](std::span<const ArchiveColumn> columns) {
      return std::any_of(columns.begin(), columns.end(), [&](const ArchiveColumn& one) { return one.name == column; });
    };
    if (table == "sessions") return has(archive_columns::kSession) || has(archive_columns::kDescription);
    for (const ArchiveTable& one : kSessionTables)
      if (one.name == table) return column == "session_id" || has(one.columns);
    return false;
  };
  Statement row(
      database.handle(),
      "SELECT m.name, c.name FROM sqlite_schema m, pragma_table_info(m.name) c WHERE m.type = 'table' AND (m.name = 'sessions' OR "
      "EXISTS (SELECT 1 FROM pragma_table_info(m.name) WHERE name = 'session_id')) ORDER BY 1, 2");
  int seen = 0;
  while (row.step()) {
    ++seen;
    const std::string column = row.text_at(0) + "." + row.text_at(1);
    EXPECT_TRUE(archived(row.text_at(0), row.text_at(1)) || std::find(stays.begin(), stays.end(), column) != stays.end())
        << column << " is neither archived (db/archive/tables.hpp) nor named here";
  }
  EXPECT_GT(seen, 60);
}

TEST(ArchiveTables, a_uuid_is_made_of_the_recording_and_has_the_form_of_rfc_9562) {
  const Row one{std::int64_t{1}, std::int64_t{2}, std::int64_t{3}};
  const Row other{std::int64_t{1}, std::int64_t{2}, std::int64_t{4}};
  const std::string uuid = session_uuid(one);
  EXPECT_EQ(uuid, session_uuid(one));
  EXPECT_NE(uuid, session_uuid(other));
  ASSERT_EQ(uuid.size(), 36U);
  EXPECT_EQ(uuid[14], '8');
  EXPECT_NE(std::string("89ab").find(uuid[19]), std::string::npos);
}

}  // namespace
}  // namespace hoist::db::test
