#include "db/store/backup.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <openssl/evp.h>
#include <sqlite3.h>
#include <sys/statvfs.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <utility>

#include "db/store/device_settings.hpp"
#include "db/store/hoist_id.hpp"
#include "db/store/owner.hpp"
#include "db/store/restore_remains.hpp"
#include "db/store/retention.hpp"
#include "db/store/session_number.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

// Pages of one piece (1 MB), and pieces between two syncs: what waits unwritten in memory would delay the recorder's own syncs.
constexpr int kPiece_pages = 256;
constexpr int kPiecesPerSync = 8;
// A copy is read once more by its check, and once for its hash.
constexpr double kCopyShare = 0.5, kCheckShare = 0.8;
constexpr std::uint64_t kReserve_bytes = 8 << 20;  // of the target, for the manifest and the file system's own
constexpr std::uint64_t kFat32Most_bytes = 0xFFFFFFFF;
constexpr std::string_view kPart = ".part";
constexpr int kManifestVersion = 1;

Error io_error(const std::string& what, const std::error_code& code) {
  const ErrorKind kind = code == std::errc::no_space_on_device      ? ErrorKind::disk_full
                         : code == std::errc::read_only_file_system ? ErrorKind::read_only
                                                                    : ErrorKind::io;
  return {kind, what + ": " + code.message(), {}};
}
std::error_code last_error() { return {errno, std::generic_category()}; }

class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags) : number_(::open(file.c_str(), flags | O_CLOEXEC, 0600)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }

 private:
  int number_;
};

// Names are as durable as the folder that has them.
Status sync(const fs::path& path, int flags) {
  const Descriptor descriptor(path, flags);
  if (!descriptor || ::fsync(descriptor.get()) != 0) return io_error(path.string() + " could not be written to the disk", last_error());
  return {};
}
Status sync_folder_of(const fs::path& file) {
  return sync(file.has_parent_path() ? file.parent_path() : fs::path("."), O_RDONLY | O_DIRECTORY);
}

// What is read afterwards comes from the device, not from memory.
void forget_cached(const fs::path& file) {
  if (const Descriptor descriptor(file, O_RDONLY); descriptor) ::posix_fadvise(descriptor.get(), 0, 0, POSIX_FADV_DONTNEED);
}

void sync_database(sqlite3* handle) {
  sqlite3_file* file = nullptr;
  sqlite3_file_control(handle, "main", SQLITE_FCNTL_FILE_POINTER, &file);
  if (file == nullptr || file->pMethods == nullptr) return;
  if (const int code = file->pMethods->xSync(file, SQLITE_SYNC_NORMAL); code != SQLITE_OK)
    throw_sql(nullptr, code, "writing the copy to the disk");
}

// SQLite's copy of one database into another, in pieces. The copy is consistent because the source's snapshot is held.
class Copy {
 public:
  Copy(sqlite3* from, sqlite3* to) : to_(to), backup_(sqlite3_backup_init(to, "main", from, "main")) {
    if (backup_ == nullptr) throw_sql(to, sqlite3_extended_errcode(to), "beginning the copy");
  }
  ~Copy() { sqlite3_backup_finish(backup_); }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  // False at the end.
  bool piece() {
    const int code = sqlite3_backup_step(backup_, kPiece_pages);
    if (code == SQLITE_DONE) return false;
    if (code != SQLITE_OK) throw_sql(to_, code, "copying the database");
    return true;
  }
  [[nodiscard]] double share() const {
    const int all = std::max(1, sqlite3_backup_pagecount(backup_));
    return 1.0 - static_cast<double>(sqlite3_backup_remaining(backup_)) / all;
  }

 private:
  sqlite3* to_;
  sqlite3_backup* backup_;
};

bool copy_pages(sqlite3* from, sqlite3* to, const CheckStep& step) {
  Transaction snapshot(from, Transaction::Kind::read);
  Statement(from, "SELECT count(*) FROM sqlite_schema").step();
  Copy copy(from, to);
  for (int pieces = 1;; ++pieces) {
    const auto begin = Clock::now();
    if (!copy.piece()) return true;
    if (pieces % kPiecesPerSync == 0) sync_database(to);
    if (!step(kCopyShare * copy.share())) return false;
    std::this_thread::sleep_for(Clock::now() - begin);
  }
}

// The copy needs no log beside it, so that it can be read where nothing can be written.
void leave_alone(sqlite3* copy) {
  execute(copy, "PRAGMA journal_mode = DELETE");
  sync_database(copy);
}

Result<std::string> sha256_of(const fs::path& file, const CheckStep& step, double from, bool& ended) {
  std::error_code error;
  const auto size = static_cast<double>(std::max<std::uintmax_t>(1, fs::file_size(file, error)));
  std::ifstream stream(file, std::ios::binary);
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  if (error || !stream || context == nullptr || EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) != 1)
    return Error{ErrorKind::io, file.string() + " cannot be read", {}};
  std::vector<char> piece(std::size_t{1} << 20U);
  double done = 0;
  while (stream) {
    stream.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    const auto got = static_cast<std::size_t>(stream.gcount());
    if (stream.bad()) return Error{ErrorKind::io, file.string() + " cannot be read", {}};
    EVP_DigestUpdate(context.get(), piece.data(), got);
    done += static_cast<double>(got);
    ended = !step(from + (1.0 - from) * std::min(1.0, done / size));
    if (ended) return std::string();
  }
  std::array<unsigned char, 32> digest{};
  EVP_DigestFinal_ex(context.get(), digest.data(), nullptr);
  std::string text;
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (const unsigned char byte : digest) (text += kDigits[byte / 16U]) += kDigits[byte % 16U];
  return text;
}

std::string compact_utc(std::int64_t utc_ns) {
  const std::time_t seconds = utc_ns / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &parts)};
}

Status check_target(const fs::path& folder, std::uint64_t bytes) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return Error{ErrorKind::not_found, "the folder " + folder.string() + " is not there: is the USB stick plugged in?", "folder"};
  struct statvfs space {};
  struct statfs kind {};
  if (::statvfs(folder.c_str(), &space) != 0 || ::statfs(folder.c_str(), &kind) != 0)
    return io_error("the folder " + folder.string() + " cannot be used", last_error());
  if ((space.f_flag & ST_RDONLY) != 0)
    return Error{ErrorKind::read_only, "the folder " + folder.string() + " is on a read-only disk", "folder"};
  if (::access(folder.c_str(), W_OK) != 0)
    return Error{ErrorKind::read_only, "the folder " + folder.string() + " may not be written: " + last_error().message(), "folder"};
  const std::uint64_t free = static_cast<std::uint64_t>(space.f_bavail) * space.f_frsize;
  const auto megabytes = [](std::uint64_t count) { return std::to_string((count >> 20U) + 1) + " MB"; };
  if (free < bytes + kReserve_bytes)
    return Error{ErrorKind::disk_full,
                 "the backup needs " + megabytes(bytes + kReserve_bytes) + ", " + folder.string() + " has " + megabytes(free) + " free",
                 "folder"};
  if (kind.f_type == MSDOS_SUPER_MAGIC && bytes > kFat32Most_bytes)
    return Error{ErrorKind::disk_full,
                 folder.string() + " is formatted as FAT32, which holds no file above 4 GB: format it as exFAT or ext4", "folder"};
  return {};
}

json manifest_of(const BackupInfo& info) {
  json files = json::array();
  for (const BackupFile& file : info.files) files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return {{"hoist_backup", kManifestVersion},
          {"device", info.device},
          {"hoist_id", info.hoist_id},
          {"program", info.program},
          {"utc_ns", info.utc_ns},
          {"schema", info.schema_version},
          {"sessions", info.sessions},
          {"newest_session", info.newest_session},
          {"files", std::move(files)}};
}

Status write_text(const fs::path& file, const std::string& text) {
  const Descriptor descriptor(file, O_WRONLY | O_CREAT | O_TRUNC);
  if (!descriptor || ::write(descriptor.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      ::fsync(descriptor.get()) != 0)
    return io_error(file.string() + " could not be written", last_error());
  return {};
}

std::optional<BackupInfo> read_manifest(const fs::path& folder) {
  // A stick may hold anything.
  constexpr std::uintmax_t kMost_bytes = 1 << 20;
  std::error_code error;
  if (const auto size = fs::file_size(folder / kBackupManifest, error); error || size > kMost_bytes) return std::nullopt;
  std::ifstream stream(folder / kBackupManifest);
  const json text = json::parse(stream, nullptr, false);
  if (text.is_discarded() || !text.is_object() || text.value("hoist_backup", json()) != kManifestVersion) return std::nullopt;
  try {
    BackupInfo info{.folder = folder,
                    .device = text.at("device").get<std::string>(),
                    .program = text.at("program").get<std::string>(),
                    .hoist_id = text.value("hoist_id", ""),
                    .utc_ns = text.at("utc_ns").get<std::int64_t>(),
                    .schema_version = text.at("schema").get<int>(),
                    .sessions = text.at("sessions").get<std::uint64_t>(),
                    .newest_session = text.at("newest_session").get<SessionId>(),
                    .files = {}};
    for (const json& file : text.at("files"))
      info.files.push_back(
          {file.at("name").get<std::string>(), file.at("bytes").get<std::uint64_t>(), file.at("sha256").get<std::string>()});
    return info;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

// One file of a backup, with its hash. False when it was ended.
Result<bool> add_file(BackupInfo& info, const fs::path& file, const CheckStep& step) {
  std::error_code error;
  bool ended = false;
  forget_cached(file);
  auto hash = sha256_of(file, step, kCheckShare, ended);
  if (!hash) return hash.error();
  if (ended) return false;
  info.files.push_back({file.filename().string(), fs::file_size(file, error), std::move(*hash)});
  return true;
}

// A database of another kind: its pages only, and its structure checked.
Result<bool> copy_other(const fs::path& file, const fs::path& to, const CheckStep& step) {
  return guarded([&]() -> Result<bool> {
    const auto opened = [](const fs::path& path, int flags) {
      sqlite3* handle = nullptr;
      const int code = sqlite3_open_v2(path.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | flags, nullptr);
      std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> owned(handle, &sqlite3_close_v2);
      if (code != SQLITE_OK) throw_sql(handle, code, "opening " + path.string());
      sqlite3_busy_timeout(handle, kBusyTimeout_ms);
      return owned;
    };
    {
      const auto source = opened(file, 0), copy = opened(to, SQLITE_OPEN_CREATE);
      fs::permissions(to, fs::perms::owner_read | fs::perms::owner_write);
      if (!copy_pages(source.get(), copy.get(), step)) return false;
      leave_alone(copy.get());
    }
    forget_cached(to);
    const auto written = opened(to, 0);
    Statement check(written.get(), "PRAGMA integrity_check(1)");
    if (!check.step() || check.text_at(0) != "ok") return Error{ErrorKind::corrupt, "the copy of " + file.string() + " is damaged", {}};
    return true;
  });
}

// Into the folder that is not complete yet. False when it was ended.
Result<bool> write_backup(Database& recordings, const BackupOptions& options, const fs::path& part, BackupInfo& info,
                          const CheckStep& step) {
  const fs::path copy = part / kBackupRecordings;
  if (auto copied = copy_database(recordings, copy, step); !copied || !*copied) return copied;
  {
    // Of the copy, which the source has outgrown meanwhile.
    auto written = Database::inspect(copy);
    if (!written) return written.error();
    info.schema_version = written->report().schema_version;
    if (Status counted = guarded([&]() -> Status {
          info.sessions = number_of(written->handle(), "SELECT count(*) FROM sessions");
          info.newest_session =
              static_cast<SessionId>(number_of(written->handle(), "SELECT max(id) FROM sessions WHERE ended_utc_ns IS NOT NULL"));
          // It goes on as another file, or on another hoist.
          info.hoist_id = hoist_id(written->handle());
          set_hoist_id(written->handle(), {});
          return {};
        });
        !counted)
      return counted.error();
  }
  if (auto added = add_file(info, copy, step); !added || !*added) return added;
  std::error_code error;
  for (const fs::path& file : options.databases) {
    if (!fs::exists(file, error)) continue;
    const fs::path to = part / file.filename();
    // Small: it counts as the end of the progress.
    const CheckStep at_end = [&step](double) { return step(1.0); };
    if (auto copied = copy_other(file, to, at_end); !copied || !*copied) return copied;
    if (auto added = add_file(info, to, at_end); !added || !*added) return added;
  }
  for (const fs::path& file : options.files) {
    if (!fs::exists(file, error)) continue;
    const fs::path to = part / file.filename();
    if (!fs::copy_file(file, to, error)) return io_error(file.string() + " could not be copied", error);
    if (Status synced = sync(to, O_RDONLY); !synced) return synced.error();
    if (auto added = add_file(info, to, step); !added || !*added) return added;
  }
  if (Status wrote = write_text(part / kBackupManifest, manifest_of(info).dump(1)); !wrote) return wrote.error();
  if (Status synced = sync(part, O_RDONLY | O_DIRECTORY); !synced) return synced.error();
  return true;
}

// The file of recordings that a backup's path means.
fs::path recordings_in(const fs::path& backup) {
  std::error_code error;
  return fs::is_directory(backup, error) ? backup / kBackupRecordings : backup;
}

Status check_hash(const fs::path& backup, const CheckStep& step, bool& ended) {
  std::error_code error;
  if (!fs::is_directory(backup, error)) return {};
  const Error damaged{ErrorKind::corrupt, "the backup " + backup.string() + " is incomplete or damaged", {}};
  const auto info = read_manifest(backup);
  if (!info) return damaged;
  const auto row = std::ranges::find(info->files, std::string(kBackupRecordings), &BackupFile::name);
  if (row == info->files.end()) return damaged;
  auto hash = sha256_of(backup / kBackupRecordings, step, 0.0, ended);
  if (!hash) return hash.error();
  if (!ended && *hash != row->sha256) return damaged;
  return {};
}

}  // namespace

std::string clean_device(std::string_view name) {
  std::string clean;
  for (const char c : name.substr(0, kMaxDevice_bytes)) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    clean += plain ? c : '-';
  }
  return clean.empty() ? "unnamed" : clean;
}

Result<bool> copy_database(Database& from, const fs::path& to, const CheckStep& step, const char* vfs) {
  return guarded([&]() -> Result<bool> {
    {
      auto target = Database::create_copy(to, {.vfs = vfs});
      if (!target) return target.error();
      if (vfs == nullptr) fs::permissions(to, fs::perms::owner_read | fs::perms::owner_write);
      if (!copy_pages(from.handle(), target->handle(), step)) return false;
      leave_alone(target->handle());
    }
    if (vfs == nullptr) forget_cached(to);
    auto written = Database::inspect(to, {.vfs = vfs});
    if (!written) return written.error();
    auto report = check_integrity(*written, [&](double share) { return step(kCopyShare + (kCheckShare - kCopyShare) * share); });
    if (!report) return report.error();
    if (!*report) return false;
    if (!(*report)->structure.empty())
      return Error{ErrorKind::corrupt, "the copy " + to.string() + " is damaged: " + (*report)->structure.front(), {}};
    return true;
  });
}

Result<std::optional<BackupInfo>> back_up(Database& recordings, const BackupOptions& options, const CheckStep& step) {
  std::uint64_t bytes = 0;
  if (Status sized = guarded([&]() -> Status {
        bytes = number_of(recordings.handle(), "PRAGMA page_count") * number_of(recordings.handle(), "PRAGMA page_size");
        return {};
      });
      !sized)
    return sized.error();
  if (Status fit = check_target(options.folder, bytes); !fit) return fit.error();
  BackupInfo info{.folder = {}, .device = options.device, .program = options.program, .utc_ns = options.utc_ns, .files = {}};
  const std::string prefix = std::string(kBackupPrefix) + options.device + "-";
  std::error_code error;
  // Of a program that was killed; this device writes one at a time.
  std::vector<fs::path> stale;
  for (fs::directory_iterator entry(options.folder, error), end; !error && entry != end; entry.increment(error))
    if (const std::string name = entry->path().filename().string(); name.starts_with(prefix) && name.ends_with(kPart))
      stale.push_back(entry->path());
  for (const fs::path& path : stale) fs::remove_all(path, error);
  info.folder = options.folder / (prefix + compact_utc(options.utc_ns));
  const fs::path part = info.folder.string() + std::string(kPart);
  if (fs::exists(info.folder, error)) return Error{ErrorKind::busy, "there is a backup of this second already", {}};
  if (!fs::create_directory(part, error)) return io_error(part.string() + " could not be made", error);
  fs::permissions(part, fs::perms::owner_all, error);
  auto written = write_backup(recordings, options, part, info, step);
  if (written && *written) {
    fs::rename(part, info.folder, error);
    if (!error) {
      if (Status synced = sync_folder_of(info.folder); !synced) return synced.error();
      // The backup is good without this row; retention only does not count on it.
      (void)note_backup(recordings, info.utc_ns, info.folder, info.newest_session);
      return std::optional(std::move(info));
    }
    written = io_error(part.string() + " could not get its name", error);
  }
  fs::remove_all(part, error);
  if (!written) return written.error();
  return std::optional<BackupInfo>{};
}

std::vector<BackupInfo> list_backups(const fs::path& folder) {
  std::vector<BackupInfo> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(kBackupPrefix) || name.ends_with(kPart)) continue;
    if (auto info = read_manifest(entry->path())) found.push_back(std::move(*info));
  }
  std::ranges::sort(found, std::ranges::greater{}, &BackupInfo::utc_ns);
  return found;
}

Result<std::optional<fs::path>> prepare_restore(const fs::path& backup, const fs::path& file, const CheckStep& step) {
  const fs::path from = recordings_in(backup), prepared = file.string() + std::string(kPrepared);
  std::error_code error;
  if (!fs::exists(from, error)) return Error{ErrorKind::not_found, "there is no backup " + backup.string(), "backup"};
  bool ended = false;
  constexpr double kHashShare = 0.2;
  if (Status sound = check_hash(
          backup, [&](double share) { return step(kHashShare * share); }, ended);
      !sound)
    return sound.error();
  if (ended) return std::optional<fs::path>{};
  fs::remove(prepared, error);
  const auto copied = [&]() -> Result<bool> {
    auto source = Database::inspect(from);
    if (!source) return source.error();
    // A stick may hold anything, and this file is to be written into.
    if (auto acts = guarded([&]() -> Result<bool> {
          return number_of(source->handle(), "SELECT count(*) FROM sqlite_schema WHERE type IN ('trigger', 'view')") > 0;
        });
        !acts || *acts)
      return acts ? Error{ErrorKind::foreign, from.string() + " has triggers or views, which no Hoist has written", {}} : acts.error();
    return copy_database(*source, prepared, [&](double share) { return step(kHashShare + (1 - kHashShare) * share); });
  }();
  if (!copied || !*copied) {
    fs::remove(prepared, error);
    if (!copied) return copied.error();
    return std::optional<fs::path>{};
  }
  // The seal knows the last number also when the present file cannot be read.
  const auto sealed = Seal::read(file);
  SessionId last_given = sealed ? sealed->session : 0;
  DeviceSettings here;
  if (auto present = Database::inspect(file)) {
    (void)guarded([&]() -> Status {
      last_given = std::max(last_given, last_session_number(present->handle()));
      return {};
    });
    if (auto read = device_settings(*present)) here = std::move(*read);
  }
  // Another file from now on: the seal beside the present one says nothing of it.
  auto named = Database::inspect(prepared);
  if (!named) return named.error();
  if (Status renamed = guarded([&]() -> Status {
        if (Status migrated = named->migrate(); !migrated) return migrated;
        execute(named->handle(), "UPDATE seal SET file_id = lower(hex(randomblob(8)))");
        take_session_numbers(named->handle(), last_given);
        // What was brought back must not be deleted by a rule of that time.
        execute(named->handle(), "DELETE FROM settings WHERE name = 'retention'");
        // The backup may be of another hoist: this one keeps its id and its name, or gets a new id when the file is opened.
        set_hoist_id(named->handle(), here.hoist_id);
        if (!here.hoist_id.empty()) set_device_settings(named->handle(), here);
        return {};
      });
      !renamed)
    return renamed.error();
  return std::optional(prepared);
}

Result<fs::path> finish_restore(const fs::path& prepared, const fs::path& file, std::int64_t utc_ns,
                                const std::function<void()>& before_each_change) {
  const auto change = [&] {
    if (before_each_change) before_each_change();
  };
  std::error_code error;
  fs::path aside;
  if (fs::exists(file, error)) {
    // With its log written back the old file is whole by itself. A damaged one keeps its log beside it.
    change();
    if (Status alone = Database::leave_log(file); !alone && alone.error().kind != ErrorKind::corrupt) return alone.error();
    const std::string base = file.string() + std::string(kReplacedInfix) + compact_utc(utc_ns);
    aside = base;
    for (int i = 1; fs::exists(aside, error); ++i) aside = base + "-" + std::to_string(i);
    change();
    fs::create_hard_link(file, aside, error);
    if (error) return io_error(file.string() + " could not be kept as " + aside.string(), error);
    for (const char* suffix : kKeptWith) {
      const fs::path from = file.string() + suffix;
      if (!fs::exists(from, error)) continue;
      change();
      fs::rename(from, aside.string() + suffix, error);
      if (error) return io_error(from.string() + " could not be kept", error);
    }
    fs::remove(file.string() + "-shm", error);
  }
  if (Status given = give_to_owner(prepared, file); !given) return given.error();
  if (Status synced = sync_folder_of(file); !synced) return synced.error();
  change();
  fs::rename(prepared, file, error);
  if (error) return io_error(prepared.string() + " could not take the place of " + file.string(), error);
  change();
  if (Status synced = sync_folder_of(file); !synced) return synced.error();
  return aside;
}

}  // namespace hoist::db
