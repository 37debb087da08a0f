// The check of a whole file: what it finds, what it costs to end it, and that opening a file does not wait for it.
#include "db/store/integrity.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <random>

#include "db/codec/column_chunk.hpp"
#include "db/store/sqlite.hpp"
#include "tests/support/seeds.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using namespace test;

constexpr auto kGoOn = [](double) { return true; };

class Integrity : public ::testing::Test {
 protected:
  void SetUp() override {
    auto database = Database::open(file_);
    ASSERT_TRUE(database.ok());
    auto writer = SessionWriter::create(*database);
    ASSERT_TRUE(writer.ok());
    for (std::uint32_t session = 1; session <= 2; ++session) {
      ASSERT_TRUE(writer->begin(start_of_walk()).ok());
      Walk walk(session);
      std::vector<contract::BusRecord> frames(500);
      std::vector<contract::JournalStep> steps(500);
      for (std::uint64_t i = 0; i < 500; ++i) {
        frames[i].time_ns = kStart_ns + i * 1'000'000;
        frames[i].data = i * 0x9E3779B97F4A7C15U;
        steps[i].step = steps[i].tick = i;
      }
      contract::CoreImage image;
      image.bytes = 5000;
      ASSERT_TRUE(writer->append_ticks(walk.records(0, 500)).ok());
      ASSERT_TRUE(writer->append_bus(frames).ok());
      ASSERT_TRUE(writer->append_journal(steps, {}).ok());
      ASSERT_TRUE(writer->append_image(image).ok());
      ASSERT_TRUE(writer->commit().ok());
      // The second one stays as it was recorded: not folded.
      if (session == 1) {
        ASSERT_TRUE(writer->end(CloseReason::finished, kStartUtc_ns).ok());
      }
    }
  }
  // What can be read out of a file's blobs, one after the other; nothing when it cannot be read. Samples are unpacked: some bits of a zstd frame
  // mean nothing, and its checksum is of the content.
  static std::optional<std::string> contents(Database& database) {
    try {
      std::string all;
      ChunkDecoder decoder;
      for (Statement row(database.handle(), "SELECT directory, body FROM chunks ORDER BY id"); row.step();) {
        ChunkDirectory directory;
        if (parse_directory(row.blob_at(0), directory) != CodecError::none) return std::nullopt;
        std::vector<std::size_t> which(directory.columns.size());
        std::iota(which.begin(), which.end(), std::size_t{0});
        std::vector<std::vector<std::int64_t>> columns(which.size());
        if (decoder.columns(directory, which, row.blob_at(1), columns) != CodecError::none) return std::nullopt;
        for (const std::vector<std::int64_t>& values : columns)
          for (const std::int64_t value : values) all += std::to_string(value) + ' ';
      }
      for (const char* sql : {"SELECT body FROM bus_chunks ORDER BY id", "SELECT body FROM journal_chunks ORDER BY id",
                              "SELECT body FROM core_images ORDER BY id"})
        for (Statement row(database.handle(), sql); row.step();) {
          const ByteView bytes = row.blob_at(0);
          all.append(bytes.begin(), bytes.end());
        }
      return all;
    } catch (const SqlFailure&) {
      return std::nullopt;
    }
  }
  void flip(const std::filesystem::path& file, std::uintmax_t at) { flip_bits(file, at, 0x40); }
  void flip_bits(const std::filesystem::path& file, std::uintmax_t at, int bits) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(at));
    const int byte = stream.get();
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(static_cast<char>(byte ^ bits));
  }

  TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_ / "hoist.db";
};

TEST_F(Integrity, NoFlippedByteOfARecordingPassesUnnoticed) {
  std::optional<std::string> whole;
  {
    Database database = std::move(*Database::attach(file_));
    const auto report = check_integrity(database, kGoOn);
    ASSERT_TRUE(report.ok());
    EXPECT_TRUE((*report)->sound());
    EXPECT_EQ((*report)->file_id.size(), 16U);
    EXPECT_GE((*report)->blobs, 8U) << "each kind of blob of both sessions";
    whole = contents(database);
    ASSERT_TRUE(whole);
  }
  // Other bytes in each repetition (deploy/dev soak --cuts).
  static std::uint32_t repetition = 5;
  std::mt19937 random(repetition++);
  int at_open = 0, in_structure = 0, in_blobs = 0;
  const int copies = tests::seeds_for(400, 400, 100);
  for (int i = 0; i < copies; ++i) {
    const std::filesystem::path copy = folder_ / ("copy" + std::to_string(i) + ".db");
    std::filesystem::copy_file(file_, copy);
    const std::uintmax_t at = random() % std::filesystem::file_size(copy);
    flip(copy, at);
    Result<Database> opened = Database::open(copy);
    if (!opened || !opened->report().set_aside.empty()) {
      ++at_open;
      continue;
    }
    const auto report = check_integrity(*opened, kGoOn);
    ASSERT_TRUE(report.ok()) << "byte " << at << ": " << report.error().message;
    in_structure += (*report)->structure.empty() ? 0 : 1;
    in_blobs += (*report)->damaged_blobs > 0 ? 1 : 0;
    if ((*report)->sound()) {
      EXPECT_TRUE(contents(*opened) == whole) << "byte " << at;
    }
  }
  EXPECT_GT(in_structure, 0);
  EXPECT_GT(in_blobs, copies / 13);
  std::printf("%d noticed when opened, %d in pages, %d in blobs\n", at_open, in_structure, in_blobs);
}

// Every page stays well formed; only our statements no longer find their column or table.
TEST_F(Integrity, ADamagedNameInTheSchemaIsDamage) {
  for (const std::string name : {"  directory BLOB", "  frames INTEGER"}) {
    const std::filesystem::path copy = folder_ / (name.substr(2, 6) + ".db");
    std::filesystem::copy_file(file_, copy);
    std::ifstream stream(copy, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    const std::size_t at = bytes.find(name);
    ASSERT_NE(at, std::string::npos);
    flip_bits(copy, at + 3, 0x01);
    Result<Database> opened = Database::open(copy);
    ASSERT_TRUE(opened.ok() && opened->report().set_aside.empty());
    const auto report = check_integrity(*opened, kGoOn);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ((*report)->structure.size(), 1U);
  }
}

TEST_F(Integrity, OfADamagedBlobTheSessionIsNamedAndTheFileStays) {
  {
    Database database = std::move(*Database::attach(file_));
    execute(database.handle(), "UPDATE bus_chunks SET body = zeroblob(length(body)) WHERE session_id = 2");
    execute(database.handle(), "UPDATE chunks SET body = zeroblob(length(body)) WHERE session_id = 1");
  }
  Database database = std::move(*Database::open(file_));
  EXPECT_TRUE(database.report().set_aside.empty());
  const auto report = check_integrity(database, kGoOn);
  ASSERT_TRUE(report.ok());
  EXPECT_TRUE((*report)->structure.empty());
  EXPECT_EQ((*report)->damaged_sessions, (std::vector<SessionId>{1, 2}));
}

TEST_F(Integrity, ItEndsWhereItIsToldTo) {
  std::vector<double> shares;
  int misses = 0;
  const auto run = [&](std::size_t most) {
    shares.clear();
    // A new connection has nothing in its cache.
    Database database = std::move(*Database::attach(file_));
    auto result = check_integrity(database, [&](double share) {
      shares.push_back(share);
      return shares.size() < most;
    });
    int highest = 0;
    sqlite3_db_status(database.handle(), SQLITE_DBSTATUS_CACHE_MISS, &misses, &highest, 0);
    EXPECT_TRUE(SessionReader(database).get(1).ok()) << "the connection is as before";
    return result;
  };
  ASSERT_TRUE((*run(1'000'000)).has_value());
  const std::size_t all = shares.size();
  const int all_misses = misses;
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_GE(shares.front(), 0.0);
  EXPECT_LE(shares.back(), 1.0);
  EXPECT_GT(shares.back(), 0.99);
  ASSERT_FALSE((*run(1)).has_value());
  EXPECT_LT(misses, all_misses / 2) << "pages are no longer asked for";
  for (std::size_t most = 1; most < all; ++most) {
    const auto ended = run(most);
    ASSERT_TRUE(ended.ok()) << ended.error().message;
    EXPECT_FALSE((*ended).has_value()) << most;
    EXPECT_EQ(shares.size(), most) << "nothing more is read";
  }
}

TEST_F(Integrity, AFileThatIsKnownToBeDamagedIsSetAsideWithoutAnotherLook) {
  auto opened = Database::open(file_, {.utc_now_ns = kStartUtc_ns, .damage = "page 7 is another's"});
  ASSERT_TRUE(opened.ok());
  EXPECT_EQ(opened->report().set_aside.filename(), "hoist.db.corrupt-20260921T141320Z");
  EXPECT_EQ(opened->report().set_aside_reason, "page 7 is another's");
  EXPECT_EQ(SessionReader(*opened).list()->total, 0U);
}

// However large the file: opening reads its first pages only.
TEST_F(Integrity, OpeningDoesNotLookAtTheWholeFile) {
  {
    Database database = std::move(*Database::attach(file_));
    execute(database.handle(), "CREATE TABLE much (body BLOB); INSERT INTO much SELECT zeroblob(20000000)");
    execute(database.handle(), "PRAGMA wal_checkpoint(TRUNCATE)");
  }
  const Database opened = std::move(*Database::open(file_));
  int misses = 0, highest = 0;
  sqlite3_db_status(opened.handle(), SQLITE_DBSTATUS_CACHE_MISS, &misses, &highest, 0);
  EXPECT_LT(misses, 20) << "pages of " << std::filesystem::file_size(file_) / 4096;
}

}  // namespace
}  // namespace hoist::db
