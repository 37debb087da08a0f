#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <optional>

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
  if (life.second)
    if (std::string wrong = holds(*life.second, kSecondSeed, life.second_samples); !wrong.empty()) return wrong;
  return {};
}

OpenOptions on_crash_disk() {
  OpenOptions options;
  options.vfs = CrashDisk::vfs_name();
  return options;
}

std::uint64_t operations_of_a_life() {
  CrashDisk disk(1);
  const Life life = live(on_crash_disk());
  EXPECT_TRUE(life.delete_done);
  EXPECT_EQ(life.second_samples, 300U);
  EXPECT_EQ(verify(life, on_crash_disk()), "");
  return disk.operations();
}

// H25
TEST(PowerCut, nothing_acknowledged_is_lost_and_no_file_is_damaged) {
  const std::uint64_t operations = operations_of_a_life();
  ASSERT_GT(operations, 100U);
  std::mt19937 random(42);
  constexpr int kCuts = 400;
  int cuts = 0;
  for (int round = 0; round < kCuts; ++round) {
    CrashDisk disk(static_cast<std::uint32_t>(round));
    disk.cut_after(1 + random() % operations);
    const Life life = live(on_crash_disk());
    cuts += disk.is_cut() ? 1 : 0;
    disk.restart();
    ASSERT_EQ(verify(life, on_crash_disk()), "") << "round " << round;
  }
  EXPECT_GT(cuts, kCuts * 9 / 10) << "the power has to go somewhere in the middle";
}

TEST(PowerCut, a_disk_that_lies_about_syncing_is_noticed_by_this_test) {
  const std::uint64_t operations = operations_of_a_life();
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
