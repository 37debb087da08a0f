// Backups of the file of recordings, and putting one back. A backup is a folder hoist-DEVICE-DATE with recordings.db and manifest.json; until it
// is complete and checked its name ends in .part.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

inline constexpr std::string_view kBackupPrefix = "hoist-", kBackupRecordings = "recordings.db", kBackupManifest = "manifest.json";
inline constexpr std::size_t kMaxDevice_bytes = 32;

/// Copies a database that may be written meanwhile, as it is at one moment, and checks the copy: every page, every blob. Between two pieces it
/// rests as long as a piece took, so that half of the disk's time is left to others. It holds a read transaction while it copies: the log grows
/// meanwhile. False when `step` (called with 0 to 1) ended it; then, and after an error, the copy is of no use.
/// Errors: disk_full, read_only, io, corrupt (the source, or the copy as it was read back), busy.
Result<bool> copy_database(Database& from, const std::filesystem::path& to, const CheckStep& step, const char* vfs = nullptr);

struct BackupFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::string sha256;  ///< hexadecimal
};
/// What manifest.json says.
struct BackupInfo {
  std::filesystem::path folder;  ///< of the backup itself
  std::string device, program;   ///< name of the computer, and version of the program that wrote it
  std::string hoist_id = {};     ///< of the hoist; empty in a backup from before hoists had one
  std::int64_t utc_ns = 0;
  int schema_version = 0;
  std::uint64_t sessions = 0;
  SessionId newest_session = 0;  ///< that had ended; 0 = none
  std::vector<BackupFile> files;
};

struct BackupOptions {
  std::filesystem::path folder;  ///< where the backup's own folder is made
  std::string device;            ///< letters, digits and - only (clean_device)
  std::string program;
  std::int64_t utc_ns = 0;
  /// Further databases that are copied beside the recordings, and plain files; by their file names. One that does not exist is left out.
  std::vector<std::filesystem::path> databases = {}, files = {};
};

/// The name of a computer, made fit for a folder's name.
std::string clean_device(std::string_view name);

/// Writes a checked backup. Nothing when `step` ended it; what it had written is removed then, as after an error, and at the next backup when
/// the program was killed.
/// Errors: not_found (no such folder), read_only, disk_full (also: a FAT32 stick cannot hold the file), io, corrupt, busy.
Result<std::optional<BackupInfo>> back_up(Database& recordings, const BackupOptions& options, const CheckStep& step);

/// The complete backups in a folder, newest first; empty when there is none or no such folder.
std::vector<BackupInfo> list_backups(const std::filesystem::path& folder);

/// First half of a restore, which leaves the hoist's id and name as they are (hoist_id.hpp): copies the recordings of a backup (its folder, or a
/// database file) beside `file` and checks them: ours, no newer
/// schema, the manifest's hash, every page, every blob. The file in use is not touched. The copy's name; nothing when `step` ended it.
/// Errors: not_found, foreign, newer_schema, corrupt, disk_full, io.
Result<std::optional<std::filesystem::path>> prepare_restore(const std::filesystem::path& backup, const std::filesystem::path& file,
                                                             const CheckStep& step);
/// Second half: the copy takes the place of `file`, which is kept under a name with the date. One change of a name decides: whenever the program
/// or the power ends, `file` is the old one or the new one. The caller holds the lock and has closed its connections. The name of the old file;
/// empty when there was none.
/// Errors: busy (another program reads the file), io. Then the old file is in use as before.
Result<std::filesystem::path> finish_restore(const std::filesystem::path& prepared, const std::filesystem::path& file, std::int64_t utc_ns,
                                             const std::function<void()>& before_each_change = {});

}  // namespace hoist::db
