// A disk in memory whose power can be cut: an SQLite VFS that records which writes have been synced. At the cut each unsynced write is
// kept, dropped or torn by 512-byte sectors at random. kill -9 cannot show this, because the kernel keeps a dead process's writes. It may
// also be full, or fail at times.
//
// Simplified: a file's creation and deletion are durable at once, and one process uses it. Each thread has its own disk.
#pragma once
#include <cstdint>
#include <map>
#include <random>
#include <string>

namespace hoist::tests {

/// One at a time in each thread; the VFS is registered under its name.
class CrashDisk {
 public:
  /// Files by name, all synced.
  using Image = std::map<std::string, std::string>;
  explicit CrashDisk(std::uint32_t seed, const Image& image = {});
  ~CrashDisk();
  CrashDisk(const CrashDisk&) = delete;
  CrashDisk& operator=(const CrashDisk&) = delete;

  [[nodiscard]] static const char* vfs_name();
  /// What is on it, for other disks to begin with. All connections must be closed.
  [[nodiscard]] Image image() const;
  /// Power cut at the n-th write, truncation or sync from now; every operation from then on fails. 0 = never.
  void cut_after(std::uint64_t operations);
  [[nodiscard]] bool is_cut() const;
  [[nodiscard]] std::uint64_t operations() const;
  /// A file gets another name, durable at once, in place of the one that had it. False when the power is off.
  bool rename(const std::string& from, const std::string& to);
  /// From now on every operation fails, as after a process's death.
  void cut_now();
  /// Power returns: unsynced writes are kept, dropped or torn. All connections must be closed.
  void restart();
  /// A new process after one was killed: the kernel has kept all writes.
  void restart_process();
  /// No file grows any more.
  void fill(bool full);
  /// This share of all writes, truncations and syncs fails; 0 ends it.
  void fail(double share);
  /// A disk that reports "synced" and has not: shows that the test would notice.
  void ignore_syncs(bool ignore);
};

}  // namespace hoist::tests
