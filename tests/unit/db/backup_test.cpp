// Backups and restores: a copy of a file that is being recorded into, the refusal of damaged ones, and the state after
// a kill.
#include "db/store/backup.hpp"

#include <sys/statvfs.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "db/store/deletion.hpp"
#include "db/store/device_settings.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/sqlite.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr auto kGoOn = [](double) { return true; };

class Backup : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(fs::create_directory(stick_));
    record(1);
  }
  // One more session, of 300 samples.
  void record(std::uint32_t seed) {
    auto database = Database::open(file_);
    ASSERT_TRUE(database.ok()) << database.error().message;
    auto writer = SessionWriter::create(*database);
    ASSERT_TRUE(writer.ok());
    ASSERT_TRUE(writer->begin(start_of_walk()).ok());
    Walk walk(seed);
    ASSERT_TRUE(writer->append_ticks(walk.records(0, 300)).ok());
    ASSERT_TRUE(writer->end(CloseReason::finished, kStartUtc_ns).ok());
  }
  BackupOptions options() const { return {.folder = stick_, .device = "ward-3", .program = "0.1.0", .utc_ns = kStartUtc_ns}; }
  BackupInfo back_up_now() {
    auto database = Database::attach(file_);
    auto done = back_up(*database, options(), kGoOn);
    EXPECT_TRUE(done.ok() && *done) << (done.ok() ? "" : done.error().message);
    return done.ok() && *done ? **done : BackupInfo{};
  }
  static std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
  static std::size_t sessions_of(const fs::path& file) {
    auto database = Database::open(file);
    EXPECT_TRUE(database.ok()) << database.error().message;
    EXPECT_EQ(damage_of(*database), "");
    EXPECT_FALSE(database->report().lost) << "a file that was put back has lost nothing";
    return SessionReader(*database).list()->total;
  }
  static void flip(const fs::path& file, std::uintmax_t at) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(at));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(static_cast<char>(byte ^ 0x40));
  }

  TemporaryFolder folder_;
  const fs::path file_ = folder_ / "hoist.db", stick_ = folder_ / "stick";
};

TEST_F(Backup, HoldsTheMomentOfItsBeginAlthoughRecordingGoesOn) {
  {
    // More than one piece.
    auto database = Database::attach(file_);
    execute(database->handle(), "CREATE TABLE much (body BLOB); INSERT INTO much SELECT zeroblob(12000000)");
  }
  auto recording = Database::open(file_);
  auto writer = SessionWriter::create(*recording);
  ASSERT_TRUE(writer->begin(start_of_walk()).ok());
  Walk walk(2);
  ASSERT_TRUE(writer->append_ticks(walk.records(0, 100)).ok());
  auto reading = Database::attach(file_);
  std::uint64_t tick = 100;
  int pieces = 0;
  // Each piece of the copy meets a commit of the recorder: a copy that restarted each time would never end.
  const auto done = back_up(*reading, options(), [&](double share) {
    if (++pieces % 100 != 0 && share > 0.5) return true;  // the check
    EXPECT_TRUE(writer->append_ticks(walk.records(tick, 50)).ok());
    tick += 50;
    return pieces < 5000;
  });
  ASSERT_TRUE(done.ok()) << done.error().message;
  ASSERT_TRUE(*done) << "it does not come to an end";
  EXPECT_GT(pieces, 12);
  EXPECT_EQ((*done)->folder.filename(), "hoist-ward-3-20260921T141320Z");
  EXPECT_EQ((*done)->sessions, 2U);
  EXPECT_EQ((*done)->newest_session, 1) << "the one under way has not ended";
  EXPECT_EQ(names_in((*done)->folder), (std::vector<std::string>{"manifest.json", "recordings.db"}));
  EXPECT_EQ(fs::status((*done)->folder / "recordings.db").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  auto copy = Database::inspect((*done)->folder / "recordings.db");
  ASSERT_TRUE(copy.ok());
  EXPECT_EQ(SessionReader(*copy).get(2)->sample_count, 100U) << "those of the begin";
  EXPECT_EQ(SessionReader(*recording).get(2)->sample_count, tick);
}

TEST_F(Backup, IsListedAndPutBack) {
  const BackupInfo backup = back_up_now();
  record(2);
  ASSERT_EQ(sessions_of(file_), 2U);
  const auto listed = list_backups(stick_);
  ASSERT_EQ(listed.size(), 1U);
  EXPECT_EQ(listed[0].device, "ward-3");
  EXPECT_EQ(listed[0].utc_ns, kStartUtc_ns);
  EXPECT_EQ(listed[0].files.at(0).bytes, fs::file_size(backup.folder / "recordings.db"));
  const auto prepared = prepare_restore(backup.folder, file_, kGoOn);
  ASSERT_TRUE(prepared.ok() && *prepared) << prepared.error().message;
  ASSERT_EQ(sessions_of(folder_ / "hoist.db"), 2U) << "not yet; and opening the file takes the copy away";
  const auto again = prepare_restore(backup.folder, file_, kGoOn);
  const auto aside = finish_restore(**again, file_, kStartUtc_ns);
  ASSERT_TRUE(aside.ok()) << aside.error().message;
  EXPECT_EQ(aside->filename(), "hoist.db.replaced-20260921T141320Z");
  EXPECT_EQ(sessions_of(file_), 1U);
  EXPECT_EQ(sessions_of(*aside), 2U) << "the old one is kept, whole";
  EXPECT_NE(Database::attach(file_)->file_id(), Database::attach(*aside)->file_id()) << "two files, told apart";
  record(3);
  auto present = Database::attach(file_);
  EXPECT_EQ(SessionReader(*present).list()->sessions.at(0).id, 3) << "number 2 stands on paper for another session";
}

TEST_F(Backup, OfAFileWithoutSessionsGivesNoNumberAgain) {
  const fs::path other = folder_ / "other.db";
  {
    auto empty = Database::open(other);
    ASSERT_TRUE(back_up(*empty, options(), kGoOn).ok());
  }
  const fs::path backup = list_backups(stick_).at(0).folder;
  record(2);
  const auto restored = [&] {
    auto prepared = prepare_restore(backup, file_, kGoOn);
    ASSERT_TRUE(prepared.ok() && *prepared) << prepared.error().message;
    ASSERT_TRUE(finish_restore(**prepared, file_, kStartUtc_ns).ok());
    record(3);
  };
  restored();
  EXPECT_EQ(SessionReader(*Database::attach(file_)).list()->sessions.at(0).id, 3);
  // Now the present file is damaged; its seal is whole.
  for (std::uintmax_t at = 100; at < 1000; ++at) flip(file_, at);
  restored();
  EXPECT_EQ(SessionReader(*Database::attach(file_)).list()->sessions.at(0).id, 4);
}

// Two hoists with one id would be one in every archive.
TEST_F(Backup, OnAnotherHoistItBringsRecordingsButNeitherIdNorName) {
  std::string first;
  {
    auto database = Database::open(file_);
    first = hoist_id(database->handle());
    ASSERT_TRUE(change_device_settings(*database, {.name = "Room 3", .language = {}}, "").ok());
  }
  const BackupInfo backup = back_up_now();
  EXPECT_EQ(backup.hoist_id, first);
  EXPECT_EQ(list_backups(stick_).at(0).hoist_id, first);
  const fs::path copied = folder_ / "copied.db", other = folder_ / "other" / "hoist.db", fresh = folder_ / "fresh" / "hoist.db";
  fs::copy_file(backup.folder / "recordings.db", copied);
  EXPECT_EQ(hoist_id_of(copied), "");
  EXPECT_NE(hoist_id(Database::open(copied)->handle()), first) << "put in place by hand";
  const auto put_back = [&](const fs::path& file) {
    const auto prepared = prepare_restore(backup.folder, file, kGoOn);
    ASSERT_TRUE(prepared.ok() && *prepared) << prepared.error().message;
    ASSERT_TRUE(finish_restore(**prepared, file, kStartUtc_ns).ok());
  };
  for (const fs::path& folder : {other.parent_path(), fresh.parent_path()}) fs::create_directory(folder);
  std::string second;
  {
    auto database = Database::open(other);
    second = hoist_id(database->handle());
    ASSERT_TRUE(change_device_settings(*database, {.name = "Room 4", .language = {}}, "").ok());
  }
  put_back(other);
  {
    auto database = Database::open(other);
    EXPECT_EQ(hoist_id(database->handle()), second);
    EXPECT_EQ(device_settings(*database)->name, "Room 4");
    EXPECT_EQ(SessionReader(*database).get(1)->hoist_id, first) << "a session says who recorded it";
  }
  put_back(fresh);
  const std::string third = hoist_id(Database::open(fresh)->handle());
  EXPECT_EQ(third.size(), 36U);
  EXPECT_NE(third, first) << "nobody can know whether this is the same machine";
  // The hoist itself stays itself.
  put_back(file_);
  auto database = Database::open(file_);
  EXPECT_EQ(hoist_id(database->handle()), first);
  EXPECT_EQ(device_settings(*database)->name, "Room 3");
}

TEST_F(Backup, AnEndedOneLeavesNothing) {
  auto database = Database::attach(file_);
  int all = 0;
  ASSERT_TRUE((*back_up(*database, options(), [&](double) { return ++all > 0; })).has_value());
  fs::remove_all(stick_);
  fs::create_directory(stick_);
  for (int most = 1; most < all; most += std::max(1, all / 40)) {
    int steps = 0;
    const auto ended = back_up(*database, options(), [&](double) { return ++steps < most; });
    ASSERT_TRUE(ended.ok()) << ended.error().message;
    EXPECT_FALSE(*ended) << most;
    EXPECT_TRUE(names_in(stick_).empty()) << most;
  }
  // Left by a program that was killed: removed by the next backup. Files of other programs stay.
  fs::create_directory(stick_ / "hoist-ward-3-20250101T000000Z.part");
  fs::create_directory(stick_ / "hoist-ward-4-20250101T000000Z.part");
  back_up_now();
  EXPECT_EQ(names_in(stick_), (std::vector<std::string>{"hoist-ward-3-20260921T141320Z", "hoist-ward-4-20250101T000000Z.part"}));
}

TEST_F(Backup, AFolderThatCannotHoldItIsRefusedByItsKind) {
  auto database = Database::attach(file_);
  BackupOptions nowhere = options();
  nowhere.folder = folder_ / "none";
  EXPECT_EQ(back_up(*database, nowhere, kGoOn).error().kind, ErrorKind::not_found);
  nowhere.folder = "/proc";
  const auto proc = back_up(*database, nowhere, kGoOn);
  ASSERT_FALSE(proc.ok());
  EXPECT_NE(proc.error().kind, ErrorKind::internal);
  // A file system that is too small, where this user may mount one.
  const fs::path small = folder_ / "small";
  fs::create_directory(small);
  const std::string mount = "mount -t tmpfs -o size=9m hoist-test '" + small.string() + "' 2>/dev/null";
  if (std::system(mount.c_str()) != 0) GTEST_SKIP() << "this user may not mount a file system";
  nowhere.folder = small;
  EXPECT_EQ(back_up(*database, nowhere, kGoOn).ok(), true) << "8 MB in reserve, 300 samples need little";
  { std::ofstream(small / "full") << std::string(3'000'000, 'x'); }
  EXPECT_EQ(back_up(*database, nowhere, kGoOn).error().kind, ErrorKind::disk_full);
  EXPECT_EQ(std::system(("mount -o remount,ro '" + small.string() + "'").c_str()), 0);
  EXPECT_EQ(back_up(*database, nowhere, kGoOn).error().kind, ErrorKind::read_only);
  EXPECT_EQ(std::system(("umount '" + small.string() + "'").c_str()), 0);
}

// Any byte of the backup may have been damaged on the stick.
TEST_F(Backup, ADamagedOneIsNotPutBack) {
  const BackupInfo backup = back_up_now();
  const fs::path copy = backup.folder / "recordings.db";
  const auto refused = [&](const fs::path& from) {
    const auto prepared = prepare_restore(from, file_, kGoOn);
    EXPECT_EQ(names_in(folder_.path()).size(), 5U) << "hoist.db, .lock, .seal, the stick and other.db";
    return prepared.ok() ? ErrorKind::internal : prepared.error().kind;
  };
  std::ofstream(folder_ / "other.db") << "no database";
  const std::uintmax_t size = fs::file_size(copy);
  for (std::uintmax_t at = 1; at < size; at += size / 60) {
    flip(copy, at);
    EXPECT_EQ(refused(backup.folder), ErrorKind::corrupt) << "byte " << at;
    flip(copy, at);
  }
  fs::rename(backup.folder / "manifest.json", folder_ / "stick" / "manifest.json");
  EXPECT_EQ(refused(backup.folder), ErrorKind::corrupt) << "without a manifest";
  EXPECT_EQ(refused(folder_ / "other.db"), ErrorKind::foreign);
  EXPECT_EQ(refused(folder_ / "none"), ErrorKind::not_found);
  {
    auto newer = Database::inspect(copy);
    execute(newer->handle(), "PRAGMA user_version = 99");
  }
  EXPECT_EQ(refused(copy), ErrorKind::newer_schema);
  {
    auto damaged = Database::create_copy(copy);
    execute(damaged->handle(), ("PRAGMA user_version = " + std::to_string(schema_version())).c_str());
    execute(damaged->handle(), "UPDATE chunks SET body = zeroblob(length(body))");
  }
  {
    auto forged = Database::create_copy(copy);
    execute(forged->handle(), "CREATE TRIGGER extra AFTER INSERT ON sessions BEGIN DELETE FROM chunks; END");
  }
  EXPECT_EQ(refused(copy), ErrorKind::foreign);
  {
    auto mended = Database::create_copy(copy);
    execute(mended->handle(), "DROP TRIGGER extra");
  }
  const auto kept = prepare_restore(copy, file_, kGoOn);
  EXPECT_TRUE(kept.ok()) << "a chunk that was damaged before the backup costs that chunk, not all others";
}

// The copy has the damage of its source: it must not be taken for a backup.
TEST_F(Backup, OfADamagedFileThereIsNone) {
  std::int64_t page = 0, page_bytes = 0;
  {
    auto database = Database::attach(file_);
    Statement root(database->handle(), "SELECT rootpage FROM sqlite_schema WHERE name = 'markers'");
    Statement size(database->handle(), "PRAGMA page_size");
    ASSERT_TRUE(root.step() && size.step());
    page = root.integer_at(0);
    page_bytes = size.integer_at(0);
  }
  {
    std::fstream stream(file_, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp((page - 1) * page_bytes);
    stream << std::string(static_cast<std::size_t>(page_bytes), '\x5A');
  }
  auto database = Database::attach(file_);
  ASSERT_TRUE(database.ok()) << "it still opens";
  const auto done = back_up(*database, options(), kGoOn);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().kind, ErrorKind::corrupt) << done.error().message;
  EXPECT_TRUE(fs::is_empty(stick_));
}

// H25. At each change of a name the program is killed: what is found then is the old file or the new one, whole, and nothing else opens.
TEST_F(Backup, AKillDuringARestoreLeavesTheOldFileOrTheNewOne) {
  const BackupInfo backup = back_up_now();
  record(2);
  record(3);
  const auto prepared = prepare_restore(backup.folder, file_, kGoOn);
  ASSERT_TRUE(prepared.ok() && *prepared);
  int olds = 0, news = 0, changes = 0;
  for (bool killed = true; killed; ++changes) {
    const fs::path place = folder_ / ("round" + std::to_string(changes));
    fs::create_directory(place);
    for (const char* suffix : {"", ".seal", ".restore-part"})
      fs::copy_file(file_.string() + suffix, (place / "hoist.db").string() + suffix);
    // As after a crash: what was recorded last stands in the log only.
    {
      auto database = Database::attach(place / "hoist.db");
      execute(database->handle(), "PRAGMA wal_autocheckpoint = 0");
      ASSERT_TRUE(SessionEditor(*database).patch(3, {.note = "newest", .subject = {}, .exercise_json = {}}).ok());
      for (const char* suffix : {"", "-wal"})
        fs::copy_file((place / "hoist.db").string() + suffix, (place / "kept").string() + suffix, fs::copy_options::overwrite_existing);
    }
    for (const char* suffix : {"", "-wal"}) fs::rename((place / "kept").string() + suffix, (place / "hoist.db").string() + suffix);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      int left = changes;
      const auto done = finish_restore((place / "hoist.db.restore-part"), place / "hoist.db", kStartUtc_ns, [&left] {
        if (left-- == 0) _exit(9);
      });
      _exit(done ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    killed = WEXITSTATUS(status) == 9;
    EXPECT_NE(WEXITSTATUS(status), 1);
    ASSERT_TRUE(fs::exists(place / "hoist.db")) << "after change " << changes;
    const std::size_t sessions = sessions_of(place / "hoist.db");
    EXPECT_TRUE(sessions == 1 || sessions == 3) << sessions;
    (sessions == 1 ? news : olds) += 1;
    if (sessions == 3) {
      auto database = Database::attach(place / "hoist.db");
      EXPECT_EQ(SessionReader(*database).get(3)->note, "newest") << "what stood in the log";
    }
    const auto names = names_in(place);
    EXPECT_EQ(std::ranges::count(names, std::string("hoist.db.restore-part")), 0);
    EXPECT_EQ(std::ranges::count(names, std::string("hoist.db.replaced-20260921T141320Z")), sessions == 1 ? 1 : 0);
    EXPECT_EQ(fs::hard_link_count(place / "hoist.db"), 1U);
  }
  EXPECT_GE(olds, 4);
  EXPECT_EQ(news, 2) << "killed after the change that decides, or not at all";
}

TEST_F(Backup, NothingIsPutBackWhileAnotherProgramReads) {
  const BackupInfo backup = back_up_now();
  const auto prepared = prepare_restore(backup.folder, file_, kGoOn);
  auto reading = Database::attach(file_);
  ASSERT_TRUE(SessionReader(*reading).list().ok());
  EXPECT_EQ(finish_restore(**prepared, file_, kStartUtc_ns).error().kind, ErrorKind::busy);
  EXPECT_TRUE(SessionReader(*reading).list().ok());
  { const Database closed = std::move(*reading); }
  EXPECT_EQ(sessions_of(file_), 1U);
}

// However large a session is, each step of its deletion is small, and it is gone from the first one on.
TEST_F(Backup, ADeletionInPiecesIsOneDeletion) {
  auto database = Database::open(file_);
  ASSERT_TRUE(database.ok());
  execute(database->handle(),
          "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 99) INSERT INTO core_images "
          "(session_id, step, tick, bytes, body) SELECT 1, i, i, 9, CAST('SECRET-OF-A-PATIENT' AS BLOB) FROM n");
  ASSERT_TRUE(take_out(*database, 1).ok());
  EXPECT_EQ(SessionReader(*database).get(1).error().kind, ErrorKind::not_found);
  EXPECT_EQ(SessionReader(*database).list()->total, 0U);
  EXPECT_EQ(take_out(*database, 1).error().kind, ErrorKind::not_found);
  int pieces = 0;
  for (auto more = erase_piece(*database); *more; more = erase_piece(*database)) ++pieces;
  EXPECT_EQ(pieces, 4) << "100 blobs, 32 in each";
  std::ifstream stream(file_, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}).find("SECRET-OF"), std::string::npos);
  EXPECT_EQ(fs::file_size(file_.string() + "-wal"), 0U);
  EXPECT_EQ(damage_of(*database), "");
}

}  // namespace
}  // namespace hoist::db
