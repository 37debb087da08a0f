// A file as large as a year of use, and how long the server's uses of it take: hoist-year FILE GB. For `deploy/dev soak --year`.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/deletion.hpp"
#include "db/store/retention.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/session_writer.hpp"
#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using namespace test;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSamples = 36000;  // a walk of six minutes
constexpr std::size_t kFramesPerStep = 9;
constexpr std::int64_t kEvery_ns = 900'000'000'000;  // a walk each quarter of an hour
constexpr int kSessionsPerCommit = 20;

double since_ms(Clock::time_point begin) { return std::chrono::duration<double, std::milli>(Clock::now() - begin).count(); }

[[noreturn]] void fail(const std::string& why) {
  std::fprintf(stderr, "hoist-year: %s\n", why.c_str());
  std::exit(1);
}

// One walk as the recorder stores it.
void record_walk(Database& database) {
  auto writer = SessionWriter::create(database);
  if (!writer || !writer->begin(start_of_walk())) fail("cannot record");
  Walk walk(1);
  std::mt19937_64 random(1);
  for (std::size_t tick = 0; tick < kSamples; tick += 100) {
    std::vector<contract::BusRecord> frames;
    std::vector<contract::JournalStep> steps;
    for (std::size_t i = tick; i < tick + 100; ++i) {
      const std::uint64_t time_ns = kStart_ns + i * kTick_ns;
      for (std::size_t f = 0; f < kFramesPerStep; ++f) {
        contract::BusRecord& frame = frames.emplace_back();
        frame.time_ns = time_ns;
        frame.id = static_cast<std::uint32_t>(0x181 + f);
        frame.dlc = 8;
        frame.data = i << 48U | (random() & 0x0003'0003'0003U);
      }
      contract::JournalStep& step = steps.emplace_back();
      step.step = step.tick = i;
      step.time_ns = time_ns;
      step.frames = kFramesPerStep;
      step.record_digest = static_cast<std::uint32_t>(random());
    }
    contract::CoreImage image;
    image.step = image.tick = tick;
    image.bytes = 30000;
    for (std::size_t b = 0; b < image.bytes; b += 4) image.memory[b] = static_cast<std::uint8_t>(random());
    const bool well = writer->append_ticks(walk.records(tick, 100)).ok() && writer->append_bus(frames).ok() &&
                      writer->append_journal(steps, {}).ok() && writer->append_image(image).ok() && writer->commit().ok();
    if (!well) fail("cannot record");
  }
  if (!writer->end(CloseReason::finished, kStartUtc_ns + 360'000'000'000)) fail("cannot end");
}

// The same walk again, as another session of a later quarter of an hour.
void repeat_walk(sqlite3* handle, std::int64_t number) {
  const std::string id = std::to_string(number);
  execute(handle, ("INSERT INTO sessions (visit_id, started_utc_ns, start_time_ns, core_start_time_ns, simulated, layout_hash, "
                   "software_version, note, exercise, core_version, columns_hash, ended_utc_ns, close_reason, sample_count, first_time_ns, "
                   "last_time_ns, folded) SELECT visit_id, started_utc_ns + (" +
                   id + " - 1) * " + std::to_string(kEvery_ns) +
                   ", start_time_ns, core_start_time_ns, simulated, layout_hash, software_version, note, exercise, core_version, "
                   "columns_hash, ended_utc_ns + (" +
                   id + " - 1) * " + std::to_string(kEvery_ns) +
                   ", close_reason, sample_count, first_time_ns, last_time_ns, folded FROM sessions WHERE id = 1")
                      .c_str());
  for (const char* columns :
       {"chunks (session_id, first_tick, last_tick, first_time_ns, last_time_ns, samples, directory, body) SELECT @, first_tick, "
        "last_tick, "
        "first_time_ns, last_time_ns, samples, directory, body FROM chunks",
        "bus_chunks (session_id, first_frame, frames, first_time_ns, last_time_ns, body) SELECT @, first_frame, frames, first_time_ns, "
        "last_time_ns, body FROM bus_chunks",
        "journal_chunks (session_id, first_step, steps, body) SELECT @, first_step, steps, body FROM journal_chunks",
        "core_images (session_id, step, tick, bytes, body) SELECT @, step, tick, bytes, body FROM core_images"}) {
    std::string sql = std::string("INSERT INTO ") + columns + " WHERE session_id = 1";
    sql.replace(sql.find('@'), 1, id);
    execute(handle, sql.c_str());
  }
}

void fill(const std::filesystem::path& file, double gigabytes) {
  auto opened = Database::open(file);
  if (!opened) fail(opened.error().message);
  record_walk(*opened);
  sqlite3* handle = opened->handle();
  const auto pages = [&](const char* sql) {
    Statement row(handle, sql);
    row.step();
    return static_cast<double>(row.integer_at(0));
  };
  const double page_bytes = pages("PRAGMA page_size");
  execute(handle, "PRAGMA synchronous = OFF");
  for (std::int64_t number = 2; pages("PRAGMA page_count") * page_bytes < gigabytes * 1e9;) {
    Transaction transaction(handle, Transaction::Kind::write);
    for (int i = 0; i < kSessionsPerCommit; ++i) repeat_walk(handle, number++);
    transaction.commit();
  }
}

void forget_cached(const std::filesystem::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  ::fsync(descriptor);
  ::posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
  ::close(descriptor);
}

template <typename Work>
void measure(const char* what, const std::filesystem::path& file, Work work) {
  forget_cached(file);
  const auto cold_begin = Clock::now();
  const bool well = work();
  const double cold = since_ms(cold_begin);
  const auto warm_begin = Clock::now();
  const bool again = work();
  if (!well || !again) fail(std::string(what) + " failed");
  std::printf("%-44s %10.1f ms %10.1f ms\n", what, cold, since_ms(warm_begin));
}

void measure_all(const std::filesystem::path& file) {
  std::printf("%-44s %13s %13s\n", "", "in no cache", "again");
  measure("open for recording", file, [&] {
    auto opened = Database::open(file);
    return opened.ok() && SessionWriter::create(*opened).ok();
  });
  auto opened = Database::open(file);
  if (!opened) fail(opened.error().message);
  Database& database = *opened;
  const SessionReader reader(database);
  const std::uint64_t total = reader.list()->total;
  const auto middle = static_cast<SessionId>(total / 2);
  measure("newest 50 sessions", file, [&] { return reader.list().ok(); });
  measure("50 sessions in the middle", file, [&] { return reader.list({.limit = 50, .before = middle, .subject = {}}).ok(); });
  measure("50 sessions of one code", file, [&] { return reader.list({.limit = 50, .before = {}, .subject = "017"}).ok(); });
  measure("visits", file, [&] { return VisitReader(database).visits().ok(); });
  measure("patients", file, [&] { return VisitReader(database).patients().ok(); });
  measure("one session", file, [&] { return reader.get(middle).ok(); });
  const std::vector<std::string> names{"speed_m_s", "lean_norm", "turn_norm", "x_m"};
  measure("overview of a session, 4 live values", file, [&] { return reader.overview(middle, names, 1000).ok(); });
  measure("all samples of 4 live values", file, [&] { return reader.read_columns(middle, names).ok(); });
  const RetentionRule rule{.days = kLeastKept_days, .disk_percent = {}, .needs_backup = false};
  std::size_t old = 0;
  measure("what a rule of retention would delete", file, [&] {
    constexpr std::int64_t kFarFuture_ns = 1LL << 62U;
    const auto plan = plan_retention(database, rule, kFarFuture_ns, 1, [](double) { return true; });
    old = plan && *plan ? (*plan)->sessions.size() : 0;
    return old > 0;
  });
  std::printf("%-44s %10zu\n", "  sessions in it", old);
  SessionId next = middle;
  measure("begin and end of a session", file, [&] {
    auto writer = SessionWriter::create(database);
    return writer.ok() && writer->begin(start_of_walk()).ok() && writer->end(CloseReason::finished, kStartUtc_ns).ok();
  });
  double longest = 0;
  measure("deletion of a session", file, [&] {
    if (!take_out(database, next++)) return false;
    for (;;) {
      const auto begin = Clock::now();
      const auto more = erase_piece(database);
      longest = std::max(longest, since_ms(begin));
      if (!more) return false;
      if (!*more) return true;
    }
  });
  std::printf("%-44s %10.1f ms\n", "  its longest piece", longest);
  std::printf("%llu sessions, %.1f GB\n", static_cast<unsigned long long>(total),
              static_cast<double>(std::filesystem::file_size(file)) / 1e9);
}

}  // namespace
}  // namespace hoist::db

int main(int argc, char** argv) {
  const double gigabytes = argc == 3 ? std::atof(argv[2]) : 0;
  if (gigabytes <= 0) {
    std::fputs("usage: hoist-year FILE GB\n", stderr);
    return 2;
  }
  if (!std::filesystem::exists(argv[1])) hoist::db::fill(argv[1], gigabytes);
  hoist::db::measure_all(argv[1]);
  return 0;
}
