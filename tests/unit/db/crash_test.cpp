#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>

#include "db/store/backup.hpp"
#include "db/store/deletion.hpp"
#include "db/store/retention.hpp"
#include "db/store/sqlite.hpp"
#include "tests/support/crash_disk.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

using contract::TickRecord;
using tests::CrashDisk;

// The message through the pipe after each commit.
struct Ack {
  SessionId session;
  std::uint64_t samples;
};

// Runs in the child until it is killed.
[[noreturn]] void record_until_killed(const std::filesystem::path& file, int pipe, std::uint32_t seed) {
  Result<Database> database = Database::open(file);
  if (!database) _exit(1);
  Result<SessionWriter> writer = SessionWriter::create(*database);
  if (!writer || !writer->begin(start_of_walk())) _exit(2);
  Walk walk(seed);
  for (std::uint64_t tick = 0;; tick += 5) {
    if (!writer->append_ticks(walk.records(tick, 5))) _exit(3);
    const Durable durable = writer->durable();
    const Ack ack{durable.session, durable.samples};
    if (tick % 25 == 0 && !writer->commit()) _exit(4);
    if (write(pipe, &ack, sizeof ack) != sizeof ack) _exit(5);
  }
}

// H25
TEST(Kill, what_was_acknowledged_survives_kill_9) {
  TemporaryFolder dir;
  for (std::uint32_t round = 0; round < 12; ++round) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      close(ends[0]);
      record_until_killed(dir / "hoist.db", ends[1], round);
    }
    close(ends[1]);
    Ack newest{0, 0};
    const std::uint64_t enough = 60 + 170 * round;
    // Killed somewhere after this many samples: the child is in the middle of something.
    for (Ack ack{}; newest.samples < enough;) {
      ASSERT_EQ(read(ends[0], &ack, sizeof ack), static_cast<ssize_t>(sizeof ack)) << "the writer ended by itself";
      newest = ack;
    }
    ASSERT_EQ(kill(child, SIGKILL), 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    for (Ack ack{}; read(ends[0], &ack, sizeof ack) == static_cast<ssize_t>(sizeof ack);) newest = ack;
    close(ends[0]);

    Result<Database> database = Database::open(dir / "hoist.db");
    ASSERT_TRUE(database.ok());
    EXPECT_EQ(damage_of(*database), "");
    EXPECT_FALSE(database->report().lost) << "the seal is never ahead of the file";
    Result<SessionWriter> writer = SessionWriter::create(*database);
    ASSERT_TRUE(writer.ok());
    ASSERT_EQ(writer->interrupted(), std::vector<SessionId>{newest.session});
    const std::uint64_t count = SessionReader(*database).get(newest.session)->sample_count;
    EXPECT_GE(count, newest.samples);
    Walk walk(round);
    expect_recorded(*database, newest.session, walk.records(0, count));
  }
}

// A short run: migrate, record, fold, delete, record again. Returns what was acknowledged before the power cut.
struct Life {
  bool opened = false;
  std::optional<SessionId> first, second;
  std::uint64_t first_samples = 0, second_samples = 0;
  bool first_ended = false, delete_asked = false, delete_done = false;
};

constexpr std::uint32_t kFirstSeed = 100, kSecondSeed = 200;

Life live(const OpenOptions& options) {
  Life life;
  Result<Database> database = Database::open("/hoist.db", options);
  if (!database) return life;
  life.opened = true;
  Result<SessionWriter> writer = SessionWriter::create(*database);
  if (!writer) return life;
  const auto record = [&](std::uint32_t seed, std::optional<SessionId>& id, std::uint64_t& samples) {
    const Result<SessionId> begun = writer->begin(start_of_walk());
    if (!begun) return false;
    id = *begun;
    Walk walk(seed);
    for (std::uint64_t tick = 0; tick < 300; tick += 25) {
      const bool well = writer->append_ticks(walk.records(tick, 25)).ok() && writer->commit().ok();
      samples = writer->durable().samples;
      if (!well) return false;
    }
    return true;
  };
  if (!record(kFirstSeed, life.first, life.first_samples)) return life;
  life.first_ended = writer->end(CloseReason::finished, kStartUtc_ns).ok();
  if (!life.first_ended) return life;
  life.delete_asked = true;
  life.delete_done = SessionEditor(*database).remove(*life.first).ok();
  if (!life.delete_done) return life;
  if (record(kSecondSeed, life.second, life.second_samples)) (void)writer->end(CloseReason::finished, kStartUtc_ns).ok();
  return life;
}

// Empty when the file after the cut holds everything that was acknowledged; otherwise what is wrong.
std::string verify(const Life& life, const OpenOptions& options) {
  Result<Database> database = Database::open("/hoist.db", options);
  if (!database) return "does not open: " + database.error().message;
  if (const std::string damage = damage_of(*database); !damage.empty()) return "was damaged: " + damage;
  Result<SessionWriter> writer = SessionWriter::create(*database);
  if (!writer) return "no writer: " + writer.error().message;
  for (auto more = writer->fold_piece(); !more || *more; more = writer->fold_piece())
    if (!more) return "not folded: " + more.error().message;
  const SessionReader reader(*database);
  const auto holds = [&](SessionId id, std::uint32_t seed, std::uint64_t samples) -> std::string {
    const std::vector<std::string> names{"x_m", "left_alpha_rad"};
    const Result<Columns> columns = reader.read_columns(id, names);
    if (!columns) return "session " + std::to_string(id) + ": " + columns.error().message;
    if (columns->tick.size() < samples) return "lost " + std::to_string(samples - columns->tick.size()) + " samples";
    Walk walk(seed);
    for (std::size_t i = 0; i < columns->tick.size(); ++i) {
      const TickRecord record = walk.record(i);
      if (columns->values[0][i] != kept(record, "x_m") || columns->values[1][i] != kept(record, "left_alpha_rad")) return "wrong sample";
    }
    return {};
  };
  if (life.first && !life.delete_asked)
    if (std::string wrong = holds(*life.first, kFirstSeed, life.first_samples); !wrong.empty()) return wrong;
  if (life.first && life.delete_asked) {
    // Deleted or not, never partly.
    const bool there = reader.get(*life.first).ok();
    if (there && life.delete_done) return "a deleted session came back";
    if (there)
      if (std::string wrong = holds(*life.first, kFirstSeed, life.first_samples); !wrong.empty()) return wrong;
  }
  // What was deleted before the cut is overwritten after it.
  for (auto more = erase_piece(*database); !more || *more; more = erase_piece(*database))
    if (!more) return "not erased: " + more.error().message;
  Statement left(database->handle(), "SELECT count(*) FROM chunks WHERE session_id NOT IN (SELECT id FROM sessions)");
  if (!left.step() || left.integer_at(0) != 0) return "samples of a deleted session are left";
  if (life.second)
    if (std::string wrong = holds(*life.second, kSecondSeed, life.second_samples); !wrong.empty()) return wrong;
  return {};
}

OpenOptions on_crash_disk() {
  OpenOptions options;
  options.vfs = CrashDisk::vfs_name();
  return options;
}

// A file as its first opening leaves it. Making it anew takes longer than a whole life on it.
const CrashDisk::Image& opened_once() {
  static const CrashDisk::Image image = [] {
    CrashDisk disk(1);
    EXPECT_TRUE(Database::open("/hoist.db", on_crash_disk()).ok());
    return disk.image();
  }();
  return image;
}

std::uint64_t operations_of_a_life(const CrashDisk::Image& image) {
  CrashDisk disk(1, image);
  const Life life = live(on_crash_disk());
  EXPECT_TRUE(life.delete_done);
  EXPECT_EQ(life.second_samples, 300U);
  EXPECT_EQ(verify(life, on_crash_disk()), "");
  return disk.operations();
}

// Power cuts of one test: its share of HOIST_POWER_CUTS (`deploy/dev soak --cuts`), or of a few hundred.
int rounds_of(double share) {
  const char* asked = std::getenv("HOIST_POWER_CUTS");
  return std::max(1, static_cast<int>(share * (asked == nullptr ? 570 : std::atoi(asked))));
}

// Rounds of an earlier run are not repeated: HOIST_POWER_FROM is the number of the first one.
int first_round() {
  const char* from = std::getenv("HOIST_POWER_FROM");
  return from == nullptr ? 0 : std::atoi(from);
}

// Where the power goes in a round: every operation in turn, in an order that is spread over all of them also when the rounds are few.
std::uint64_t cut_of(int round, std::uint64_t operations) {
  constexpr std::uint64_t kStride = 7919;  // a prime, so that no operation is left out
  return 1 + static_cast<std::uint64_t>(round) * kStride % operations;
}

// H25
TEST(PowerCut, nothing_acknowledged_is_lost_and_no_file_is_damaged) {
  const std::uint64_t from_nothing = operations_of_a_life({}), operations = operations_of_a_life(opened_once());
  ASSERT_GT(operations, 100U);
  ASSERT_GT(from_nothing, operations + 50U);
  const int rounds = rounds_of(0.55);
  int cuts = 0;
  for (int round = first_round(), end = round + rounds; round < end; ++round) {
    // Each fourth life makes its file, too, and has its cut anywhere in both.
    const bool makes_it = round % 4 == 0;
    CrashDisk disk(static_cast<std::uint32_t>(round), makes_it ? CrashDisk::Image{} : opened_once());
    disk.cut_after(makes_it ? cut_of(round / 4, from_nothing) : cut_of(round, operations));
    const Life life = live(on_crash_disk());
    cuts += disk.is_cut() ? 1 : 0;
    disk.restart();
    ASSERT_EQ(verify(life, on_crash_disk()), "") << "round " << round;
  }
  EXPECT_GT(cuts, rounds * 9 / 10) << "the power has to go somewhere in the middle";
}

// A file of the first schema, as it is brought up to date.
TEST(PowerCut, a_migration_is_done_or_begins_again) {
  std::ifstream stream(HOIST_SOURCE_DIR "/tests/unit/db/recording_001.sql", std::ios::binary);
  const std::string sql(std::istreambuf_iterator<char>(stream), {});
  const CrashDisk::Image old = [&sql] {
    CrashDisk disk(1);
    sqlite3* handle = nullptr;
    sqlite3_open_v2("/hoist.db", &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, CrashDisk::vfs_name());
    EXPECT_EQ(sqlite3_exec(handle, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close_v2(handle);
    return disk.image();
  }();
  // Empty when all three sessions are there.
  const auto wrong = [] {
    Result<Database> database = Database::open("/hoist.db", on_crash_disk());
    if (!database) return "does not open: " + database.error().message;
    if (const std::string damage = damage_of(*database); !damage.empty()) return "was damaged: " + damage;
    if (!SessionWriter::create(*database)) return std::string("no writer");
    const std::uint64_t samples[] = {60, 40, 20};
    for (SessionId id = 1; id <= 3; ++id)
      if (const auto session = SessionReader(*database).get(id); !session || session->sample_count != samples[id - 1])
        return "session " + std::to_string(id) + " is not whole";
    return std::string();
  };
  std::uint64_t operations = 0;
  {
    CrashDisk disk(1, old);
    ASSERT_EQ(wrong(), "");
    operations = disk.operations();
  }
  ASSERT_GT(operations, 50U);
  for (int round = first_round(), end = round + rounds_of(0.1); round < end; ++round) {
    CrashDisk disk(static_cast<std::uint32_t>(round), old);
    disk.cut_after(cut_of(round, operations));
    (void)wrong();
    disk.restart();
    ASSERT_EQ(wrong(), "") << "round " << round;
  }
}

// A backup that is taken while recording goes on, and put back: copied, then renamed over the file.
struct Exchange {
  Life life;
  std::uint64_t samples_at_begin = 0;
  bool copied = false, renamed = false;
};
Exchange exchange(CrashDisk& disk, bool restores) {
  Exchange done;
  {
    Result<Database> database = Database::open("/hoist.db", on_crash_disk());
    if (!database) return done;
    Result<SessionWriter> writer = SessionWriter::create(*database);
    if (!writer) return done;
    Walk first(kFirstSeed), second(kSecondSeed);
    const Result<SessionId> begun = writer->begin(start_of_walk());
    if (!begun) return done;
    done.life.first = *begun;
    if (!writer->append_ticks(first.records(0, 200)) || !writer->commit()) return done;
    done.life.first_samples = writer->durable().samples;
    if (!writer->end(CloseReason::finished, kStartUtc_ns)) return done;
    const Result<SessionId> next = writer->begin(start_of_walk());
    if (!next) return done;
    done.life.second = *next;
    if (!writer->append_ticks(second.records(0, 50)) || !writer->commit()) return done;
    done.samples_at_begin = done.life.second_samples = writer->durable().samples;
    Result<Database> reading = Database::attach("/hoist.db", on_crash_disk());
    if (!reading) return done;
    std::uint64_t tick = 50;
    const auto copied = copy_database(
        *reading, "/copy.db",
        [&](double) {
          if (tick < 150 && writer->append_ticks(second.records(tick, 25)).ok() && writer->commit().ok()) {
            tick += 25;
            done.life.second_samples = writer->durable().samples;
          }
          return true;
        },
        CrashDisk::vfs_name());
    done.copied = copied && *copied;
    if (!done.copied || !restores || !writer->end(CloseReason::finished, kStartUtc_ns)) return done;
  }
  {
    Result<Database> alone = Database::attach("/hoist.db", on_crash_disk());
    if (!alone || !try_execute(alone->handle(), "PRAGMA journal_mode = DELETE")) return done;
  }
  done.renamed = disk.rename("/copy.db", "/hoist.db");
  return done;
}
// Empty when this file has at least these samples.
std::string lacks(const char* file, const Exchange& done, std::uint64_t second_samples) {
  const Result<Database> database = Database::open(file, on_crash_disk());
  if (!database) return std::string(file) + " does not open: " + database.error().message;
  Result<Database> checked = Database::inspect(file, on_crash_disk());
  if (!checked) return checked.error().message;
  if (const std::string damage = damage_of(*checked); !damage.empty()) return std::string(file) + " was damaged: " + damage;
  for (const auto& [id, samples] : {std::pair(done.life.first, done.life.first_samples), std::pair(done.life.second, second_samples)})
    if (const auto session = id ? SessionReader(*checked).get(*id) : Error{}; id && (!session || session->sample_count < samples))
      return std::string(file) + " lacks samples of session " + std::to_string(*id);
  return {};
}

TEST(PowerCut, a_backup_that_was_complete_stays_so_and_costs_the_recording_nothing) {
  for (const bool restores : {false, true}) {
    std::uint64_t operations = 0;
    {
      CrashDisk disk(1, opened_once());
      const Exchange whole = exchange(disk, restores);
      ASSERT_TRUE(whole.copied);
      ASSERT_EQ(whole.renamed, restores);
      ASSERT_GT(whole.life.second_samples, whole.samples_at_begin);
      operations = disk.operations();
    }
    int complete = 0;
    for (int round = first_round(), end = round + rounds_of(0.1); round < end; ++round) {
      CrashDisk disk(static_cast<std::uint32_t>(round), opened_once());
      disk.cut_after(cut_of(round, operations));
      const Exchange done = exchange(disk, restores);
      disk.restart();
      complete += done.copied ? 1 : 0;
      if (done.copied && !done.renamed) {
        ASSERT_EQ(lacks("/copy.db", done, done.samples_at_begin), "") << "round " << round;
      }
      // The old file with all that was acknowledged, or the backup.
      ASSERT_EQ(lacks("/hoist.db", done, done.renamed ? done.samples_at_begin : done.life.second_samples), "") << "round " << round;
    }
    EXPECT_GT(complete, 0);
  }
}

// Two of four sessions are old. Returns the last step that is known to be done.
enum class Kept : std::uint8_t { nothing, recorded, ruled, deleted };
Kept keep_for_a_while() {
  Kept done = Kept::nothing;
  Result<Database> database = Database::open("/hoist.db", on_crash_disk());
  if (!database) return done;
  Result<SessionWriter> writer = SessionWriter::create(*database);
  if (!writer) return done;
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  for (const int days : {400, 300, 20, 0}) {
    SessionStart start = start_of_walk();
    start.started_utc_ns = kStartUtc_ns - days * kDay_ns;
    Walk walk(kFirstSeed);
    const bool well = writer->begin(start).ok() && writer->append_ticks(walk.records(0, 60)).ok() &&
                      writer->end(CloseReason::finished, start.started_utc_ns).ok();
    if (!well) return done;
  }
  done = Kept::recorded;
  const RetentionRule rule{.days = 100, .disk_percent = {}, .needs_backup = true};
  if (!set_retention_rule(*database, rule) || !note_backup(*database, 0, "/stick", 2)) return done;
  done = Kept::ruled;
  const auto plan = plan_retention(*database, *retention_rule(*database), kStartUtc_ns, 1, [](double) { return true; });
  if (!plan || !*plan) return done;
  for (const SessionId session : (*plan)->sessions)
    if (!SessionEditor(*database).remove(session)) return done;
  return Kept::deleted;
}
// Empty when each session is whole or gone, and none is gone that the rule keeps.
std::string wrongly_kept(Kept done) {
  Result<Database> database = Database::open("/hoist.db", on_crash_disk());
  if (!database) return "does not open: " + database.error().message;
  for (auto more = erase_piece(*database); !more || *more; more = erase_piece(*database))
    if (!more) return "not erased: " + more.error().message;
  if (const std::string damage = damage_of(*database); !damage.empty()) return "was damaged: " + damage;
  const auto rule = retention_rule(*database);
  if (!rule) return rule.error().message;
  if (done >= Kept::ruled && !rule->on()) return "the rule is lost";
  if (done == Kept::nothing) return {};
  for (SessionId id = 1; id <= 4; ++id) {
    const auto session = SessionReader(*database).get(id);
    if (session && session->sample_count != 60) return "session " + std::to_string(id) + " is not whole";
    if (!session && (id > 2 || done < Kept::ruled)) return "session " + std::to_string(id) + " is gone";
    if (session && id <= 2 && done == Kept::deleted) return "session " + std::to_string(id) + " came back";
  }
  Statement left(database->handle(), "SELECT count(*) FROM chunks WHERE session_id NOT IN (SELECT id FROM sessions)");
  return left.step() && left.integer_at(0) == 0 ? "" : "samples of a deleted session are left";
}

TEST(PowerCut, retention_takes_a_session_whole_or_not_at_all) {
  std::uint64_t operations = 0;
  {
    CrashDisk disk(1, opened_once());
    ASSERT_EQ(keep_for_a_while(), Kept::deleted);
    ASSERT_EQ(wrongly_kept(Kept::deleted), "");
    operations = disk.operations();
  }
  for (int round = first_round(), end = round + rounds_of(0.15); round < end; ++round) {
    CrashDisk disk(static_cast<std::uint32_t>(round), opened_once());
    disk.cut_after(cut_of(round, operations));
    const Kept done = keep_for_a_while();
    disk.restart();
    ASSERT_EQ(wrongly_kept(done), "") << "round " << round;
  }
}

TEST(PowerCut, a_disk_that_lies_about_syncing_is_noticed_by_this_test) {
  const std::uint64_t operations = operations_of_a_life({});
  std::mt19937 random(43);
  int noticed = 0;
  for (int round = 0; round < 40; ++round) {
    CrashDisk disk(static_cast<std::uint32_t>(round));
    disk.ignore_syncs(true);
    disk.cut_after(operations / 2 + random() % (operations / 2));
    const Life life = live(on_crash_disk());
    disk.restart();
    noticed += verify(life, on_crash_disk()).empty() ? 0 : 1;
  }
  EXPECT_GT(noticed, 30);
}

}  // namespace
}  // namespace hoist::db::test
