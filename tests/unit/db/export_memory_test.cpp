// How much memory an export holds at its peak: that of a long session is that of a short one. Counted are the bytes that the program holds (this
// file replaces operator new) and those of SQLite, which counts them itself. zlib and zstd keep tables of fixed size, outside of both.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sqlite3.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "db/export/bundle.hpp"
#include "db/export/session_export.hpp"
#include "db/summary/session_metrics.hpp"
#include "tests/unit/db/db_support.hpp"

namespace {

std::atomic<std::size_t> held{0}, peak{0};

void* taken(void* memory) noexcept {
  const std::size_t now = held += ::malloc_usable_size(memory);
  for (std::size_t was = peak; now > was && !peak.compare_exchange_weak(was, now);) continue;
  return memory;
}
void given(void* memory) noexcept {
  held -= ::malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) {
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return taken(memory);
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  void* memory = std::malloc(size == 0 ? 1 : size);
  return memory == nullptr ? nullptr : taken(memory);
}
void* operator new[](std::size_t size, const std::nothrow_t& no) noexcept { return operator new(size, no); }
void operator delete(void* memory) noexcept { given(memory); }
void operator delete[](void* memory) noexcept { given(memory); }
void operator delete(void* memory, std::size_t) noexcept { given(memory); }
void operator delete[](void* memory, std::size_t) noexcept { given(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { given(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { given(memory); }

namespace hoist::db::test {
namespace {

constexpr std::size_t kMinute = 6000;  // samples
constexpr int kShort_min = 8, kLong_min = 16;
/// Of a step. The short session has more than kFoldedBusFrames of them and several chunks of samples, so that the largest pieces are in both.
constexpr std::size_t kFrames = 3;
static_assert(kFrames * kMinute * kShort_min > kFoldedBusFrames);
/// Two a second, as of a fault that flickers.
constexpr std::size_t kStepsPerEvent = 50;
/// An export of the long session may hold this much more: less than a byte for each of its 48,000 further samples.
constexpr std::size_t kGrowth_bytes = 32 * 1024;

// Walking along an eight with a pause in each minute, as the longest bout sets how much its figures of smoothness take. Bus frames beside it.
void record(const std::filesystem::path& file, int minutes) {
  Database database = std::move(*Database::open(file));
  SessionWriter writer = std::move(*SessionWriter::create(database));
  SessionStart start = start_of_walk();
  start.exercise_json = R"({"shape":"eight","centre_m":1.0,"radius_m":0.8})";
  ASSERT_TRUE(writer.begin(start).ok());
  const contract::ReferencePath eight = contract::ReferencePath::eight(1.0, 0.8);
  Walk walk(1);
  double s_m = 0;
  for (std::size_t tick = 0; tick < kMinute * static_cast<std::size_t>(minutes);) {
    std::vector<contract::TickRecord> records;
    std::vector<contract::BusRecord> frames;
    std::vector<contract::Event> events;
    for (const std::size_t end = tick + 100; tick < end; ++tick) {
      contract::TickRecord r = walk.record(tick);
      const bool pause = tick % kMinute >= kMinute - 200;
      if (!pause) s_m += 0.004;
      const contract::PathPose at = eight.pose(s_m);
      r.speed_m_s = pause ? 0.0F : 0.4F;
      r.standing_still = pause ? 1 : 0;
      r.distance_m = static_cast<float>(s_m);
      r.fused_x_m = r.x_m = static_cast<float>(at.x_m);
      r.fused_y_m = r.y_m = static_cast<float>(at.y_m);
      r.fused_psi_rad = r.psi_rad = static_cast<float>(at.psi_rad);
      r.dpsi_rad = static_cast<float>(0.2 * at.kappa_per_m);
      records.push_back(r);
      contract::BusRecord frame;
      frame.time_ns = r.time_ns;
      frame.id = 0x191;
      frame.dlc = 8;
      frame.data = tick;
      frames.insert(frames.end(), kFrames, frame);
      if (tick % kStepsPerEvent != 0) continue;
      contract::Event event;
      event.tick = r.tick;
      event.time_ns = r.time_ns;
      event.kind = tick % (2 * kStepsPerEvent) == 0 ? contract::EventKind::fault_raised : contract::EventKind::fault_cleared;
      events.push_back(event);
    }
    ASSERT_TRUE(writer.append_ticks(records).ok());
    ASSERT_TRUE(writer.append_bus(frames).ok());
    ASSERT_TRUE(writer.append_events(events).ok());
    ASSERT_TRUE(writer.commit().ok());
  }
  ASSERT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok());
}

struct Held {
  std::size_t program = 0, sqlite = 0;  // bytes
};

// At the peak of `work`, more than before it. The cache of pages is of fixed size; it is made so small that the short session fills it, too.
template <typename Work>
Held held_by(const std::filesystem::path& file, Work work) {
  Database database = std::move(*Database::open(file));
  EXPECT_EQ(sqlite3_exec(database.handle(), "PRAGMA cache_size = -64", nullptr, nullptr, nullptr), SQLITE_OK);
  const std::size_t before = held;
  peak = before;
  sqlite3_int64 now = 0, highest = 0;
  sqlite3_status64(SQLITE_STATUS_MEMORY_USED, &now, &highest, 1);
  const auto sqlite_before = static_cast<std::size_t>(now);
  work(database);
  sqlite3_status64(SQLITE_STATUS_MEMORY_USED, &now, &highest, 0);
  return {peak - before, static_cast<std::size_t>(highest) - sqlite_before};
}

class ExportMemory : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = std::make_unique<TemporaryFolder>();
    record(*folder / "short.db", kShort_min);
    record(*folder / "long.db", kLong_min);
  }
  static void TearDownTestSuite() { folder.reset(); }

  template <typename Work>
  static void expect_no_growth(const std::string& what, Work work) {
    const Held few = held_by(*folder / "short.db", work), many = held_by(*folder / "long.db", work);
    const auto show = [](std::size_t bytes) { return std::to_string(bytes / 1024) + " KiB"; };
    RecordProperty(what, show(many.program) + " + " + show(many.sqlite));
    EXPECT_GT(few.program, 0U) << "nothing was counted";
    EXPECT_LE(many.program, few.program + kGrowth_bytes) << what << ": " << show(few.program) << " became " << show(many.program);
    EXPECT_LE(many.sqlite, few.sqlite + kGrowth_bytes) << what << ", SQLite: " << show(few.sqlite) << " became " << show(many.sqlite);
  }
  static inline std::unique_ptr<TemporaryFolder> folder;
};

template <typename Export>
void drain(Export& exported) {
  std::string piece;
  for (;;) {
    const Result<bool> more = exported.next_chunk(piece);
    ASSERT_TRUE(more.ok()) << more.error().message;
    if (!*more) break;
  }
}

TEST_F(ExportMemory, OfEachFormatDoesNotGrowWithTheSession) {
  for (const ExportFormatInfo& format : kExportFormats)
    expect_no_growth(std::string(format.name), [&](Database& database) {
      ExportOptions options;
      options.format = format.format;
      Result<SessionExport> exported = SessionExport::open(database, 1, options);
      ASSERT_TRUE(exported.ok());
      drain(*exported);
    });
}

TEST_F(ExportMemory, OfEachBundleDoesNotGrowWithItsSessions) {
  for (const BundleLayoutInfo& layout : kBundleLayouts)
    expect_no_growth("bundle_" + std::string(layout.name), [&](Database& database) {
      Result<Bundle> bundle = Bundle::open(database, {1}, layout.layout);
      ASSERT_TRUE(bundle.ok());
      drain(*bundle);
    });
}

TEST_F(ExportMemory, OfTheFiguresDoesNotGrowWithTheWalk) {
  expect_no_growth("figures", [](Database& database) {
    const Result<SessionMetrics> metrics = session_metrics(database, 1);
    ASSERT_TRUE(metrics.ok());
    EXPECT_TRUE((*metrics)["C"].value) << "the walk is compared with its exercise";
    EXPECT_TRUE((*metrics)["stride_time_cv_norm"].value) << "its strides are found";
    EXPECT_GT(*(*metrics)["turns_left"].value + *(*metrics)["turns_right"].value, 5.0);
  });
}

}  // namespace
}  // namespace hoist::db::test
