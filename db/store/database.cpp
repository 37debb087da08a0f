#include "db/store/database.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "db/store/column_layouts.hpp"
#include "db/store/fold.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/identity.hpp"
#include "db/store/owner.hpp"
#include "db/store/patient_code.hpp"
#include "db/store/restore_remains.hpp"
#include "db/store/schema_list.hpp"
#include "db/store/session_number.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

int user_version(sqlite3* handle) { return static_cast<int>(number_of(handle, "PRAGMA user_version")); }

std::string compact_utc(std::int64_t utc_ns) {
  const std::time_t seconds = utc_ns / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  const std::size_t n = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &parts);
  return {text.data(), n};
}

constexpr std::string_view kAsideInfix = ".corrupt-";
constexpr std::array<std::string_view, 3> kCompanions{"-wal", "-shm", ".seal"};

// Renames NAME, NAME-wal, NAME-shm and NAME.seal; the log belongs to its file and may help to repair it.
Result<std::filesystem::path> set_aside(const std::filesystem::path& file, std::int64_t utc_now_ns) {
  constexpr int kNameTries = 100;
  std::error_code error;
  const std::string base = file.string() + std::string(kAsideInfix) + compact_utc(utc_now_ns);
  std::string target = base;
  for (int i = 1; std::filesystem::exists(target, error) && i < kNameTries; ++i) target = base + "-" + std::to_string(i);
  const auto move = [&](std::string_view suffix) {
    const std::string from = file.string() + std::string(suffix);
    if (!std::filesystem::exists(from, error)) return std::string();
    std::filesystem::rename(from, target + std::string(suffix), error);
    return error ? "the damaged database " + from + " could not be set aside: " + error.message() : std::string();
  };
  std::string problem = move("");
  for (const std::string_view suffix : kCompanions)
    if (problem.empty()) problem = move(suffix);
  if (!problem.empty()) return Error{ErrorKind::io, problem, {}};
  return std::filesystem::path(target);
}

// The newest by its date, which is in its name. What belongs to a file counts without it: the file itself may have been gone.
std::filesystem::path newest_aside(const std::filesystem::path& file) {
  const std::string prefix = file.filename().string() + std::string(kAsideInfix);
  std::filesystem::path newest;
  std::error_code error;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (std::string name = entry->path().filename().string(); name.starts_with(prefix)) {
      for (const std::string_view suffix : kCompanions)
        if (name.ends_with(suffix)) name.resize(name.size() - suffix.size());
      newest = std::max(newest, folder / name);
    }
  return newest;
}

Error foreign_file(const std::filesystem::path& file, const std::string& why) {
  return {ErrorKind::foreign, file.string() + " " + why + " and stays as it is: choose another file", {}};
}

Error newer(const std::filesystem::path& file, int version) {
  return {ErrorKind::newer_schema,
          "the database " + file.string() + " was written by a newer Hoist (schema " + std::to_string(version) + ", this one knows " +
              std::to_string(schema_version()) + "): install that version, or choose another file",
          {}};
}

// What was acknowledged by its seal and is not in the file. A seal of another file says nothing; an empty file has lost all.
std::optional<LostCommits> lost_commits(sqlite3* handle, const std::filesystem::path& file, bool was_empty) {
  const std::optional<Seal::Content> sealed = Seal::read(file);
  if (!sealed) return std::nullopt;
  Statement row(handle, "SELECT file_id, commits FROM seal");
  if (!row.step()) throw SqlFailure{Error{ErrorKind::corrupt, "the database has no seal", {}}};
  if (!was_empty && row.text_at(0) != sealed->file_id) return std::nullopt;
  const std::uint64_t held = was_empty ? 0 : row.unsigned_at(1);
  if (held >= sealed->commits) return std::nullopt;
  return LostCommits{sealed->commits - held, sealed->session, sealed->last_tick};
}

}  // namespace

int schema_version() { return static_cast<int>(schema_list().size()); }

namespace {
void bring_up_to_date(sqlite3* handle) {
  for (int next = user_version(handle); next < schema_version(); ++next) {
    Transaction transaction(handle, Transaction::Kind::write);
    execute(handle, std::string(schema_list()[static_cast<std::size_t>(next)]).c_str());
    execute(handle, ("PRAGMA user_version = " + std::to_string(next + 1)).c_str());
    transaction.commit();
  }
}
}  // namespace

Database::Database(Database&& other) noexcept
    : handle_(std::exchange(other.handle_, nullptr)),
      file_(std::move(other.file_)),
      report_(std::move(other.report_)),
      lock_(std::move(other.lock_)),
      seal_(std::move(other.seal_)) {}
Database& Database::operator=(Database&& other) noexcept {
  std::swap(handle_, other.handle_);
  std::swap(file_, other.file_);
  std::swap(report_, other.report_);
  std::swap(lock_, other.lock_);
  std::swap(seal_, other.seal_);
  return *this;
}
Database::~Database() { sqlite3_close_v2(handle_); }

Status Database::migrate() {
  return guarded([&]() -> Status {
    bring_up_to_date(handle_);
    report_.schema_version = schema_version();
    return {};
  });
}

std::string Database::file_id() const {
  try {
    Statement row(handle_, "SELECT file_id FROM seal");
    return row.step() ? row.text_at(0) : std::string();
  } catch (const SqlFailure&) {
    return {};
  }
}

namespace {
constexpr int kFunctionFlags = SQLITE_UTF8 | SQLITE_DETERMINISTIC | SQLITE_DIRECTONLY;
// code_has(code, part): whether a patient code contains this part, capital or small. For our own statements, never for a file's schema.
void add_code_has(sqlite3* handle) {
  const auto call = [](sqlite3_context* context, int, sqlite3_value** values) {
    const auto text = [](sqlite3_value* value) {
      const auto* bytes = reinterpret_cast<const char*>(sqlite3_value_text(value));
      return folded({bytes == nullptr ? "" : bytes, static_cast<std::size_t>(sqlite3_value_bytes(value))});
    };
    sqlite3_result_int(context, text(values[0]).find(text(values[1])) != std::string::npos ? 1 : 0);
  };
  const int code = sqlite3_create_function(handle, "code_has", 2, kFunctionFlags, nullptr, call, nullptr, nullptr);
  if (code != SQLITE_OK) throw_sql(handle, code, "adding code_has()");
}
// code_same(code, other): whether both mean the same patient (patient_code.hpp).
void add_code_same(sqlite3* handle) {
  const auto call = [](sqlite3_context* context, int, sqlite3_value** values) {
    const auto text = [](sqlite3_value* value) {
      const auto* bytes = reinterpret_cast<const char*>(sqlite3_value_text(value));
      return std::string_view(bytes == nullptr ? "" : bytes, static_cast<std::size_t>(sqlite3_value_bytes(value)));
    };
    sqlite3_result_int(context, same_code(text(values[0]), text(values[1])) ? 1 : 0);
  };
  const int code = sqlite3_create_function(handle, "code_same", 2, kFunctionFlags, nullptr, call, nullptr, nullptr);
  if (code != SQLITE_OK) throw_sql(handle, code, "adding code_same()");
}
// hash_text(text): names a layout of columns; for the migration.
void add_hash_text(sqlite3* handle) {
  const auto call = [](sqlite3_context* context, int, sqlite3_value** values) {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_value_text(values[0]));
    sqlite3_result_int64(context, hash_text({bytes == nullptr ? "" : bytes, static_cast<std::size_t>(sqlite3_value_bytes(values[0]))}));
  };
  const int code = sqlite3_create_function(handle, "hash_text", 1, kFunctionFlags, nullptr, call, nullptr, nullptr);
  if (code != SQLITE_OK) throw_sql(handle, code, "adding hash_text()");
}
}  // namespace

Result<Database> Database::connect(const std::filesystem::path& file, const OpenOptions& options, bool create) {
  return guarded([&]() -> Result<Database> {
    Database database;
    database.file_ = file;
    std::error_code ignored;
    const bool made = create && options.vfs == nullptr && !std::filesystem::exists(file, ignored);
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | (create ? SQLITE_OPEN_CREATE : 0);
    const int code = sqlite3_open_v2(file.c_str(), &database.handle_, flags, options.vfs);
    if (code != SQLITE_OK) throw_sql(database.handle_, code, "opening " + file.string());
    // Before SQLite makes the log beside it, which gets the same owner.
    if (made) (void)give_to_owner(file);
    sqlite3_extended_result_codes(database.handle_, 1);
    sqlite3_busy_timeout(database.handle_, kBusyTimeout_ms);
    // A file handed to us must not be able to run anything: no trusted schema, no loadable code.
    sqlite3_db_config(database.handle_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(database.handle_, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    execute(database.handle_, "PRAGMA foreign_keys = ON");
    execute(database.handle_, "PRAGMA cell_size_check = ON");
    execute(database.handle_, "PRAGMA synchronous = FULL");
    add_code_has(database.handle_);
    add_code_same(database.handle_);
    add_hash_text(database.handle_);
    if (options.max_pages > 0) execute(database.handle_, ("PRAGMA max_page_count = " + std::to_string(options.max_pages)).c_str());
    return database;
  });
}

Result<Database> Database::attach(const std::filesystem::path& file, const OpenOptions& options) {
  if (options.vfs == nullptr)
    if (const Identified found = identify(file); found.identity == FileIdentity::foreign) return foreign_file(file, found.why);
  Result<Database> database = connect(file, options, false);
  if (!database) return database;
  return guarded([&]() -> Result<Database> {
    const int version = user_version(database->handle_);
    if (version != schema_version())
      return Error{version > schema_version() ? ErrorKind::newer_schema : ErrorKind::wrong_state,
                   "the database " + file.string() + " has schema " + std::to_string(version) + ", this program needs " +
                       std::to_string(schema_version()) + ": let the server of the same version open it first",
                   {}};
    database->report_.migrated_from = database->report_.schema_version = version;
    return std::move(database);
  });
}

Result<Database> Database::inspect(const std::filesystem::path& file, const OpenOptions& options) {
  if (options.vfs == nullptr) {
    const Identified found = identify(file);
    if (found.identity == FileIdentity::foreign) return foreign_file(file, found.why);
    if (found.identity != FileIdentity::ours)
      return Error{ErrorKind::corrupt, file.string() + " holds no recordings" + (found.why.empty() ? "" : ": " + found.why), {}};
  }
  Result<Database> database = connect(file, options, false);
  if (!database) return database;
  return guarded([&]() -> Result<Database> {
    const int version = user_version(database->handle_);
    if (version > schema_version()) return newer(file, version);
    if (version == 0) return Error{ErrorKind::corrupt, file.string() + " holds no recordings", {}};
    database->report_.migrated_from = database->report_.schema_version = version;
    return std::move(database);
  });
}

Result<Database> Database::create_copy(const std::filesystem::path& file, const OpenOptions& options) {
  return connect(file, options, true);
}

Status Database::leave_log(const std::filesystem::path& file) {
  const Result<Database> database = connect(file, {}, false);
  if (!database) return database.error();
  return guarded([&]() -> Status {
    Statement mode(database->handle_, "PRAGMA journal_mode = DELETE");
    if (mode.step() && mode.text_at(0) == "delete") return {};
    return Error{ErrorKind::busy, "another program reads " + file.string() + ": end it first", {}};
  });
}

Result<Database> Database::open(const std::filesystem::path& file, const OpenOptions& options) {
  OpenReport report;
  // Before anything is looked at: a file that another program writes is neither checked nor set aside.
  std::shared_ptr<WriteLock> lock = options.lock;
  if (lock == nullptr && options.vfs == nullptr) {
    auto taken = WriteLock::take(file);
    if (!taken) return taken.error();
    lock = std::move(*taken);
  }
  if (options.vfs == nullptr) tidy_after_restore(file);
  // Twice at most: a damaged file is set aside once, its empty successor is sound.
  for (int round = 0;; ++round) {
    std::error_code ignored;
    report.created = report.created || !std::filesystem::exists(file, ignored);
    // Before SQLite sees it: opening a database may already write to it, and an empty one has its log deleted.
    const Identified found = options.vfs == nullptr ? identify(file) : Identified{};
    if (found.identity == FileIdentity::foreign) return foreign_file(file, found.why);
    std::string damage = round == 0 && !options.damage.empty() ? options.damage : found.why;
    Result<Database> connected = damage.empty() ? connect(file, options, true) : Error{ErrorKind::corrupt, damage, {}};
    if (!connected) {
      if (connected.error().kind != ErrorKind::corrupt || round > 0) return connected;
      damage = connected.error().message;
    } else {
      Result<Database> opened = guarded([&]() -> Result<Database> {
        sqlite3* handle = connected->handle_;
        // SQLite compares the header's size with the file's and reads the whole schema. This needs a few pages, however large the file is.
        (void)number_of(handle, "SELECT count(*) FROM sqlite_schema");
        const int version = user_version(handle);
        if (version > schema_version()) return newer(file, version);
        // Before the log begins: what a file is must stand in the file itself.
        if (number_of(handle, "PRAGMA application_id") != kApplicationId)
          execute(handle, ("PRAGMA application_id = " + std::to_string(kApplicationId)).c_str());
        execute(handle, "PRAGMA journal_mode = WAL");
        bring_up_to_date(handle);
        report.migrated_from = version;
        report.schema_version = schema_version();
        if (options.vfs == nullptr) {
          report.kept_aside = newest_aside(file);
          report.lost = lost_commits(handle, file, version == 0);
          connected->seal_ = std::make_shared<Seal>(file);
          (void)give_to_owner(Seal::beside(file), file);
        }
        // An empty file in the place of one that was set aside is of the same hoist.
        ensure_hoist_id(handle, version == 0 && !report.kept_aside.empty() ? hoist_id_of(report.kept_aside) : std::string());
        // Also at a later start: the one that set it aside may have been killed before. The damaged file itself might tell any number.
        if (const auto sealed = report.kept_aside.empty() ? std::nullopt : Seal::read(report.kept_aside))
          take_session_numbers(handle, sealed->session);
        connected->report_ = report;
        connected->lock_ = lock;
        return std::move(connected);
      });
      if (opened || opened.error().kind != ErrorKind::corrupt || round > 0) return opened;
      damage = opened.error().message;
      // Close before renaming, so that SQLite does not write to the file under its new name.
      { const Database closed = std::move(*connected); }
    }
    Result<std::filesystem::path> aside = set_aside(file, options.utc_now_ns);
    if (!aside) return aside.error();
    report.set_aside = *aside;
    report.set_aside_reason = damage;
    report.created = true;
  }
}

}  // namespace hoist::db
