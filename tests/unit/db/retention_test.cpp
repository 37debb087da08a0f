// Which sessions a rule of retention deletes, whatever the clock says, and which ones never.
#include "db/store/retention.hpp"

#include <nlohmann/json.hpp>

#include "db/export/bundle.hpp"
#include "db/store/backup.hpp"
#include "db/store/deletion.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using namespace test;

constexpr std::int64_t kDay_ns = 86'400'000'000'000;
constexpr std::uint64_t kLargeDisk_bytes = 1'000'000'000'000;
constexpr auto kGoOn = [](double) { return true; };

class Retention : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = Database::open(folder_ / "hoist.db");
    ASSERT_TRUE(opened.ok());
    database_.emplace(std::move(*opened));
  }
  // A session that began that many days before kStartUtc_ns.
  SessionId record(double days_before, std::size_t samples = 20) {
    auto writer = SessionWriter::create(*database_);
    SessionStart start = start_of_walk();
    start.started_utc_ns = kStartUtc_ns - static_cast<std::int64_t>(days_before * static_cast<double>(kDay_ns));
    const SessionId id = *writer->begin(start);
    Walk walk(static_cast<std::uint32_t>(id));
    EXPECT_TRUE(writer->append_ticks(walk.records(0, samples)).ok());
    EXPECT_TRUE(writer->end(CloseReason::finished, start.started_utc_ns).ok());
    return id;
  }
  RetentionPlan plan(const RetentionRule& rule, std::int64_t utc_ns = kStartUtc_ns, std::uint64_t disk_bytes = kLargeDisk_bytes) {
    auto made = plan_retention(*database_, rule, utc_ns, disk_bytes, kGoOn);
    EXPECT_TRUE(made.ok() && *made) << (made.ok() ? "" : made.error().message);
    return made.ok() && *made ? **made : RetentionPlan{};
  }
  using Ids = std::vector<SessionId>;

  TemporaryFolder folder_;
  std::optional<Database> database_;
};

TEST_F(Retention, IsOffUntilItIsSetAndRefusesWhatIsOutOfRange) {
  record(4000);
  record(0);
  EXPECT_EQ(*retention_rule(*database_), RetentionRule{});
  EXPECT_FALSE(RetentionRule{}.on());
  EXPECT_EQ(plan({}).sessions, Ids{});
  const RetentionRule rule{.days = 180, .disk_percent = 50, .needs_backup = false};
  EXPECT_EQ(set_retention_rule(*database_, rule, tag_of(rule)).error().kind, ErrorKind::changed);
  ASSERT_TRUE(set_retention_rule(*database_, rule, tag_of({})).ok());
  EXPECT_EQ(*retention_rule(*database_), rule);
  for (const auto& [days, percent, field] :
       {std::tuple{29, 50, "days"}, {36501, 50, "days"}, {30, 4, "disk_percent"}, {30, 91, "disk_percent"}}) {
    const Status refused = set_retention_rule(*database_, {.days = days, .disk_percent = percent});
    ASSERT_FALSE(refused.ok()) << days << " " << percent;
    EXPECT_EQ(refused.error().field, field);
  }
  EXPECT_EQ(*retention_rule(*database_), rule) << "a refused one changes nothing";
  for (const char* text : {"7", "{\"days\": 1}", "no rule"}) {
    Statement(database_->handle(), "UPDATE settings SET value = ?1").text(1, std::string_view(text)).run();
    EXPECT_EQ(retention_rule(*database_).error().kind, ErrorKind::corrupt) << text << ": deletes nothing rather than by a guess";
  }
}

TEST_F(Retention, DeletesWhatIsOldAndInABackup) {
  const SessionId oldest = record(400), old = record(200);
  record(100);
  record(0);
  const RetentionRule rule{.days = 150, .disk_percent = {}, .needs_backup = false};
  EXPECT_EQ(plan(rule).sessions, (Ids{oldest, old}));
  EXPECT_EQ(plan(rule).bytes, SessionReader(*database_).get(oldest)->stored_bytes + SessionReader(*database_).get(old)->stored_bytes);
  EXPECT_EQ(plan(rule).from_utc_ns, kStartUtc_ns - 400 * kDay_ns);
  EXPECT_EQ(plan(rule).to_utc_ns, kStartUtc_ns - 200 * kDay_ns);
  const RetentionRule careful{.days = 150, .disk_percent = {}, .needs_backup = true};
  EXPECT_EQ(plan(careful).sessions, Ids{});
  EXPECT_EQ(plan(careful).without_backup, 2U);
  ASSERT_TRUE(note_backup(*database_, 0, "/media/stick/hoist-a", oldest).ok());
  EXPECT_EQ(plan(careful).sessions, Ids{oldest});
  EXPECT_EQ(plan(careful).without_backup, 1U);
  int asked = 0;
  const auto ended = plan_retention(*database_, rule, kStartUtc_ns, kLargeDisk_bytes, [&](double) { return ++asked < 2; });
  ASSERT_TRUE(ended.ok());
  EXPECT_FALSE(*ended) << "ended by its caller";
}

TEST_F(Retention, NeverTakesTheSessionUnderWayOrTheNewestDay) {
  const RetentionRule all{.days = 30, .disk_percent = 5, .needs_backup = false};
  const SessionId old = record(100);
  record(0.2);
  record(0.1);
  auto writer = SessionWriter::create(*database_);
  SessionStart start = start_of_walk();
  start.started_utc_ns = kStartUtc_ns - 90 * kDay_ns;  // the clock is wrong, and it runs
  ASSERT_TRUE(writer->begin(start).ok());
  EXPECT_EQ(plan(all, kStartUtc_ns, 1).sessions, Ids{old});
  EXPECT_EQ(plan(all, kStartUtc_ns + 5 * kDay_ns, 1).sessions, Ids{old}) << "whatever day it is by the clock";
  EXPECT_GT(plan(all, kStartUtc_ns, 1).excess_bytes, 0U) << "more must not go";
}

// Set back, the clock makes today older than other days.
TEST_F(Retention, NeverTakesWhatWasRecordedTodayByTheClock) {
  const SessionId old = record(100);
  record(0);
  record(40);
  const RetentionRule all{.days = {}, .disk_percent = 5, .needs_backup = false};
  EXPECT_EQ(plan(all, kStartUtc_ns - 40 * kDay_ns, 1).sessions, Ids{old});
}

// A wall clock that was set wrong makes nothing old.
TEST_F(Retention, AClockThatJumpsDeletesNothingThatIsYoung) {
  const RetentionRule rule{.days = 30, .disk_percent = {}, .needs_backup = false};
  const SessionId old = record(60);
  record(20);
  record(0);
  EXPECT_EQ(plan(rule, kStartUtc_ns + 3650 * kDay_ns).sessions, Ids{old}) << "ten years ahead";
  EXPECT_EQ(plan(rule, kStartUtc_ns - 3650 * kDay_ns).sessions, Ids{}) << "ten years back: all of it is of today or later";
  EXPECT_EQ(plan(rule, 0).sessions, Ids{});
  // Recorded before the clock was set: of unknown age.
  record(20000);
  record(0);
  EXPECT_EQ(plan(rule).sessions, Ids{old});
}

TEST_F(Retention, TheOldestGoUntilTheRestFitsItsShare) {
  for (int i = 0; i < 5; ++i) record(50 - i, 3000);
  record(0);
  const auto bytes = [&](SessionId id) { return SessionReader(*database_).get(id)->stored_bytes; };
  const std::uint64_t used = plan({}).used_bytes;
  ASSERT_GT(used, bytes(1) + bytes(2));
  // Half of the disk may be used: by a little more than the first session it is not enough.
  const std::uint64_t disk = 2 * (used - bytes(1) - bytes(2) / 2);
  const RetentionRule half{.days = {}, .disk_percent = 50, .needs_backup = false};
  EXPECT_EQ(plan(half, kStartUtc_ns, disk).sessions, (Ids{1, 2}));
  EXPECT_EQ(plan(half, kStartUtc_ns, disk).excess_bytes, 0U);
  EXPECT_EQ(plan(half, kStartUtc_ns, 2 * used + 200).sessions, Ids{}) << "it fits";
  // One that wants a backup keeps its place: no younger one goes instead of it.
  RetentionRule careful = half;
  careful.needs_backup = true;
  EXPECT_EQ(plan(careful, kStartUtc_ns, disk).sessions, Ids{});
  EXPECT_EQ(plan(careful, kStartUtc_ns, disk).without_backup, 2U);
  EXPECT_GT(plan(careful, kStartUtc_ns, disk).excess_bytes, 0U);
  // Deleted pages count as free at once, although the file stays as large.
  ASSERT_TRUE(SessionEditor(*database_).remove(1).ok());
  EXPECT_LT(plan({}).used_bytes, used);
}

TEST_F(Retention, ABackupIsNotedAndARestoreTurnsTheRuleOff) {
  const SessionId old = record(200);
  record(0);
  std::filesystem::create_directory(folder_ / "stick");
  const RetentionRule rule{.days = 100};
  ASSERT_TRUE(set_retention_rule(*database_, rule).ok());
  EXPECT_EQ(plan(rule).sessions, Ids{});
  const BackupOptions options{.folder = folder_ / "stick", .device = "a", .program = "b", .utc_ns = kStartUtc_ns};
  const auto backup = back_up(*database_, options, kGoOn);
  ASSERT_TRUE(backup.ok() && *backup);
  EXPECT_EQ(plan(rule).sessions, Ids{old});
  record(0);
  EXPECT_EQ(plan({.days = 30}).sessions, Ids{old});
  database_.reset();
  const auto prepared = prepare_restore((*backup)->folder, folder_ / "hoist.db", kGoOn);
  ASSERT_TRUE(prepared.ok() && *prepared);
  ASSERT_TRUE(finish_restore(**prepared, folder_ / "hoist.db", kStartUtc_ns).ok());
  SetUp();
  EXPECT_EQ(*retention_rule(*database_), RetentionRule{}) << "what was brought back is not deleted by a rule of that time";
  EXPECT_EQ(SessionReader(*database_).list()->total, 2U);
}

// Walks are counted; the time in standby between them belongs to the visit.
TEST_F(Retention, StandbyIsNoWalkButGoesWithItsVisit) {
  auto writer = SessionWriter::create(*database_);
  for (const bool standby : {true, false, true}) {
    SessionStart start = start_of_walk();
    start.standby = standby;
    ASSERT_TRUE(writer->begin(start).ok());
    Walk walk(1);
    ASSERT_TRUE(writer->append_ticks(walk.records(0, 100)).ok());
    ASSERT_TRUE(writer->end(CloseReason::finished, kStartUtc_ns).ok());
  }
  const SessionReader reader(*database_);
  EXPECT_EQ(reader.list()->total, 1U);
  ASSERT_EQ(reader.list()->sessions.size(), 1U);
  EXPECT_EQ(reader.list()->sessions[0].id, 2);
  EXPECT_EQ(reader.list({.limit = 50, .before = {}, .subject = "017"})->total, 1U);
  EXPECT_EQ(reader.list({.limit = 50, .before = {}, .subject = {}, .standby = true})->total, 3U);
  EXPECT_TRUE(reader.get(1)->standby);
  const VisitInfo visit = VisitReader(*database_).visits()->items.at(0);
  EXPECT_EQ(visit.sessions, Ids{2});
  EXPECT_EQ(visit.standby, (Ids{1, 3}));
  const PatientInfo patient = VisitReader(*database_).patients()->items.at(0);
  EXPECT_EQ(patient.visits, 1U);
  EXPECT_EQ(patient.sessions, 1U);
  EXPECT_EQ(*select_sessions(*database_, {}), Ids{2}) << "a data set holds walks";
  ASSERT_TRUE(SessionEditor(*database_).remove(2).ok());
  EXPECT_EQ(VisitReader(*database_).patients()->items.at(0).visits, 0U) << "a visit counts with its first walk";
  EXPECT_EQ(reader.list({.limit = 50, .before = {}, .subject = {}, .standby = true})->total, 2U);
}

}  // namespace
}  // namespace hoist::db
