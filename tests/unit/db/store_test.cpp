#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <random>

#include "db/store/deletion.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/markers.hpp"
#include "db/store/schema_list.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

using contract::BusRecord;
using contract::Event;
using contract::EventKind;
using contract::TickRecord;

Database open_at(const std::filesystem::path& file, OpenOptions options = {}) {
  Result<Database> database = Database::open(file, options);
  EXPECT_TRUE(database.ok()) << (database.ok() ? "" : database.error().message);
  return std::move(*database);
}
SessionWriter writer_of(Database& database) {
  Result<SessionWriter> writer = SessionWriter::create(database);
  EXPECT_TRUE(writer.ok()) << (writer.ok() ? "" : writer.error().message);
  return std::move(*writer);
}
// Records a closed session of `count` samples from tick 0.
SessionId record_session(Database& database, std::size_t count, std::uint32_t seed, std::vector<TickRecord>* kept_records = nullptr) {
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  EXPECT_TRUE(id.ok());
  Walk walk(seed);
  const std::vector<TickRecord> records = walk.records(0, count);
  for (std::size_t i = 0; i < count; i += 5)
    EXPECT_TRUE(writer.append_ticks(std::span(records).subspan(i, std::min<std::size_t>(5, count - i))).ok());
  EXPECT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns + static_cast<std::int64_t>(count) * 10'000'000).ok());
  if (kept_records != nullptr) *kept_records = records;
  return *id;
}
std::int64_t number_of(Database& database, const char* sql) {
  Statement statement(database.handle(), sql);
  return statement.step() ? statement.integer_at(0) : -1;
}

TEST(Open, an_empty_file_gets_the_newest_schema_and_keeps_it) {
  TemporaryFolder dir;
  {
    Database database = open_at(dir / "hoist.db");
    EXPECT_TRUE(database.report().created);
    EXPECT_EQ(database.report().migrated_from, 0);
    EXPECT_EQ(database.report().schema_version, schema_version());
    EXPECT_EQ(number_of(database, "PRAGMA synchronous"), 2) << "FULL";
    EXPECT_EQ(number_of(database, "PRAGMA foreign_keys"), 1);
    Statement mode(database.handle(), "PRAGMA journal_mode");
    ASSERT_TRUE(mode.step());
    EXPECT_EQ(mode.text_at(0), "wal");
  }
  Database again = open_at(dir / "hoist.db");
  EXPECT_FALSE(again.report().created);
  EXPECT_EQ(again.report().migrated_from, schema_version());
  EXPECT_TRUE(again.report().set_aside.empty());
}

TEST(Open, a_newer_schema_is_refused_and_left_alone) {
  TemporaryFolder dir;
  {
    Database database = open_at(dir / "hoist.db");
    execute(database.handle(), "PRAGMA user_version = 99");
  }
  const Result<Database> refused = Database::open(dir / "hoist.db");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::newer_schema);
  EXPECT_NE(refused.error().message.find("newer Hoist"), std::string::npos);
  const Result<Database> attached = Database::attach(dir / "hoist.db");
  ASSERT_FALSE(attached.ok());
  EXPECT_EQ(attached.error().kind, ErrorKind::newer_schema);
  EXPECT_TRUE(std::filesystem::exists(dir / "hoist.db"));
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}
// What a program leaves behind that is killed now.
void copy_as_killed(const std::filesystem::path& from, const std::filesystem::path& to) {
  for (const char* suffix : {"", "-wal", ".seal"})
    if (std::filesystem::exists(from.string() + suffix)) std::filesystem::copy_file(from.string() + suffix, to.string() + suffix);
}

TEST(Open, a_damaged_file_is_set_aside_with_its_date_and_stays_known) {
  TemporaryFolder dir;
  { Database database = open_at(dir / "hoist.db"); }
  {
    std::fstream stream(dir / "hoist.db", std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(100);
    stream << std::string(5000, 'x');
  }
  OpenOptions options;
  options.utc_now_ns = kStartUtc_ns;
  {
    Database database = open_at(dir / "hoist.db", options);
    EXPECT_EQ(database.report().set_aside.filename(), "hoist.db.corrupt-20260921T141320Z");
    EXPECT_FALSE(database.report().set_aside_reason.empty());
    EXPECT_TRUE(std::filesystem::exists(database.report().set_aside));
    EXPECT_TRUE(database.report().created);
    EXPECT_FALSE(database.report().lost) << "what is set aside is not lost";
    EXPECT_TRUE(SessionReader(database).list().ok());
  }
  EXPECT_EQ(open_at(dir / "hoist.db").report().kept_aside, dir / "hoist.db.corrupt-20260921T141320Z") << "also at a later start";
  std::filesystem::remove(dir / "hoist.db.corrupt-20260921T141320Z");
  std::filesystem::remove(dir / "hoist.db.corrupt-20260921T141320Z.seal");
  EXPECT_TRUE(open_at(dir / "hoist.db").report().kept_aside.empty());
}

TEST(Open, a_file_of_another_program_is_refused_and_stays_as_it_is) {
  TemporaryFolder dir;
  std::ofstream(dir / "letter.txt") << "Dear colleague,\n" << std::string(5000, 'x');
  std::ofstream(dir / "short.txt") << "Dear";
  const auto make = [&dir](const char* name, const char* sql) {
    sqlite3* handle = nullptr;
    ASSERT_EQ(sqlite3_open((dir / name).c_str(), &handle), SQLITE_OK);
    execute(handle, sql);
    sqlite3_close(handle);
  };
  make("photos.db", "CREATE TABLE photos (name TEXT); INSERT INTO photos VALUES ('a')");
  make("named.db", "PRAGMA application_id = 7; CREATE TABLE sessions (id INTEGER)");
  make("log.db", "PRAGMA journal_mode = WAL; CREATE TABLE sessions (id INTEGER)");
  for (const char* name : {"letter.txt", "short.txt", "photos.db", "named.db", "log.db"}) {
    const std::string before = bytes_of(dir / name);
    for (const bool write : {true, false}) {
      const Result<Database> refused = write ? Database::open(dir / name) : Database::attach(dir / name);
      ASSERT_FALSE(refused.ok()) << name;
      EXPECT_EQ(refused.error().kind, ErrorKind::foreign) << refused.error().message;
      EXPECT_NE(refused.error().message.find("stays as it is"), std::string::npos) << refused.error().message;
    }
    EXPECT_EQ(bytes_of(dir / name), before) << name;
  }
}

// A file that the first program with a recording wrote (recording_001.sql): no application_id, no seal, no actors.
void make_recording_001(const std::filesystem::path& file) {
  sqlite3* handle = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &handle), SQLITE_OK);
  execute(handle, bytes_of(HOIST_SOURCE_DIR "/tests/unit/db/recording_001.sql").c_str());
  sqlite3_close(handle);
}

TEST(Open, a_file_of_schema_001_is_migrated_and_says_what_it_does_not_know) {
  TemporaryFolder dir;
  make_recording_001(dir / "hoist.db");
  Database database = open_at(dir / "hoist.db");
  EXPECT_EQ(database.report().migrated_from, 1);
  EXPECT_TRUE(database.report().set_aside.empty());
  EXPECT_FALSE(database.report().lost);
  EXPECT_NE(number_of(database, "PRAGMA application_id"), 0);
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM pragma_foreign_key_check"), 0);
  const SessionReader reader(database);
  const std::array<std::size_t, 3> samples{60, 40, 20};
  for (SessionId id = 1; id <= 3; ++id) {
    const Result<SessionInfo> info = reader.get(id);
    ASSERT_TRUE(info.ok()) << info.error().message;
    EXPECT_EQ(info->subject, id < 3 ? std::optional<std::string>("P-017") : std::nullopt);
    EXPECT_EQ(info->layout_hash, 0xFEDCBA9876543210ULL);
    EXPECT_FALSE(info->core_version.has_value());
    EXPECT_FALSE(info->hoist_id.has_value()) << "hoists had no id then";
    EXPECT_TRUE(reader.node_programs(id)->empty());
    EXPECT_TRUE(reader.journal(id)->empty());
    EXPECT_EQ(reader.columns(id)->size(), 67U) << "those of its own time";
    const Result<Columns> read = reader.read_columns(id, std::array<std::string, 1>{"x_m"});
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_EQ(read->values[0].size(), samples[static_cast<std::size_t>(id - 1)]);
    for (std::size_t i = 0; i < read->values[0].size(); ++i)
      ASSERT_NEAR(read->values[0][i], std::sin(0.1 * static_cast<double>(i)), 0.5e-3) << i;
    const auto events = reader.events(id);
    ASSERT_EQ(events->size(), 1U);
    EXPECT_EQ(events->front().kind_name, "parameter_changed");
    EXPECT_EQ(events->front().request_id, 5U);
    EXPECT_FALSE(events->front().actor) << "the number of a connection names no actor";
    const auto markers = reader.markers(id);
    ASSERT_EQ(markers->size(), 1U);
    EXPECT_EQ(markers->front().text, "turned");
    EXPECT_FALSE(markers->front().actor);
  }
  EXPECT_EQ(number_of(database, "SELECT count(DISTINCT hash) FROM column_layout"), 1) << "three sessions share one layout";
  const auto visits = VisitReader(database).visits();
  ASSERT_EQ(visits->items.size(), 1U) << "one patient, one day; the session without a code is in none";
  EXPECT_EQ(visits->items[0].visit.patient, "P-017");
  EXPECT_EQ(visits->items[0].sessions, (std::vector<SessionId>{1, 2}));
  const auto patients = VisitReader(database).patients();
  ASSERT_EQ(patients->items.size(), 1U);
  EXPECT_FALSE(patients->items[0].archived || patients->items[0].has_identity);
  // And it is recorded into as any other.
  std::vector<TickRecord> records;
  const SessionId today = record_session(database, 300, 1, &records);
  expect_recorded(database, today, records);
  EXPECT_EQ(SessionReader(database).get(today)->hoist_id, hoist_id(database.handle()));
}

TEST(HoistId, is_made_once_at_random_and_outlives_a_file_that_is_set_aside) {
  TemporaryFolder dir;
  std::string first;
  {
    Database database = open_at(dir / "hoist.db");
    first = hoist_id(database.handle());
    ASSERT_EQ(first.size(), 36U);
    EXPECT_EQ(first[14], '4') << "RFC 9562: random";
    EXPECT_NE(std::string("89ab").find(first[19]), std::string::npos);
    EXPECT_EQ(first.find_first_not_of("0123456789abcdef-"), std::string::npos);
    EXPECT_THROW(execute(database.handle(), "INSERT INTO hoist (id) VALUES (NULL)"), SqlFailure);
  }
  EXPECT_EQ(hoist_id(open_at(dir / "hoist.db").handle()), first) << "opened again";
  EXPECT_NE(hoist_id(open_at(dir / "other.db").handle()), first);
  OpenOptions options;
  options.utc_now_ns = kStartUtc_ns;
  options.damage = "page 7 is another's";
  {
    Database database = open_at(dir / "hoist.db", options);
    ASSERT_FALSE(database.report().set_aside.empty());
    EXPECT_EQ(hoist_id(database.handle()), first) << "an empty file, the same hoist";
    EXPECT_EQ(number_of(database, "SELECT count(*) FROM hoist"), 1);
  }
  EXPECT_EQ(hoist_id_of(dir / "none.db"), "");
}

TEST(Visits, are_one_patient_on_one_local_day_and_end_with_their_last_session) {
  const InTimeZone zone("EAST-2");  // two hours ahead of UTC
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const auto record = [&](std::optional<std::string> code, std::int64_t hours) {
    SessionStart start = start_of_walk();
    start.subject = std::move(code);
    start.started_utc_ns = kStartUtc_ns + hours * 3'600'000'000'000;  // 14:13 UTC, 16:13 here
    const Result<SessionId> id = writer.begin(start);
    EXPECT_TRUE(id.ok()) << id.error().message;
    EXPECT_TRUE(writer.end(CloseReason::finished, start.started_utc_ns).ok());
    return *id;
  };
  const SessionId first = record("A", 0), same = record("A", 7), late = record("A", 8), other = record("B", 0), unknown = record({}, 0);
  const VisitReader reader(database);
  const auto days = reader.visits({.limit = 2});
  ASSERT_EQ(days->items.size(), 2U);
  EXPECT_EQ(days->items[0].visit.patient, "B");
  EXPECT_EQ(days->items[1].visit.day, "2026-09-22") << "00:13 here, still the day before in UTC";
  const auto earlier = reader.visits({.limit = 2, .before = days->next});
  ASSERT_EQ(earlier->items.size(), 1U);
  EXPECT_EQ(earlier->items[0].visit.day, "2026-09-21");
  EXPECT_EQ(earlier->items[0].sessions, (std::vector<SessionId>{first, same}));
  EXPECT_FALSE(earlier->next);
  EXPECT_EQ(reader.visits({.limit = 0}).error().field, "limit");
  const auto patients = reader.patients();
  ASSERT_EQ(patients->items.size(), 2U);
  EXPECT_EQ(patients->items[1].code, "A");
  EXPECT_EQ(patients->items[1].visits, 2U);
  EXPECT_EQ(patients->items[1].sessions, 3U);
  EXPECT_EQ(reader.visits({.patient_id = patients->items[1].id})->items.size(), 2U);
  EXPECT_EQ(reader.of_sessions(std::array{first, unknown})->count(unknown), 0U);

  // The code of a session moves it; a patient without sessions is gone, and so is the code.
  const auto with_code = [](std::optional<std::string> code) {
    SessionPatch patch;
    patch.subject = std::move(code);
    return patch;
  };
  SessionEditor editor(database);
  ASSERT_TRUE(editor.patch(other, with_code("A")).ok());
  EXPECT_EQ(reader.patients()->items.size(), 1U);
  EXPECT_EQ(reader.of_sessions(std::array{other})->at(other).id, reader.of_sessions(std::array{first})->at(first).id);
  ASSERT_TRUE(editor.patch(first, with_code(std::nullopt)).ok());
  EXPECT_FALSE(SessionReader(database).get(first)->subject);
  for (const SessionId id : {same, late, other}) ASSERT_TRUE(editor.remove(id).ok());
  EXPECT_TRUE(reader.patients()->items.empty());
  EXPECT_TRUE(reader.visits()->items.empty());
}

TEST(Layout, is_stored_once_and_stays_with_the_sessions_that_are_left) {
  TemporaryFolder dir;
  make_recording_001(dir / "hoist.db");
  Database database = open_at(dir / "hoist.db");
  std::vector<TickRecord> records;
  const SessionId first = record_session(database, 50, 1);
  const std::int64_t rows = number_of(database, "SELECT count(*) FROM column_layout");
  EXPECT_EQ(rows, static_cast<std::int64_t>(67 + contract::kSignalCount)) << "that of 001 and today's";
  const SessionId second = record_session(database, 50, 2, &records);
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM column_layout"), rows);
  ASSERT_TRUE(SessionEditor(database).remove(first).ok());
  expect_recorded(database, second, records);
  EXPECT_EQ(SessionReader(database).columns(1)->size(), 67U);
}

TEST(Open, an_empty_file_beside_a_full_log_is_set_aside_with_it) {
  TemporaryFolder dir;
  Database database = open_at(dir / "live.db");
  SessionWriter writer = writer_of(database);
  ASSERT_TRUE(writer.begin(start_of_walk()).ok());
  for (const bool gone : {false, true}) {
    const auto file = dir / (gone ? "gone.db" : "empty.db");
    copy_as_killed(dir / "live.db", file);
    if (gone)
      std::filesystem::remove(file);
    else
      std::filesystem::resize_file(file, 0);
    OpenOptions options;
    options.utc_now_ns = kStartUtc_ns;
    Database opened = open_at(file, options);
    const std::filesystem::path aside = opened.report().set_aside;
    EXPECT_NE(opened.report().set_aside_reason.find("its log is not"), std::string::npos) << opened.report().set_aside_reason;
    EXPECT_GT(std::filesystem::file_size(aside.string() + "-wal"), 4096U) << "a repair has the log";
    EXPECT_EQ(opened.report().kept_aside, aside);
  }
}

// H25
TEST(Open, a_log_whose_end_is_missing_is_noticed_and_the_session_says_what_it_lost) {
  TemporaryFolder dir;
  Database live = open_at(dir / "live.db");
  SessionWriter writer = writer_of(live);
  Walk walk(3);
  ASSERT_TRUE(writer.begin(start_of_walk()).ok());
  for (std::uint64_t tick = 1; tick < 2000; tick += 50) {
    ASSERT_TRUE(writer.append_ticks(walk.records(tick, 50)).ok());
    ASSERT_TRUE(writer.commit().ok());
  }
  const std::uint64_t newest = *writer.durable().last_tick;
  copy_as_killed(dir / "live.db", dir / "killed.db");
  EXPECT_FALSE(open_at(dir / "killed.db").report().lost) << "kill -9 loses nothing";

  constexpr std::uintmax_t kHeader_bytes = 32, kFrame_bytes = 24 + 4096;
  copy_as_killed(dir / "live.db", dir / "cut.db");
  const auto log = dir / "cut.db-wal";
  const std::uintmax_t frames = (std::filesystem::file_size(log) - kHeader_bytes) / kFrame_bytes;
  ASSERT_GT(frames, 80U);
  std::filesystem::resize_file(log, kHeader_bytes + frames * 9 / 10 * kFrame_bytes);
  {
    Database cut = open_at(dir / "cut.db");
    ASSERT_TRUE(cut.report().lost.has_value());
    EXPECT_EQ(cut.report().lost->session, 1);
    EXPECT_EQ(cut.report().lost->last_tick, newest);
    EXPECT_GT(cut.report().lost->commits, 0U);
    SessionWriter next = writer_of(cut);
    const SessionReader reader(cut);
    const Columns held = *reader.read_columns(1, {});
    ASSERT_FALSE(held.tick.empty());
    const std::vector<Gap> gaps = *reader.gaps(1);
    ASSERT_EQ(gaps.size(), 1U);
    EXPECT_EQ(gaps[0].from_tick, held.tick.back() + 1);
    EXPECT_EQ(gaps[0].to_tick, newest);
    EXPECT_EQ(gaps[0].reason, "storage_lost");
  }
  Database again = open_at(dir / "cut.db");
  EXPECT_FALSE(again.report().lost) << "told once";
  EXPECT_EQ(SessionReader(again).gaps(1)->size(), 1U);
}

TEST(Open, a_number_that_was_lost_with_its_session_is_not_given_again) {
  TemporaryFolder dir;
  Database live = open_at(dir / "live.db");
  for (int session = 0; session < 3; ++session) record_session(live, 100, 4);
  copy_as_killed(dir / "live.db", dir / "cut.db");
  for (const char* suffix : {"", "-wal"}) std::filesystem::remove((dir / "cut.db").string() + suffix);
  Database cut = open_at(dir / "cut.db");
  ASSERT_TRUE(cut.report().lost.has_value()) << "a file that is gone has lost all";
  EXPECT_EQ(record_session(cut, 100, 4), 4);
}

TEST(Open, a_number_of_a_file_that_was_set_aside_is_not_given_again) {
  TemporaryFolder dir;
  OpenOptions options;
  for (SessionId next = 1; next < 4; ++next) {
    options.utc_now_ns = kStartUtc_ns + next * 1'000'000'000;
    Database database = open_at(dir / "hoist.db", options);
    EXPECT_EQ(record_session(database, 100, 4), next);
    options.damage = "a page is damaged";
  }
}

TEST(Open, a_seal_of_another_file_or_a_damaged_one_says_nothing) {
  TemporaryFolder dir;
  for (const char* name : {"a.db", "b.db"}) {
    Database database = open_at(dir / name);
    record_session(database, std::string_view(name) == "a.db" ? 900 : 100, 5);
  }
  std::filesystem::copy_file(dir / "a.db.seal", dir / "b.db.seal", std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(open_at(dir / "b.db").report().lost);
  std::string torn = bytes_of(dir / "a.db.seal");
  torn[std::string("hoist-seal ").size() + 18] = '9';
  std::ofstream(dir / "a.db.seal") << torn;
  EXPECT_FALSE(open_at(dir / "a.db").report().lost);
}

// H25
TEST(Open, damaged_and_cut_files_never_crash_and_never_stay_in_the_way) {
  TemporaryFolder dir;
  {
    Database database = open_at(dir / "good.db");
    record_session(database, 900, 1);
  }
  const auto size = std::filesystem::file_size(dir / "good.db");
  std::mt19937_64 random(7);
  int set_aside = 0;
  for (int round = 0; round < 60; ++round) {
    const auto file = dir / "hoist.db";
    for (const char* suffix : {"", "-wal", "-shm", ".seal"}) std::filesystem::remove(file.string() + suffix);
    std::filesystem::copy_file(dir / "good.db", file);
    if (round % 3 == 0) {
      std::filesystem::resize_file(file, random() % size);
    } else {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      for (int flips = 0; flips < 40; ++flips) {
        stream.seekp(static_cast<std::streamoff>(random() % size));
        stream.put(static_cast<char>(random()));
      }
    }
    OpenOptions options;
    options.utc_now_ns = kStartUtc_ns;
    const Result<Database> opened = Database::open(file, options);
    if (!opened) {
      // A damaged version number may look newer, a damaged name like another program's; every other file must open.
      EXPECT_TRUE(opened.error().kind == ErrorKind::newer_schema || opened.error().kind == ErrorKind::foreign) << opened.error().message;
      continue;
    }
    Database database = std::move(const_cast<Database&>(*opened));
    if (!database.report().set_aside.empty()) {
      ++set_aside;
      std::filesystem::remove(database.report().set_aside);
    }
    // Damage inside a blob passes the check; reading it is an error or gives the readable rows, never a crash.
    Result<SessionWriter> writer = SessionWriter::create(database);
    const SessionReader reader(database);
    const Result<SessionPage> page = reader.list();
    if (!page) continue;
    for (const SessionInfo& session : page->sessions) {
      const Result<Columns> columns = reader.read_columns(session.id, all_columns());
      if (!columns) {
        EXPECT_FALSE(columns.error().message.empty());
      }
    }
  }
  EXPECT_GT(set_aside, 20);
}

TEST(Open, one_program_writes_a_file) {
  TemporaryFolder dir;
  std::optional<Database> first(open_at(dir / "hoist.db"));
  {
    SessionWriter writer = writer_of(*first);
    ASSERT_TRUE(writer.begin(start_of_walk()).ok());
    const Result<Database> second = Database::open(dir / "hoist.db");
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().kind, ErrorKind::busy);
    EXPECT_NE(second.error().message.find("process " + std::to_string(::getpid())), std::string::npos) << second.error().message;
    Result<Database> reader = Database::attach(dir / "hoist.db");
    ASSERT_TRUE(reader.ok());
    EXPECT_TRUE(SessionReader(*reader).get(1)->recording);
    EXPECT_TRUE(Database::open(dir / "other.db").ok());
  }
  first.reset();
  EXPECT_TRUE(Database::open(dir / "hoist.db").ok()) << "the lock goes with the connection";
}

TEST(Open, readers_need_a_prepared_file) {
  TemporaryFolder dir;
  EXPECT_FALSE(Database::attach(dir / "none.db").ok());
  EXPECT_FALSE(std::filesystem::exists(dir / "none.db"));
}

TEST(Writer, what_was_appended_is_read_back_while_recording_and_after_folding) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  Database other = std::move(*Database::attach(dir / "hoist.db"));
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  ASSERT_TRUE(id.ok());
  Walk walk(11);
  const std::vector<TickRecord> records = walk.records(400, 6543);
  std::size_t done = 0;
  while (done < records.size()) {
    const std::size_t n = std::min<std::size_t>(7, records.size() - done);
    ASSERT_TRUE(writer.append_ticks(std::span(records).subspan(done, n)).ok());
    done += n;
    // A commit waits for at most half a second of samples.
    EXPECT_LE(done - writer.durable().samples, kCommitSamples);
  }
  const Result<Durable> durable = writer.commit();
  ASSERT_TRUE(durable.ok());
  EXPECT_EQ(durable->last_tick, records.back().tick);
  EXPECT_EQ(durable->samples, records.size());
  expect_recorded(other, *id, records);
  const Result<SessionInfo> live = SessionReader(other).get(*id);
  ASSERT_TRUE(live.ok());
  EXPECT_TRUE(live->recording);
  EXPECT_EQ(live->sample_count, records.size());
  EXPECT_EQ(live->subject, "P-017");
  EXPECT_EQ(live->layout_hash, 0xFEDCBA9876543210ULL);
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns + 1).ok());
  EXPECT_FALSE(writer.recording());
  expect_recorded(other, *id, records);
  const Result<SessionInfo> closed = SessionReader(other).get(*id);
  ASSERT_TRUE(closed.ok());
  EXPECT_FALSE(closed->recording);
  EXPECT_EQ(closed->close_reason, "finished");
  EXPECT_EQ(closed->sample_count, records.size());
  EXPECT_NEAR(closed->duration_s, 65.42, 0.01);
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM chunks"), 3) << "6543 samples fold into 30 s chunks";
  EXPECT_EQ(closed->gap_count, 0U);
  EXPECT_EQ(number_of(database, "SELECT folded FROM sessions"), 1);
}

TEST(Writer, one_long_span_is_taken_whole) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  Walk walk(12);
  const std::vector<TickRecord> records = walk.records(0, 15000);
  ASSERT_TRUE(writer.append_ticks(records).ok());
  EXPECT_EQ(writer.refused_samples(), 0U);
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  expect_recorded(database, *id, records);
}

TEST(Writer, missing_and_impossible_samples_become_gaps) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  Walk walk(13);
  std::vector<TickRecord> records = walk.records(10, 60);
  const auto append = [&](std::size_t from, std::size_t to) { return writer.append_ticks(std::span(records).subspan(from, to - from)); };
  records[20].x_m = std::numeric_limits<float>::quiet_NaN();
  records[21].x_m = std::numeric_limits<float>::infinity();
  records[22].speed_m_s = 1e30F;
  records[23].time_ns = records[19].time_ns;
  ASSERT_TRUE(append(0, 30).ok());
  ASSERT_TRUE(append(35, 40).ok());  // five never came
  ASSERT_TRUE(writer.append_gap("ticks", records[40].tick, records[44].tick, "ring_overrun").ok());
  ASSERT_TRUE(append(45, 60).ok());
  EXPECT_EQ(writer.refused_samples(), 4U);
  // A step backwards is refused, and the rest is kept.
  const Status back = append(50, 51);
  ASSERT_FALSE(back.ok());
  EXPECT_EQ(back.error().kind, ErrorKind::bad_value);
  EXPECT_EQ(back.error().field, "tick");
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());

  const Result<std::vector<Gap>> gaps = SessionReader(database).gaps(*id);
  ASSERT_TRUE(gaps.ok());
  ASSERT_EQ(gaps->size(), 5U);
  const auto gap = [&](std::size_t i) { return (*gaps)[i]; };
  EXPECT_EQ(gap(0).reason, "not_finite");
  EXPECT_EQ(gap(0).from_tick, 30U);
  EXPECT_EQ(gap(0).to_tick, 31U);
  EXPECT_EQ(gap(1).reason, "out_of_range");
  EXPECT_EQ(gap(2).reason, "time_not_rising");
  EXPECT_EQ(gap(3).reason, "not_received");
  EXPECT_EQ(gap(3).from_tick, 40U);
  EXPECT_EQ(gap(3).to_tick, 44U);
  EXPECT_EQ(gap(4).reason, "ring_overrun");

  std::vector<TickRecord> expected;
  for (std::size_t i = 0; i < records.size(); ++i)
    if ((i < 20 || i > 23) && (i < 30 || i > 34) && (i < 40 || i > 44)) expected.push_back(records[i]);
  expect_recorded(database, *id, expected);
  const std::vector<std::string> none;
  const Result<Columns> columns = SessionReader(database).read_columns(*id, none);
  ASSERT_TRUE(columns.ok());
  std::vector<std::uint64_t> after_gap;
  for (std::size_t i = 0; i < columns->tick.size(); ++i)
    if (columns->gap_before[i] != 0) after_gap.push_back(columns->tick[i]);
  EXPECT_EQ(after_gap, (std::vector<std::uint64_t>{34, 45, 55}));
}

TEST(Writer, a_step_that_the_core_never_made_is_not_called_lost) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  Walk walk(14);
  std::vector<TickRecord> records = walk.records(100, 60);
  for (TickRecord& record : records) record.missed_ticks = 3;
  for (std::size_t i = 15; i < 60; ++i) records[i].missed_ticks = 8;   // all of 110 to 114
  for (std::size_t i = 45; i < 60; ++i) records[i].missed_ticks = 10;  // two of 140 to 144
  for (const auto& [from, to] : {std::pair<std::size_t, std::size_t>{0, 10}, {15, 25}, {30, 40}, {45, 60}})
    ASSERT_TRUE(writer.append_ticks(std::span(records).subspan(from, to - from)).ok());
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  const Result<std::vector<Gap>> gaps = SessionReader(database).gaps(*id);
  ASSERT_TRUE(gaps.ok());
  ASSERT_EQ(gaps->size(), 3U);
  const auto gap = [&](std::size_t i) { return (*gaps)[i]; };
  EXPECT_EQ(gap(0).reason, "step_left_out");
  EXPECT_EQ(gap(0).from_tick, 110U);
  EXPECT_EQ(gap(0).to_tick, 114U);
  EXPECT_EQ(gap(1).reason, "not_received");
  EXPECT_EQ(gap(1).from_tick, 125U);
  EXPECT_EQ(gap(2).reason, "not_received+step_left_out") << "which of them, nobody can tell";
  EXPECT_EQ(gap(2).from_tick, 140U);
  EXPECT_EQ(gap(2).to_tick, 144U);
}

TEST(Writer, events_markers_parameters_and_frames_come_back) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  SessionStart start = start_of_walk();
  std::vector<double> values;
  for (const contract::ParamInfo& p : contract::kParams) values.push_back(p.default_value);
  start.parameter_values = values;
  start.exercise_json = R"({"shape": "eight", "centre_m": 1.0, "radius_m": 0.8})";
  const Result<SessionId> id = writer.begin(start);
  ASSERT_TRUE(id.ok()) << id.error().message;
  Event raised;
  raised.tick = 5;
  raised.time_ns = kStart_ns + 50'000'000;
  raised.kind = EventKind::fault_raised;
  raised.code = static_cast<std::uint32_t>(contract::Fault::bumper_pressed);
  Event changed;
  changed.kind = EventKind::parameter_changed;
  changed.item = contract::kParams[3].id;
  changed.value = 0.125;
  changed.before = std::numeric_limits<double>::quiet_NaN();
  Event unknown;
  unknown.kind = EventKind::fault_cleared;
  unknown.code = contract::kFaultPlaces - 1;
  ASSERT_TRUE(writer.append_events(std::vector<Event>{raised, changed}).ok());
  ASSERT_TRUE(writer.commit().ok());
  ASSERT_TRUE(writer.append_events(std::vector<Event>{unknown}).ok());
  ASSERT_TRUE(writer.append_marker(7, kStartUtc_ns + 70'000'000, "first step ≈ \"good\"", {}, "good").ok());
  std::vector<BusRecord> frames;
  for (std::uint64_t i = 0; i < 34567; ++i) {
    BusRecord f;
    f.time_ns = kStart_ns + i * 1'000'000;
    f.id = 0x180 + static_cast<std::uint32_t>(i % 10);
    f.dlc = 8;
    f.sent = static_cast<std::uint8_t>(i % 2);
    f.data = i * 0x0001'0003'0007'000BULL;
    frames.push_back(f);
  }
  for (std::size_t i = 0; i < frames.size(); i += 321) {
    ASSERT_TRUE(writer.append_bus(std::span(frames).subspan(i, std::min<std::size_t>(321, frames.size() - i))).ok());
    if (i % 2 == 0) {
      ASSERT_TRUE(writer.commit().ok());
    }
  }
  ASSERT_TRUE(writer.end(CloseReason::core_restarted, kStartUtc_ns).ok());

  const SessionReader reader(database);
  const Result<std::vector<StoredEvent>> events = reader.events(*id);
  ASSERT_TRUE(events.ok());
  ASSERT_EQ(events->size(), 3U);
  EXPECT_EQ((*events)[0].kind_name, "fault_raised");
  EXPECT_EQ((*events)[0].name, "bumper_pressed");
  EXPECT_EQ((*events)[1].name, contract::kParams[3].name);
  EXPECT_EQ((*events)[1].value, 0.125);
  EXPECT_TRUE(std::isnan((*events)[1].before));
  EXPECT_EQ((*events)[2].name, "");
  const auto markers = reader.markers(*id);
  ASSERT_TRUE(markers.ok());
  ASSERT_EQ(markers->size(), 1U);
  EXPECT_EQ((*markers)[0].text, "first step ≈ \"good\"");
  EXPECT_EQ((*markers)[0].kind, "good");
  const auto parameters = reader.parameters(*id);
  ASSERT_TRUE(parameters.ok());
  ASSERT_EQ(parameters->size(), contract::kParamCount);
  EXPECT_EQ(parameters->front().first, contract::kParams[0].name);
  EXPECT_EQ(parameters->front().second, contract::kParams[0].default_value);
  for (const auto& [first, limit] : {std::pair<std::uint64_t, std::size_t>{0, 100000}, {29990, 20}, {34566, 5}, {40000, 5}}) {
    const auto back = reader.bus_frames(*id, first, limit);
    ASSERT_TRUE(back.ok());
    const std::size_t expected = first >= frames.size() ? 0 : std::min<std::size_t>(limit, frames.size() - first);
    ASSERT_EQ(back->size(), expected);
    for (std::size_t i = 0; i < expected; ++i) {
      EXPECT_EQ((*back)[i].data, frames[first + i].data);
      EXPECT_EQ((*back)[i].time_ns, frames[first + i].time_ns);
      EXPECT_EQ((*back)[i].id, frames[first + i].id);
      EXPECT_EQ((*back)[i].sent, frames[first + i].sent);
    }
  }
  EXPECT_EQ(reader.get(*id)->close_reason, "core_restarted");
}

TEST(Markers, one_comes_into_an_ended_session_and_none_into_one_under_way) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  const SessionId ended = record_session(database, 100, 1);
  SessionWriter writer = writer_of(database);
  const auto under_way = writer.begin(start_of_walk());
  ASSERT_TRUE(under_way.ok());
  MarkerStore store(database);
  const Marker marker{
      .tick = 40, .utc_ns = kStartUtc_ns + 400'000'000, .text = "late", .actor = Actor{"berg", "therapist", "rest", "script"}};
  EXPECT_TRUE(store.add(ended, marker).ok());
  EXPECT_TRUE(store.add(ended, marker).ok());
  const auto markers = store.list(ended, -1, 10);
  ASSERT_TRUE(markers.ok());
  ASSERT_EQ(markers->size(), 2U);
  EXPECT_EQ(markers->front().number + 1, markers->back().number);
  EXPECT_EQ(markers->front().marker.text, "late");
  EXPECT_EQ(markers->front().marker.tick, 40U);
  EXPECT_EQ(markers->front().marker.actor->user, "berg");
  EXPECT_EQ(store.add(*under_way, marker).error().kind, ErrorKind::wrong_state);
  EXPECT_EQ(store.add(99, marker).error().kind, ErrorKind::not_found);
  EXPECT_EQ(store.add(ended, {.text = std::string(501, 'a'), .actor = {}}).error().field, "text");
}

TEST(Writer, wrong_calls_are_refused_by_name_and_change_nothing) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  Walk walk(1);
  const auto refused = [](const auto& result, ErrorKind kind, const std::string& field) {
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().kind, kind);
    EXPECT_EQ(result.error().field, field);
    EXPECT_FALSE(result.error().message.empty());
  };
  refused(writer.append_ticks(walk.records(0, 1)), ErrorKind::wrong_state, "");
  refused(writer.commit(), ErrorKind::wrong_state, "");
  refused(writer.end(CloseReason::finished, 0), ErrorKind::wrong_state, "");
  SessionStart start = start_of_walk();
  start.subject = std::string(65, 'a');
  refused(writer.begin(start), ErrorKind::bad_value, "subject");
  start = start_of_walk();
  start.subject = "line\nbreak";
  refused(writer.begin(start), ErrorKind::bad_value, "subject");
  start = start_of_walk();
  start.note = "bad \xff utf-8";
  refused(writer.begin(start), ErrorKind::bad_value, "note");
  start = start_of_walk();
  start.exercise_json = R"({"shape": "circle"})";
  refused(writer.begin(start), ErrorKind::bad_value, "exercise");
  start = start_of_walk();
  const std::vector<double> three{1, 2, 3};
  start.parameter_values = three;
  refused(writer.begin(start), ErrorKind::bad_value, "parameter_values");
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM sessions"), 0);
  ASSERT_TRUE(writer.begin(start_of_walk()).ok());
  refused(writer.begin(start_of_walk()), ErrorKind::wrong_state, "");
  refused(writer.append_gap("video", 1, 2, "x"), ErrorKind::bad_value, "stream");
  refused(writer.append_gap("ticks", 3, 2, "x"), ErrorKind::bad_value, "to_tick");
  refused(writer.append_gap("ticks", 1, 2, ""), ErrorKind::bad_value, "reason");
  refused(writer.append_marker(1, 1, std::string(501, 'a')), ErrorKind::bad_value, "text");
  refused(writer.append_marker(1, 1, "a", {}, "joke"), ErrorKind::bad_value, "kind");
}

// H24
TEST(Writer, a_full_disk_is_told_and_what_fits_later_is_complete) {
  TemporaryFolder dir;
  OpenOptions options;
  options.max_pages = 60;  // 240 kB: the first minute does not fit
  Database database = open_at(dir / "hoist.db", options);
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  ASSERT_TRUE(id.ok());
  Walk walk(14);
  const std::vector<TickRecord> records = walk.records(0, 14000);
  std::size_t errors = 0;
  for (std::size_t i = 0; i < records.size(); i += 5) {
    const Status status = writer.append_ticks(std::span(records).subspan(i, 5));
    if (!status) {
      EXPECT_EQ(status.error().kind, ErrorKind::disk_full) << status.error().message;
      ++errors;
    }
  }
  EXPECT_GT(errors, 5U);
  EXPECT_LT(errors, 400U) << "a full disk must not be asked at every tick";
  EXPECT_EQ(writer.failed_commits(), errors);
  const Durable before = writer.durable();
  ASSERT_TRUE(before.last_tick.has_value());
  EXPECT_LT(*before.last_tick, 13999U);
  EXPECT_GT(writer.refused_samples(), 0U) << "memory is bounded";
  EXPECT_FALSE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  EXPECT_TRUE(writer.recording());
  // What was acknowledged is readable while the disk is full.
  {
    const std::vector<TickRecord> durable(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(before.samples));
    expect_recorded(database, *id, durable);
  }
  // Space again: the minute in memory is kept, the rest is one explicit gap.
  execute(database.handle(), "PRAGMA max_page_count = 100000");
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  const auto gaps = SessionReader(database).gaps(*id);
  ASSERT_TRUE(gaps.ok());
  ASSERT_EQ(gaps->size(), 1U);
  EXPECT_EQ(gaps->front().reason, "storage");
  EXPECT_EQ(gaps->front().to_tick, 13999U);
  const std::vector<TickRecord> expected(records.begin(), records.begin() + static_cast<std::ptrdiff_t>(gaps->front().from_tick));
  EXPECT_GE(expected.size(), before.samples + kMaxPendingSamples - kCommitSamples);
  expect_recorded(database, *id, expected);
}

// As the recorder feeds it: the steps of a pass, then their frames.
TEST(Writer, a_disk_that_stays_full_costs_one_gap_of_each_stream) {
  TemporaryFolder dir;
  OpenOptions options;
  options.max_pages = 60;
  Database database = open_at(dir / "hoist.db", options);
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  ASSERT_TRUE(id.ok());
  Walk walk(14);
  constexpr std::uint64_t kPerStep = 20;
  const auto pass = [&](std::uint64_t first) {
    const std::vector<TickRecord> records = walk.records(first, 5);
    std::vector<BusRecord> frames;
    std::vector<Event> events;
    for (const TickRecord& record : records) {
      for (std::uint64_t k = 0; k < kPerStep; ++k) {
        BusRecord frame;
        frame.time_ns = record.time_ns - 100'000 * (kPerStep - k);
        frame.data = record.tick;
        frames.push_back(frame);
      }
      Event event;
      event.tick = record.tick;
      if (record.tick % 3 != 0) events.insert(events.end(), 2, event);
    }
    (void)writer.append_ticks(records);
    (void)writer.append_events(events);
    (void)writer.append_bus(frames);
  };
  std::uint64_t tick = 0;
  for (; tick < 12000; tick += 5) pass(tick);
  execute(database.handle(), "PRAGMA max_page_count = 100000");
  ASSERT_TRUE(writer.commit().ok());
  for (; tick < 12100; tick += 5) pass(tick);
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  const auto gaps = SessionReader(database).gaps(*id);
  ASSERT_TRUE(gaps.ok());
  ASSERT_EQ(gaps->size(), 3U);
  const auto frames = SessionReader(database).bus_frames(*id, 0, 1'000'000);
  const auto after = std::ranges::adjacent_find(*frames, [](const BusRecord& a, const BusRecord& b) { return b.data > a.data + 1; });
  ASSERT_NE(after, frames->end());
  for (const Gap& gap : *gaps) {
    EXPECT_EQ(gap.reason, "storage") << gap.stream;
    EXPECT_NEAR(static_cast<double>(gap.to_tick), 11999, 1) << gap.stream;
    if (gap.stream == "bus") {
      EXPECT_EQ(gap.from_tick, after->data + 1) << "the first step whose frames found no room";
    }
  }
}

TEST(Writer, more_gaps_than_may_wait_stretch_the_newest_of_their_stream) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  ASSERT_TRUE(writer.append_gap("ticks", 1, 2, "not_received").ok());
  for (std::uint64_t i = 1; i < kMaxPendingRows; ++i) ASSERT_TRUE(writer.append_gap("bus", 10 * i, 10 * i, "recorder_late").ok());
  ASSERT_TRUE(writer.append_gap("ticks", 200'000, 200'001, "not_received").ok());
  ASSERT_TRUE(writer.append_gap("bus", 300'000, 300'001, "recorder_late").ok());
  ASSERT_TRUE(writer.append_gap("events", 400'000, 400'001, "recorder_late").ok());
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  const auto gaps = SessionReader(database).gaps(*id);
  EXPECT_EQ(gaps->size(), kMaxPendingRows + 1) << "a stream without a gap gets its first";
  std::map<std::string, std::uint64_t> until;
  for (const Gap& gap : *gaps) until[gap.stream] = std::max(until[gap.stream], gap.to_tick);
  EXPECT_EQ(until, (std::map<std::string, std::uint64_t>{{"ticks", 200'001}, {"bus", 300'001}, {"events", 400'001}}));
}

TEST(Writer, a_locked_database_is_busy_and_loses_nothing) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  sqlite3_busy_timeout(database.handle(), 1);
  Database other = std::move(*Database::attach(dir / "hoist.db"));
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  Walk walk(15);
  const std::vector<TickRecord> records = walk.records(0, 130);
  {
    Transaction lock(other.handle(), Transaction::Kind::write);
    const Status status = writer.append_ticks(records);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().kind, ErrorKind::busy);
  }
  ASSERT_TRUE(writer.commit().ok());
  expect_recorded(other, *id, records);
}

TEST(Writer, sessions_left_open_are_closed_as_interrupted_and_folded_later) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  Walk walk(16);
  const std::vector<TickRecord> records = walk.records(0, 730);
  {
    SessionWriter writer = writer_of(database);
    ASSERT_TRUE(writer.begin(start_of_walk()).ok());
    ASSERT_TRUE(writer.append_ticks(records).ok());
    ASSERT_TRUE(writer.commit().ok());
  }
  SessionWriter next = writer_of(database);
  ASSERT_EQ(next.interrupted().size(), 1U);
  const SessionId id = next.interrupted()[0];
  const Result<SessionInfo> info = SessionReader(database).get(id);
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->close_reason, "interrupted");
  EXPECT_EQ(info->ended_utc_ns, kStartUtc_ns + static_cast<std::int64_t>(records.back().time_ns - kStart_ns));
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM chunks"), 8) << "a recording can begin before anything is folded";
  expect_recorded(database, id, records);
  while (*next.fold_piece()) {
  }
  EXPECT_EQ(number_of(database, "SELECT count(*) FROM chunks"), 1);
  expect_recorded(database, id, records);
  EXPECT_TRUE(writer_of(database).interrupted().empty());
}

// However long a session was, a piece joins one group of its chunks, and readers find the same before and after it.
TEST(Writer, a_session_is_folded_piece_by_piece) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  Walk walk(18);
  const std::vector<TickRecord> records = walk.records(0, 9050);
  std::vector<BusRecord> frames(2 * kFoldedBusFrames);
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].time_ns = kStart_ns + i;
  const auto count = [&](const char* table) { return number_of(database, ("SELECT count(*) FROM " + std::string(table)).c_str()); };
  const auto record = [&](SessionWriter& writer) {
    const Result<SessionId> id = writer.begin(start_of_walk());
    EXPECT_TRUE(id.ok() && writer.append_bus(frames).ok() && writer.append_ticks(records).ok());
    EXPECT_TRUE(writer.close(CloseReason::finished, kStartUtc_ns).ok());
    return *id;
  };
  SessionId first = 0;
  {
    SessionWriter writer = writer_of(database);
    first = record(writer);
    EXPECT_EQ(count("chunks"), 91);
    for (int i = 0; i < 2; ++i) EXPECT_TRUE(*writer.fold_piece());
    EXPECT_EQ(count("chunks"), 33) << "30 s in each piece";
  }
  // The next run goes on, and recording does not wait for it.
  SessionWriter writer = writer_of(database);
  const Result<SessionId> second = writer.begin(start_of_walk());
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(count("chunks"), 33);
  std::int64_t before = count("chunks") + count("bus_chunks");
  for (int pieces = 0; *writer.fold_piece(); ++pieces) {
    const std::int64_t now = count("chunks") + count("bus_chunks");
    ASSERT_GE(now, before - 29) << "one group in piece " << pieces;
    before = now;
    ASSERT_LT(pieces, 20);
    if (pieces % 3 == 0) expect_recorded(database, first, records);
  }
  EXPECT_EQ(count("chunks"), 4);
  EXPECT_EQ(count("bus_chunks"), 2);
  EXPECT_EQ(number_of(database, "SELECT min(folded) FROM sessions WHERE ended_utc_ns IS NOT NULL"), 1);
  expect_recorded(database, first, records);
  EXPECT_EQ(SessionReader(database).bus_frames(first, 0, frames.size() + 1)->size(), frames.size());
  EXPECT_FALSE(*writer.fold_piece()) << "nothing is left";
  ASSERT_TRUE(writer.close(CloseReason::finished, kStartUtc_ns).ok());
  // A session that is deleted in between is not written any more.
  const SessionId third = record(writer);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(*writer.fold_piece());
  Database other = std::move(*Database::attach(dir / "hoist.db"));
  ASSERT_TRUE(take_out(other, third).ok());
  const std::int64_t left = count("chunks");
  EXPECT_GT(left, 8);
  EXPECT_FALSE(*writer.fold_piece());
  EXPECT_EQ(count("chunks"), left);
}

TEST(Reader, pages_run_from_the_newest_to_the_oldest) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  for (int i = 0; i < 23; ++i) {
    SessionStart start = start_of_walk();
    start.subject = i % 4 == 0 ? "A" : "B";
    ASSERT_TRUE(writer.begin(start).ok());
    ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  }
  const SessionReader reader(database);
  SessionQuery query;
  query.limit = 10;
  std::vector<SessionId> seen;
  do {
    const Result<SessionPage> page = reader.list(query);
    ASSERT_TRUE(page.ok());
    EXPECT_EQ(page->total, 23U);
    EXPECT_LE(page->sessions.size(), 10U);
    for (const SessionInfo& session : page->sessions) seen.push_back(session.id);
    query.before = page->next;
  } while (query.before);
  ASSERT_EQ(seen.size(), 23U);
  EXPECT_TRUE(std::ranges::is_sorted(seen, std::ranges::greater{}));
  query = {};
  query.subject = "A";
  EXPECT_EQ(reader.list(query)->total, 6U);
  EXPECT_EQ(reader.list(query)->sessions.size(), 6U);
  query.limit = 0;
  EXPECT_EQ(reader.list(query).error().field, "limit");
  query.limit = kMaxPage + 1;
  EXPECT_EQ(reader.list(query).error().field, "limit");
}

TEST(Reader, the_sessions_of_a_patient_are_all_of_that_patient_and_no_others) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  for (const char* code : {"P-1", "P-10", "p-1", "", "P-10", "P-1"}) {
    SessionStart start = start_of_walk();
    if (*code != 0) start.subject = code;
    ASSERT_TRUE(writer.begin(start).ok());
    ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  }
  const SessionReader reader(database);
  const SessionId first = 1;
  const auto visit = VisitReader(database).of_sessions(std::span(&first, 1));
  ASSERT_TRUE(visit.ok());
  SessionQuery query{.limit = 2, .before = {}, .subject = {}, .patient = visit->at(first).patient_id};
  std::vector<SessionId> seen;
  do {
    const Result<SessionPage> page = reader.list(query);
    ASSERT_TRUE(page.ok());
    EXPECT_EQ(page->total, 3U);
    for (const SessionInfo& session : page->sessions) seen.push_back(session.id);
    query.before = page->next;
  } while (query.before);
  EXPECT_EQ(seen, (std::vector<SessionId>{6, 3, 1}));
}

TEST(Reader, a_search_finds_part_of_a_code_in_capital_or_small_letters) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  for (const char* code : {"P-017", "p-0170", "MÜL-3", "ŽAK_1", "100%"}) {  // the last one from before the rule
    SessionStart start = start_of_walk();
    start.subject = code;
    ASSERT_TRUE(writer.begin(start).ok());
    ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  }
  const SessionReader reader(database);
  const auto found = [&](const char* wanted) {
    SessionQuery query;
    query.subject = wanted;
    const Result<SessionPage> page = reader.list(query);
    EXPECT_EQ(page->total, page->sessions.size()) << wanted;
    return page->total;
  };
  EXPECT_EQ(found("017"), 2U);
  EXPECT_EQ(found("P-017"), 2U);
  EXPECT_EQ(found("p-0170"), 1U);
  EXPECT_EQ(found("mül"), 1U);
  EXPECT_EQ(found("MÜL"), 1U);
  EXPECT_EQ(found("žak"), 1U);
  EXPECT_EQ(found("%"), 1U) << "no wildcard";
  EXPECT_EQ(found("_"), 1U) << "no wildcard";
  EXPECT_EQ(found("P-018"), 0U);
}

TEST(Reader, unknown_sessions_columns_and_ranges_are_refused) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  const SessionId id = record_session(database, 300, 2);
  const SessionReader reader(database);
  EXPECT_EQ(reader.get(id + 1).error().kind, ErrorKind::not_found);
  EXPECT_EQ(reader.columns(id + 1).error().kind, ErrorKind::not_found);
  const std::vector<std::string> unknown{"x_m", "no_such_m"};
  EXPECT_EQ(reader.read_columns(id, unknown).error().field, "columns");
  EXPECT_EQ(reader.read_columns(id + 1, {}).error().kind, ErrorKind::not_found);
  EXPECT_EQ(reader.read_columns(id, {}, {2, 1}).error().field, "range");
  EXPECT_EQ(reader.read_columns(id, {}, {std::nan(""), 1}).error().field, "range");
  EXPECT_EQ(reader.overview(id, {}, 0).error().field, "runs");
  EXPECT_EQ(reader.overview(id, {}, kMaxOverviewRuns + 1).error().field, "runs");
}

TEST(Reader, a_time_range_gives_exactly_its_samples) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  std::vector<TickRecord> records;
  const SessionId id = record_session(database, 7000, 3, &records);
  const SessionReader reader(database);
  const std::vector<std::string> names{"x_m", "mode", "left_alpha_rad"};
  for (const auto& [from_s, to_s] :
       {std::pair{0.0, 1.0}, {12.34, 12.35}, {29.0, 31.5}, {69.5, 1000.0}, {80.0, 90.0}, {-5.0, 0.2}, {3.0, 3.0}}) {
    const Result<Columns> columns = reader.read_columns(id, names, {from_s, to_s});
    ASSERT_TRUE(columns.ok());
    std::size_t at = 0;
    for (const TickRecord& record : records) {
      const double time_s = static_cast<double>(record.time_ns - kStart_ns) / 1e9;
      if (time_s < from_s || time_s >= to_s) continue;
      ASSERT_LT(at, columns->tick.size());
      EXPECT_EQ(columns->tick[at], record.tick);
      EXPECT_EQ(columns->time_s[at], time_s);
      EXPECT_EQ(columns->values[0][at], kept(record, "x_m"));
      EXPECT_EQ(columns->values[1][at], record.mode);
      EXPECT_EQ(columns->values[2][at], kept(record, "left_alpha_rad"));
      ++at;
    }
    EXPECT_EQ(at, columns->tick.size());
  }
}

TEST(Reader, the_overview_holds_every_extreme_at_every_resolution) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  std::vector<TickRecord> records;
  const SessionId id = record_session(database, 20000, 4, &records);
  const SessionReader reader(database);
  const std::vector<std::string> names{"x_m", "left_alpha_rad", "mode", "left_counts"};
  for (const std::size_t runs : {1, 7, 40, 150, 1000, 4000}) {
    const Result<Overview> overview = reader.overview(id, names, runs);
    ASSERT_TRUE(overview.ok());
    const std::size_t count = overview->from_s.size();
    ASSERT_GT(count, 0U);
    ASSERT_LE(count, runs);
    if (runs >= 7) {
      EXPECT_GE(count * 4, std::min<std::size_t>(runs, 160)) << "not much coarser than asked";
    }
    std::size_t run = 0;
    std::vector<double> low(names.size(), 1e300), high(names.size(), -1e300);
    const auto check = [&] {
      for (std::size_t c = 0; c < names.size(); ++c) {
        EXPECT_EQ(overview->min[c][run], low[c]) << names[c] << " run " << run << " of " << runs;
        EXPECT_EQ(overview->max[c][run], high[c]) << names[c] << " run " << run << " of " << runs;
      }
    };
    for (const TickRecord& record : records) {
      const double time_s = static_cast<double>(record.time_ns - kStart_ns) / 1e9;
      if (time_s > overview->to_s[run]) {
        check();
        ++run;
        ASSERT_LT(run, count);
        EXPECT_EQ(overview->from_s[run], time_s);
        low.assign(names.size(), 1e300);
        high.assign(names.size(), -1e300);
      }
      for (std::size_t c = 0; c < names.size(); ++c) {
        low[c] = std::min(low[c], kept(record, names[c]));
        high[c] = std::max(high[c], kept(record, names[c]));
      }
    }
    check();
    EXPECT_EQ(run + 1, count);
    EXPECT_TRUE(std::ranges::none_of(overview->gap_before, [](auto flag) { return flag != 0; }));
  }
  // A narrow range is drawn from samples, and only from those inside.
  const Result<Overview> narrow = reader.overview(id, names, 500, {10.0, 20.0});
  ASSERT_TRUE(narrow.ok());
  EXPECT_TRUE(narrow->exact_range);
  EXPECT_EQ(narrow->from_s.size(), 500U);
  EXPECT_GE(narrow->from_s.front(), 10.0);
  EXPECT_LT(narrow->to_s.back(), 20.0);
  EXPECT_FALSE(reader.overview(id, names, 10)->exact_range);
}

TEST(Reader, a_long_overview_touches_no_body) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  const SessionId id = record_session(database, 20000, 4);
  // Unreadable chunk bodies: directory data still works, samples return an error.
  execute(database.handle(), "UPDATE chunks SET body = zeroblob(length(body))");
  const SessionReader reader(database);
  const std::vector<std::string> names{"x_m"};
  EXPECT_TRUE(reader.overview(id, names, 100).ok());
  const Result<Columns> columns = reader.read_columns(id, names, {35, 36});
  ASSERT_FALSE(columns.ok());
  EXPECT_EQ(columns.error().kind, ErrorKind::corrupt);
  EXPECT_EQ(columns.error().message, "session " + std::to_string(id) + ", chunk of samples from tick 3000: its body is damaged");
}

TEST(Reader, gaps_show_in_the_overview) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  Walk walk(5);
  ASSERT_TRUE(writer.append_ticks(walk.records(0, 5000)).ok());
  ASSERT_TRUE(writer.append_ticks(walk.records(5400, 5000)).ok());
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  for (const std::size_t runs : {10U, 3000U}) {
    const Result<Overview> overview = SessionReader(database).overview(*id, {}, runs);
    ASSERT_TRUE(overview.ok());
    EXPECT_EQ(std::ranges::count(overview->gap_before, 1), 1);
  }
}

TEST(Writer, all_places_of_the_faults_come_back_also_from_when_there_were_32) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  SessionWriter writer = writer_of(database);
  const Result<SessionId> id = writer.begin(start_of_walk());
  ASSERT_TRUE(id.ok());
  Walk walk(12);
  std::vector<TickRecord> records = walk.records(0, 200);
  for (std::size_t i = 0; i < records.size(); ++i) records[i].fault_bits = std::uint64_t{1} << (i % contract::kFaultPlaces);
  records[0].fault_bits = (std::uint64_t{1} << contract::kFaultPlaces) - 1;
  ASSERT_TRUE(writer.append_ticks(records).ok());
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns + 2'000'000'000).ok());
  expect_recorded(database, *id, records);
  const std::vector<std::string> faults{"fault_bits"};
  // As a session says that was recorded when the column had 32 bits.
  for (const char* type : {"u64", "u32"}) {
    SCOPED_TRACE(type);
    Statement(database.handle(), "UPDATE column_layout SET type = ?1 WHERE name = 'fault_bits'").text(1, std::string_view(type)).run();
    const Result<Columns> columns = SessionReader(database).read_columns(*id, faults);
    ASSERT_TRUE(columns.ok());
    for (std::size_t i = 0; i < records.size(); ++i)
      ASSERT_EQ(static_cast<std::uint64_t>(columns->values[0][i]), records[i].fault_bits) << i;
  }
}

TEST(Reader, a_recording_with_other_columns_stays_readable) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  std::vector<TickRecord> records;
  const SessionId id = record_session(database, 500, 6, &records);
  // As if an older Hoist had called this column otherwise, in other units and steps.
  Statement(database.handle(), "UPDATE column_layout SET name = 'seat_height_mm', unit = 'mm', lsb = 1e-2, decimals = 2 WHERE name = 'x_m'")
      .run();
  const SessionReader reader(database);
  const std::vector<std::string> gone{"x_m"}, old{"seat_height_mm", "y_m"};
  EXPECT_EQ(reader.read_columns(id, gone).error().field, "columns");
  const Result<Columns> columns = reader.read_columns(id, old);
  ASSERT_TRUE(columns.ok());
  EXPECT_EQ(columns->info[0].unit, "mm");
  EXPECT_EQ(columns->values[0][100], static_cast<double>(std::llrint(kept(records[100], "x_m") * 1e5)) / 100);
  EXPECT_EQ(columns->values[1][100], kept(records[100], "y_m"));
}

TEST(Editor, patches_all_or_nothing) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  const SessionId id = record_session(database, 10, 8);
  SessionEditor editor(database);
  SessionPatch patch;
  patch.note = "Went well.\nTired at the end.";
  patch.subject = std::optional<std::string>{};
  patch.exercise_json = std::optional<std::string>(R"({"shape":"square","side_m":3.2})");
  ASSERT_TRUE(editor.patch(id, patch).ok());
  const SessionReader reader(database);
  EXPECT_EQ(reader.get(id)->note, "Went well.\nTired at the end.");
  EXPECT_FALSE(reader.get(id)->subject.has_value());
  EXPECT_EQ(reader.get(id)->exercise_json, R"({"shape":"square","side_m":3.2})");
  patch.note = "changed";
  patch.exercise_json = std::optional<std::string>(R"({"shape":"square","side_m":-1})");
  const Status refused = editor.patch(id, patch);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "exercise");
  EXPECT_EQ(reader.get(id)->note, "Went well.\nTired at the end.");
  EXPECT_EQ(editor.patch(id + 1, {}).error().kind, ErrorKind::not_found);
}

TEST(Editor, exercises_are_checked_field_by_field) {
  for (const char* good :
       {R"({"shape":"square","side_m":0.2})", R"({"shape":"eight","centre_m":1,"radius_m":1})", R"({"shape":"straight","length_m":100})"})
    EXPECT_TRUE(check_exercise(good).ok()) << good;
  for (const char* bad :
       {"", "7", "{}", R"({"shape":"square"})", R"({"shape":"square","side_m":"3"})", R"({"shape":"square","side_m":0.1})",
        R"({"shape":"square","side_m":3,"extra":1})", R"({"shape":"eight","centre_m":1,"radius_m":1.1})",
        R"({"shape":"straight","length_m":1e400})", R"({"shape":"straight","length_m":null})"})
    EXPECT_FALSE(check_exercise(bad).ok()) << bad;
}

TEST(Editor, deleting_takes_everything_and_never_a_session_being_recorded) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  Database other = std::move(*Database::attach(dir / "hoist.db"));
  const SessionId kept_session = record_session(database, 400, 9);
  SessionWriter writer = writer_of(database);
  SessionStart start = start_of_walk();
  start.note = "SECRET-NOTE-OF-A-PATIENT";
  const Result<SessionId> id = writer.begin(start);
  Walk walk(10);
  ASSERT_TRUE(writer.append_ticks(walk.records(0, 400)).ok());
  ASSERT_TRUE(writer.append_marker(1, 1, "SECRET-MARKER").ok());
  ASSERT_TRUE(writer.commit().ok());
  SessionEditor editor(other);
  EXPECT_EQ(editor.remove(*id).error().kind, ErrorKind::wrong_state);
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
  ASSERT_TRUE(editor.remove(*id).ok());
  EXPECT_EQ(editor.remove(*id).error().kind, ErrorKind::not_found);
  for (const char* table : {"sessions", "chunks", "markers", "parameters"}) {
    const std::string key = std::string(table) == "sessions" ? "id" : "session_id";
    EXPECT_EQ(number_of(database, ("SELECT count(*) FROM " + std::string(table) + " WHERE " + key + " = " + std::to_string(*id)).c_str()),
              0)
        << table;
  }
  EXPECT_EQ(SessionReader(database).get(kept_session)->sample_count, 400U);
  // A number is never reused.
  EXPECT_GT(*writer.begin(start_of_walk()), *id);
  // The texts are gone from the file, not only from the tables.
  for (const char* name : {"hoist.db", "hoist.db-wal"}) {
    std::ifstream stream(dir / name, std::ios::binary);
    const std::string content((std::istreambuf_iterator<char>(stream)), {});
    EXPECT_EQ(content.find("SECRET-"), std::string::npos) << name;
  }
}

// A reader in the recorder's program, then another program: the last one to close must not take the recorder for gone, and its log with it.
TEST(Locks, another_program_never_takes_the_log_from_under_the_recorder) {
  TemporaryFolder dir;
  const std::filesystem::path file = dir / "hoist.db";
  Database database = open_at(file);
  auto writer = SessionWriter::create(database);
  ASSERT_TRUE(writer.ok() && writer->begin(start_of_walk()).ok());
  Walk walk(5);
  ASSERT_TRUE(writer->append_ticks(walk.records(1, 100)).ok() && writer->commit().ok());
  { ASSERT_TRUE(Database::attach(file).ok()); }
  const hoist::test::ShellResult told = hoist::test::run_shell(std::string(HOIST_BINARY_DIR) + "/bin/hoist sessions " + file.string());
  ASSERT_EQ(told.exit_code, 0) << told.output;
  EXPECT_TRUE(std::filesystem::exists(file.string() + "-wal"));
  ASSERT_TRUE(writer->append_ticks(walk.records(101, 100)).ok() && writer->commit().ok());
  auto reader = Database::attach(file);
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  EXPECT_EQ(SessionReader(*reader).get(writer->session())->sample_count, 200U) << "acknowledged is on the disk";
}

TEST(Size, a_walk_takes_at_most_41_bytes_per_sample) {
  TemporaryFolder dir;
  Database database = open_at(dir / "hoist.db");
  const SessionId id = record_session(database, 30000, 17);
  const auto bytes = static_cast<double>(number_of(database, "SELECT sum(length(directory) + length(body)) FROM chunks")) / 30000;
  RecordProperty("bytes_per_sample", std::to_string(bytes));
  std::printf("  %.1f B per sample of %zu columns\n", bytes, contract::kSignalCount);
  EXPECT_LE(bytes, 41.0);
  const SessionReader reader(database);
  EXPECT_EQ(reader.get(id)->sample_count, 30000U);
  // The size of a session on disk, also of a folded one, also in lists.
  EXPECT_GE(static_cast<double>(reader.get(id)->stored_bytes), bytes * 30000);
  EXPECT_EQ(reader.list()->sessions.at(0).stored_bytes, reader.get(id)->stored_bytes);
}

}  // namespace
}  // namespace hoist::db::test
