// Recording a walk beside plain SQLite rows of REAL columns, committed each quarter of a second; and CSV beside the sqlite3 shell.
#include <sqlite3.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "db/export/session_export.hpp"
#include "db/store/session_writer.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::bench {
namespace {
constexpr const char* kShell = "/usr/bin/sqlite3";
constexpr double kWalk_s = 600;
constexpr std::size_t kCommitEvery = 25;  // samples: 0.25 s
constexpr std::int64_t kStartUtc_ns = 1'700'000'000'000'000'000;

double thread_cpu_us() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}
double children_cpu_us() {
  rusage used{};
  ::getrusage(RUSAGE_CHILDREN, &used);
  const auto us = [](const timeval& t) { return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_usec); };
  return us(used.ru_utime) + us(used.ru_stime);
}
// Bytes that this process has asked the disk to write.
double written_bytes() {
  std::ifstream file("/proc/self/io");
  for (std::string word; file >> word;)
    if (word == "write_bytes:") {
      double bytes = 0;
      file >> bytes;
      return bytes;
    }
  return 0;
}
template <typename T>
T take(db::Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

std::vector<contract::TickRecord> walked() {
  tests::ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  tests::ClosedLoop loop(options);
  if (!loop.start(contract::Mode::user)) throw std::runtime_error("the walk did not start");
  std::vector<contract::TickRecord> records;
  for (int i = 0; i < static_cast<int>(kWalk_s * 100); ++i) {
    loop.step();
    records.push_back(loop.record());
  }
  return records;
}

struct Cost {
  double cpu_us = 0, written = 0, file = 0;
};
Cost since(double cpu_us, double written) { return {thread_cpu_us() - cpu_us, written_bytes() - written}; }

// Ours. The session is closed and folded outside the measured part; the file's size is that of the folded session.
Cost record_ours(db::Database& database, const std::vector<contract::TickRecord>& records, db::SessionId& id) {
  db::SessionWriter writer = take(db::SessionWriter::create(database));
  db::SessionStart start;
  start.started_utc_ns = kStartUtc_ns;
  start.start_time_ns = records.front().time_ns;
  id = take(writer.begin(start));
  const double cpu = thread_cpu_us(), written = written_bytes();
  const std::span<const contract::TickRecord> all(records);
  for (std::size_t at = 0; at + kCommitEvery <= all.size(); at += kCommitEvery) {
    if (!writer.append_ticks(all.subspan(at, kCommitEvery)).ok()) throw std::runtime_error("a sample was refused");
    (void)take(writer.commit());
  }
  const Cost cost = since(cpu, written);
  if (!writer.end(db::CloseReason::finished, kStartUtc_ns).ok()) throw std::runtime_error("the session does not close");
  return cost;
}

using Sqlite = std::unique_ptr<sqlite3, int (*)(sqlite3*)>;
void execute(sqlite3* database, const std::string& sql) {
  if (::sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) throw std::runtime_error(::sqlite3_errmsg(database));
}
// The file without its free pages.
double used_bytes(sqlite3* database) {
  sqlite3_stmt* ask = nullptr;
  ::sqlite3_prepare_v2(database,
                       "SELECT (page_count - freelist_count) * page_size FROM pragma_page_count, pragma_freelist_count, pragma_page_size",
                       -1, &ask, nullptr);
  const bool answered = ::sqlite3_step(ask) == SQLITE_ROW;
  const double bytes = answered ? ::sqlite3_column_double(ask, 0) : 0;
  ::sqlite3_finalize(ask);
  if (!answered) throw std::runtime_error(::sqlite3_errmsg(database));
  return bytes;
}
// The floor: one row per sample, each signal a REAL, same journal and durability.
Cost record_rows(const std::string& path, const std::vector<contract::TickRecord>& records) {
  sqlite3* raw = nullptr;
  if (::sqlite3_open(path.c_str(), &raw) != SQLITE_OK) throw std::runtime_error("sqlite3 does not open " + path);
  const Sqlite database(raw, ::sqlite3_close);
  execute(raw, "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;");
  std::string columns, marks;
  for (std::size_t i = 0; i < contract::kSignalCount; ++i) {
    columns += (i == 0 ? "" : ",") + std::string(contract::kSignals[i].name) + " REAL";
    marks += i == 0 ? "?" : ",?";
  }
  execute(raw, "CREATE TABLE samples(" + columns + ")");
  sqlite3_stmt* insert = nullptr;
  ::sqlite3_prepare_v2(raw, ("INSERT INTO samples VALUES(" + marks + ")").c_str(), -1, &insert, nullptr);
  const double cpu = thread_cpu_us(), written = written_bytes();
  for (std::size_t at = 0; at < records.size(); ++at) {
    if (at % kCommitEvery == 0) execute(raw, "BEGIN");
    for (std::size_t i = 0; i < contract::kSignalCount; ++i)
      ::sqlite3_bind_double(insert, static_cast<int>(i + 1), contract::signal_value(records[at], i));
    if (::sqlite3_step(insert) != SQLITE_DONE) throw std::runtime_error(::sqlite3_errmsg(raw));
    ::sqlite3_reset(insert);
    if ((at + 1) % kCommitEvery == 0) execute(raw, "COMMIT");
  }
  const Cost cost = since(cpu, written);
  ::sqlite3_finalize(insert);
  return cost;
}

double csv_ours_us(db::Database& database, db::SessionId id, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  const double before = thread_cpu_us();
  db::SessionExport csv = take(db::SessionExport::open(database, id));
  for (std::string piece; take(csv.next_chunk(piece));) file << piece;
  file.flush();
  return thread_cpu_us() - before;
}
double csv_shell_us(const std::string& rows, const std::string& out) {
  const double before = children_cpu_us();
  Process shell({kShell, "-csv", rows, "SELECT * FROM samples"}, out);
  if (shell.wait() != 0) throw std::runtime_error("the sqlite3 shell failed");
  return children_cpu_us() - before;
}
}  // namespace

void record_walk(const std::string& path, double seconds) {
  db::Database database = take(db::Database::open(path));
  db::SessionWriter writer = take(db::SessionWriter::create(database));
  tests::ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  tests::ClosedLoop loop(options);
  if (!loop.start(contract::Mode::user)) throw std::runtime_error("the walk did not start");
  db::SessionStart start;
  start.started_utc_ns = kStartUtc_ns;
  start.start_time_ns = loop.record().time_ns;
  (void)take(writer.begin(start));
  constexpr int kSecond = 100;
  std::vector<contract::TickRecord> records(10 * kSecond);
  std::vector<contract::BusRecord> frames;
  loop.on_inputs([&](const core::TickInputs& inputs) {
    for (const contract::CanFrame& frame : inputs.frames) {
      frames.push_back({inputs.time_ns, frame.id, frame.dlc, frame.flags, 0, 0, 0});
      std::memcpy(&frames.back().data, frame.data.data(), sizeof frames.back().data);
    }
  });
  for (int left = static_cast<int>(seconds) / 10; left > 0; --left) {
    for (contract::TickRecord& record : records) {
      loop.step();
      record = loop.record();
    }
    if (!writer.append_ticks(records).ok() || !writer.append_bus(frames).ok()) throw std::runtime_error("a sample was refused");
    frames.clear();
    (void)take(writer.commit());
  }
  if (!writer.end(db::CloseReason::finished, kStartUtc_ns).ok()) throw std::runtime_error("the session does not close");
}

void measure_recording(Report& report) {
  const TemporaryFolder folder;
  report.progress("simulating ten minutes of walking");
  const std::vector<contract::TickRecord> records = walked();
  const auto samples = static_cast<double>(records.size());
  db::SessionId id = 0;
  db::Database database = take(db::Database::open(folder.file("ours.db")));
  report.progress("recording them twice");
  const Cost ours = record_ours(database, records, id), rows = record_rows(folder.file("rows.db"), records);
  report.add(
      {"recording.cpu", "CPU per sample, commits each 0.25 s", ours.cpu_us / samples, "us", rows.cpu_us / samples, "REAL rows", {0.8}});
  if (rows.written > 0)
    report.add({"recording.written", "bytes written per sample", ours.written / samples, "B", rows.written / samples, "REAL rows", {0.45}});
  else
    report.skip("recording.written", "bytes written per sample", "/proc/self/io counts no bytes: the temporary folder is in memory");
  report.add({"recording.size",
              "bytes kept per sample, session closed",
              used_bytes(database.handle()) / samples,
              "B",
              0,
              "",
              {41},
              true,
              std::to_string(contract::kSignalCount) + " signals"});
  const char* csv = "CPU of the CSV of ten minutes";
  if (::access(kShell, X_OK) != 0) {
    report.skip("recording.csv", csv, std::string("the sqlite3 shell is missing (") + kShell + ")");
    return;
  }
  const double ours_us = csv_ours_us(database, id, folder.file("ours.csv"));
  report.add({"recording.csv",
              csv,
              ours_us * 1e-3,
              "ms",
              csv_shell_us(folder.file("rows.db"), folder.file("rows.csv")) * 1e-3,
              "sqlite3 -csv",
              {0.1}});
}

}  // namespace hoist::bench
