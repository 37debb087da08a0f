// A disk in memory whose power can be cut: an SQLite VFS that knows which writes have been synced. At the cut each write that was not synced is
// kept, dropped or torn by 512-byte sectors at random; then the survivors are all there is. kill -9 cannot show this, because the kernel keeps
// what a dead process wrote. It may also be full, or fail now and then.
//
// Simplified: a file's creation and deletion are durable at once, and one process uses it. Each thread has its own disk.
#pragma once
#include <cstdint>
#include <random>
#include <string>

namespace hoist::tests {

/// One at a time in each thread; the VFS is registered under its name.
class CrashDisk {
 public:
  explicit CrashDisk(std::uint32_t seed);
  ~CrashDisk();
  CrashDisk(const CrashDisk&) = delete;
  CrashDisk& operator=(const CrashDisk&) = delete;

  [[nodiscard]] static const char* vfs_name();
  /// The power goes at the n-th write, truncation or sync from now; every operation from then on fails. 0 = never.
  void cut_after(std::uint64_t operations);
  [[nodiscard]] bool is_cut() const;
  [[nodiscard]] std::uint64_t operations() const;
  /// From now on every operation fails, as for a process that is gone.
  void cut_now();
  /// The power comes back: unsynced writes meet their fate. All connections must be closed.
  void restart();
  /// Another process after one that was killed: the kernel has kept everything that was written.
  void restart_process();
  /// No file grows any more.
  void fill(bool full);
  /// This share of all writes, truncations and syncs fails; 0 ends it.
  void fail(double share);
  /// A disk that says "synced" and has not: to show that the test would notice.
  void ignore_syncs(bool ignore);
};

}  // namespace hoist::tests
