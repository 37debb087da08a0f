// One connection to the file that holds all sessions. WAL, synchronous = FULL: what a commit acknowledged survives a power cut.
// A connection belongs to one thread. The recorder opens one for writing; readers open their own; all may be open at the same time.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/store/result.hpp"
#include "db/store/seal.hpp"
#include "db/store/write_lock.hpp"

struct sqlite3;

namespace hoist::db {

/// How long a statement waits for another connection's lock.
inline constexpr int kBusyTimeout_ms = 2000;

struct OpenOptions {
  /// Wall clock now; used for the name of a file that is set aside. Never read from the system here.
  std::int64_t utc_now_ns = 0;
  /// For tests: the name of a registered SQLite VFS, and a limit of the file's pages (0 = none) that stands for a full disk.
  const char* vfs = nullptr;
  std::int64_t max_pages = 0;
  /// For `open`: the file's lock when it is held already; `open` takes it otherwise (not with a VFS, whose files may not be the system's).
  std::shared_ptr<WriteLock> lock = {};
  /// For `open`: what a check (integrity.hpp) has found wrong with the file. Not empty: the file is set aside without another look.
  std::string damage = {};
};

/// Commits that were acknowledged and are not in the file: its log was cut, or an earlier state of it was put back.
struct LostCommits {
  std::uint64_t commits = 0;
  std::int64_t session = 0;     ///< the newest that was recorded then
  std::uint64_t last_tick = 0;  ///< of that session; 0 = none
};

/// What opening found and did; each is worth a line in the log, and what is set aside or lost a standing notice.
struct OpenReport {
  bool created = false;
  int migrated_from = 0;             ///< schema version found (0 = empty file)
  int schema_version = 0;            ///< schema version now
  std::filesystem::path set_aside;   ///< where a corrupt file was moved to; empty when there was none
  std::string set_aside_reason;      ///< what was found wrong
  std::filesystem::path kept_aside;  ///< the newest file that is still there from now or an earlier start; empty when there is none
  std::optional<LostCommits> lost;
};

class Database {
 public:
  /// Opens or creates the file for writing and keeps its lock (write_lock.hpp) as long as the connection lives; brings its schema up to date.
  /// It reads header, size and schema only, however large the file is: the rest is check_integrity's. A corrupt file of ours (with its -wal,
  /// -shm and seal) is renamed to NAME.corrupt-YYYYMMDDTHHMMSSZ and an empty one takes its place: `report().set_aside` says so. Call it before
  /// any reader of this start.
  /// Errors: newer_schema, foreign, io, disk_full, busy (also: another program writes the file).
  static Result<Database> open(const std::filesystem::path& file, const OpenOptions& options = {});
  /// Opens an existing file that `open` has prepared: for reading, and for SessionEditor. No check, no migration.
  static Result<Database> attach(const std::filesystem::path& file, const OpenOptions& options = {});
  /// Opens a file that no program records into, as it is: a backup, a copy. Any schema up to this program's, which `report()` names.
  /// Errors: foreign, newer_schema, corrupt (also: a file without recordings), io.
  static Result<Database> inspect(const std::filesystem::path& file, const OpenOptions& options = {});
  /// An empty database without a schema, for a copy.
  static Result<Database> create_copy(const std::filesystem::path& file, const OpenOptions& options = {});
  /// Writes the log back and removes it, so that the file is whole by itself until it is opened again. Error busy: it is in use.
  static Status leave_log(const std::filesystem::path& file);

  Database(Database&&) noexcept;
  Database& operator=(Database&&) noexcept;
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;
  ~Database();

  [[nodiscard]] const OpenReport& report() const { return report_; }
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  /// 16 hexadecimal digits that tell this file from another under the same name; empty when they cannot be read.
  [[nodiscard]] std::string file_id() const;
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Brings the schema of a file up to date that no program records into: a copy that `inspect` has opened.
  Status migrate();
  /// Null for a connection that does not record.
  [[nodiscard]] const std::shared_ptr<Seal>& seal() const { return seal_; }

 private:
  Database() = default;
  static Result<Database> connect(const std::filesystem::path& file, const OpenOptions& options, bool create);

  sqlite3* handle_ = nullptr;
  std::filesystem::path file_;
  OpenReport report_;
  std::shared_ptr<WriteLock> lock_;
  std::shared_ptr<Seal> seal_;
};

/// The schema version this program writes: the number of the newest file in db/schema.
int schema_version();

}  // namespace hoist::db
